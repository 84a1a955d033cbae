"""The form of a scenario file: which keys it may have, of which type, in which range, and what they mean.

This is what pydantic checks and what the JSON schema is made of. Units: [length] and [angle] are those that the file
declares; time is in seconds, and gains are in the units of the Python API.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from stillreach.simulation.scenario_file.fault_forms import FAULTS, FaultChoice
from stillreach.simulation.scenario_file.forms import (
    MOST_PARTS,
    Intervals,
    Limit,
    Limits,
    NotNegative,
    Start,
    Table,
    Time,
    UnitsTable,
    exactly,
)
from stillreach.simulation.scenario_file.law_forms import LAWS, NULL_MOTIONS, LawChoice, NullMotionChoice
from stillreach.simulation.scenario_file.motion_forms import MOTIONS, MotionTable
from stillreach.simulation.scenario_file.robot_forms import Robot
from stillreach.simulation.scenario_file.task_forms import TaskTable

Motions = Annotated[list[MotionTable], Field(min_length=1, max_length=MOST_PARTS)]
Faults = Annotated[list[FaultChoice], Field(max_length=MOST_PARTS)]


class ScenarioTable(Table):
    """A scenario: which arm starts where, what it is told, what breaks and when."""

    name: Annotated[str, Field(max_length=200)] = Field("", description="Title of plots and files.")
    description: Annotated[str, Field(max_length=10_000)] = Field("", description="What it shows, for readers.")
    units: UnitsTable = Field(UnitsTable(length="m", angle="rad"), description="Units of this file.")
    robot: Robot = Field(description="The arm.")
    start: Start = Field(
        description="Joint values at time 0 [angle, or length for slides]: all, or by name (others 0)."
    )
    motion: Motions = Field(description="What the tool is to do, in order.")
    faults: Faults = Field([], description="What fails when.")
    law: LawChoice | None = Field(None, description="How the rates are found; least-error if absent.")
    task: TaskTable | None = Field(None, description="Which part of the motion is the task; the whole pose if absent.")
    null_motion: NullMotionChoice | None = Field(None, description="What the freedom that is left is used for.")
    period: Time = Field(0.01, description="Time between ticks [s].")
    duration: Time | None = Field(None, description="How long in all [s]; as long as the motion if absent.")
    integrator: Literal["euler", "rk4"] = Field("euler", description="How the arm is moved from tick to tick.")
    loop: Literal["open", "closed"] = Field("open", description="Whether the tool's pose is fed back.")
    clock: Literal["time", "arm"] = Field("time", description="Whether the motion goes on without the arm.")
    track_gain: NotNegative | None = Field(None, description="Gain of the feedback [1/s]; 2 if absent.")
    track_limits: Annotated[list[Limit], *exactly(2)] | None = Field(
        None, description="Largest correction [length/s, angle/s]; what one joint can do if absent."
    )
    velocity_limits: Limits | None = Field(
        None, description="In place of the arm's own [angle/s, or length/s for slides]."
    )
    position_limits: Intervals | None = Field(None, description="Lower and upper, in place of the arm's own.")
    acceleration_limits: Limits | None = Field(None, description="In place of the arm's own [angle/s², length/s²].")
    return_rate: NotNegative = Field(0.0, description="At which joints outside their limits are asked back [angle/s].")
    allow_outside: bool = Field(
        False, description="Take a start outside the position limits, and goals beyond the arm's reach."
    )
    transition_rate: NotNegative = Field(2.0, description="How fast the null motion takes over after a fault [1/s].")


CHOICES: dict[str, dict[str, type[Table]]] = {
    "motion": MOTIONS,
    "faults": FAULTS,
    "law": LAWS,
    "null_motion": NULL_MOTIONS,
}
"""The kinds of each table that has a kind, by its key."""
