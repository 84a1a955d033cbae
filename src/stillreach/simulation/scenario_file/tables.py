"""The table of a scenario file: the arguments of Scenario, most of them tables or kinds."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach._forms import INF, TIME, Either, Flag, Number, Text, Word
from stillreach._kinds import Key, keys_for
from stillreach._lists import LOWER_FIRST, MOST_JOINTS, NOT_ALL_ZERO, Check, List, PerJoint
from stillreach._reading import Reading
from stillreach._tables import Choice, Table, tables_of
from stillreach._units import ANGLES, LENGTHS
from stillreach.errors import InputError
from stillreach.faults import fault_tables
from stillreach.laws import LAWS
from stillreach.null_motions import NULL_MOTIONS
from stillreach.plants import PLANTS
from stillreach.simulation.motion import MOTIONS
from stillreach.simulation.orientation import ORIENTATION
from stillreach.simulation.scenario import CLOCKS, INTEGRATORS, LOOPS, Scenario
from stillreach.simulation.scenario_file.robots import ROBOT
from stillreach.task import FRAMES, ROWS, Task, Weights

MOST_PARTS = 200
NOT_NEGATIVE = Number(least=0.0)
SQUARE: Check = (lambda rows: all(len(row) == len(rows) for row in rows), "a square matrix, a list for each row")


def limit(unit: str) -> Number:
    """A limit, which may be infinite."""
    return Number(unit, least=0.0, most=INF)


def _units(values: dict[str, Any], reading: Reading) -> None:
    reading.length = LENGTHS[values.get("length", "m")]
    reading.angle = ANGLES[values.get("angle", "rad")]


def _tool(values: dict[str, Any], reading: Reading) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = values.get("position", (0.0, 0.0, 0.0))
    T[:3, :3] = values.get("orientation", np.eye(3))
    return T


def _weights(values: dict[str, Any], reading: Reading) -> Weights:
    weights = Weights(**values)
    arm, joints = reading.arm, weights.joints
    if arm is not None and joints is not None and len(joints) != arm.n:
        raise InputError("joints", f"weights of {len(joints)} joints", f"{arm.n}, one for each joint of {arm.name}")
    return weights


def _weight(least: int = 1, most: int = MOST_JOINTS) -> Either:
    """A vector or a matrix."""
    vector = List(NOT_NEGATIVE, least=least, most=most)
    return Either(vector, List(List(Number()), least=least, most=most, check=SQUARE))


def _scenario(values: dict[str, Any], reading: Reading) -> dict[str, Any]:
    """The arguments of Scenario."""
    values.pop("units", None)
    if "track_limits" in values:
        values["track_limits"] = tuple(values["track_limits"])
    return {"arm": values.pop("robot"), **values}


UNITS = Table(
    "Units",
    "Units of the numbers in this file. Time is in seconds always.",
    {
        "length": Key(Word(*LENGTHS), "Unit of lengths and positions", "m"),
        "angle": Key(Word(*ANGLES), "Unit of angles", "rad"),
    },
    _units,
)
TOOL = Table(
    "Tool",
    "The task's point and axes in the frame of the arm's tool.",
    {
        "position": Key(List(*[Number("length")] * 3), "The point; that of the tool if absent", None),
        "orientation": Key(ORIENTATION, "Its axes; those of the tool if absent", None),
    },
    _tool,
)
WEIGHTS = Table(
    "Weights",
    "Units of task errors and joint rates, and weights of rows and joints.",
    {
        "length": Key(Number("length", above=0.0), "Unit of length; one metre if absent", None),
        "angle": Key(Number("angle", above=0.0), "Unit of angle; one radian if absent", None),
        "task": Key(_weight(6, 6), "Weights of the squared task error: 6, or 6 lists of 6", None),
        "joints": Key(_weight(), "Weights of the squared rates: one a joint, or a matrix", None),
    },
    _weights,
)
TASK = Table(
    "Task",
    "Which part of the motion is the task, at which point.",
    keys_for(
        Task,
        rows=(
            Either(Word(*ROWS), List(*[Flag()] * 6, check=NOT_ALL_ZERO)),
            "The rows, or six booleans for vx, vy, vz, wx, wy, wz",
        ),
        frame=(Word(*FRAMES), "The axes of the rows"),
        tool=(TOOL, "The task's point; the arm's tool if absent"),
        weights=(WEIGHTS, "Units and weights of task errors and rates"),
    ),
    lambda values, reading: Task(**values),
)
POSITIONS = List(*[Number("joint", least=-INF, most=INF)] * 2, check=LOWER_FIRST)
SCENARIO = Table(
    "Scenario",
    "A scenario: arm, start, motion and faults.",
    keys_for(
        Scenario,
        name=(Text(0, 200), "Title of plots and files"),
        description=(Text(0, 10_000), "Description for readers"),
        robot=(ROBOT, "The arm"),
        start=(PerJoint(Number("joint")), "Joint values at time 0: all, or by name, 0 for the others"),
        motion=(List(Choice(tables_of(MOTIONS)), most=MOST_PARTS), "Motions of the tool, in order"),
        faults=(List(Choice(fault_tables()), least=0, most=MOST_PARTS), "Faults"),
        plant=(Choice(tables_of(PLANTS)), "What the arm makes of the rates that it is told; exactly that if absent"),
        law=(Choice(tables_of(LAWS)), f"The law; {LAWS[0].word} if absent"),
        task=(TASK, "Which part of the motion is the task; the whole pose if absent"),
        null_motion=(Choice(tables_of(NULL_MOTIONS)), "Use of the remaining freedom"),
        period=(TIME, "Time between ticks"),
        duration=(TIME, "Total duration; that of the motion if absent"),
        integrator=(Word(*INTEGRATORS), "Integration from tick to tick"),
        loop=(Word(*LOOPS), "Whether the tool's pose is fed back"),
        clock=(Word(*CLOCKS), "Whether the motion waits for the arm"),
        track_gain=(Number("1/s", least=0.0), "Gain of the feedback"),
        track_limits=(List(limit("length/s"), limit("angle/s")), "Largest correction; what one joint can do if absent"),
        velocity_limits=(
            PerJoint(limit("joint/s"), one_for_all=True, others="velocity_limits"),
            "Instead of the arm's own",
        ),
        position_limits=(
            PerJoint(POSITIONS, one_for_all=True, others="position_limits"),
            "Lower and upper, instead of the arm's own",
        ),
        acceleration_limits=(
            PerJoint(limit("joint/s²"), one_for_all=True, others="acceleration_limits"),
            "Instead of the arm's own",
        ),
        return_rate=(Number("arm/s", least=0.0), "Rate at which joints outside their limits return"),
        allow_outside=(Flag(), "Accept a start outside the position limits, and goals beyond the arm's reach"),
        transition_rate=(Number("1/s", least=0.0), "Rate at which the null motion fades in after a fault"),
    ),
    _scenario,
)
# units and arm are read first: other values depend on them
SCENARIO.keys = {"units": Key(UNITS, "Units of this file", None), "robot": SCENARIO.keys["robot"], **SCENARIO.keys}
