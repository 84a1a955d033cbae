"""Law, task, null motion and limits of a scenario file."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach.arm import Arm
from stillreach.errors import InputError
from stillreach.laws import KeepDirection, Law, LeastError, Pseudoinverse, SingularityRobust
from stillreach.null_motions import Centring, Manipulability, NullMotion, Posture, Rates
from stillreach.simulation.scenario_file.motions import rotation
from stillreach.simulation.scenario_file.reading import Reading
from stillreach.simulation.scenario_file.units import Units
from stillreach.simulation.scenario_file.words import shown
from stillreach.task import Task, Weights

LAWS: dict[str, type[Law]] = {
    "least-error": LeastError,
    "singularity-robust": SingularityRobust,
    "keep-direction": KeepDirection,
    "pseudoinverse": Pseudoinverse,
}


NULL_MOTIONS: dict[str, type[NullMotion]] = {
    "manipulability": Manipulability,
    "centring": Centring,
    "posture": Posture,
    "rates": Rates,
}


def law_of(reading: Reading) -> Law | None:
    """The law; None for the default, or after recording the mistakes."""
    table = reading.value("law")
    if table is None:
        return None
    settings = {key: value for key, value in table.items() if key != "kind"}
    if settings.get("price") == "none":
        settings["price"] = None
    try:
        return LAWS[table["kind"]](**settings)
    except InputError as error:  # prices of rows that do not exist, or of a row twice
        reading.refused(("law",), error)
        return None


def task_of(reading: Reading) -> Task | None:
    """The task; None for the default."""
    weights = _weights(reading)
    table = reading.value("task")
    if table is None:
        return None
    settings = {key: table[key] for key in ("rows", "frame") if key in table}
    tool = _tool(table["tool"], reading.units) if "tool" in table else None
    return Task(tool=tool, weights=weights, **settings)


def check_price(reading: Reading, law: Law | None, task: Task | None) -> None:
    """Prices by rows fit the rows and the weights of the task."""
    if law is None or not reading.good("task"):
        return
    task = task or Task()
    try:
        law.core(task.row_names, reach=1.0, weights=task.weights)
    except InputError as error:
        reading.refused(("law",) if error.argument == "price" else ("task",), error)


def check_joint_weights(reading: Reading, arm: Arm) -> None:
    """As many weights of joints as there are joints."""
    weights = reading.value("task", "weights", "joints")
    if weights is not None and len(weights) != arm.n:
        got, expected = f"weights of {len(weights)} joints", f"{arm.n}, one for each joint of {arm.name}"
        reading.wrong(("task", "weights", "joints"), got, expected)


def _tool(table: dict[str, Any], units: Units) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = np.array(table.get("position", (0.0, 0.0, 0.0)), dtype=float) * units.length
    if "orientation" in table:
        T[:3, :3] = rotation("tool.orientation", table["orientation"], units)
    return T


def _weights(reading: Reading) -> Weights | None:
    """Units and weights; what is no weight is a mistake of its own, whatever else is wrong with the task."""
    settings: dict[str, Any] = {}
    for key in ("length", "angle", "task", "joints"):
        value = reading.value("task", "weights", key)
        if value is None:
            continue
        settings[key] = value * getattr(reading.units, key) if key in ("length", "angle") else value
        try:
            Weights(**{key: settings[key]})
        except InputError as error:
            reading.wrong(("task", "weights", key), shown(value), error.expected)
    six = settings.get("task")
    if six is not None and len(six) != 6:
        reading.wrong(("task", "weights", "task"), f"weights of {len(six)} rows", "6, for vx, vy, vz, wx, wy, wz")
    return Weights(**settings) if reading.has("task", "weights") else None


def null_motion_of(reading: Reading, arm: Arm) -> NullMotion | None:
    """The null motion; None for none."""
    factors = reading.units.joints(arm.kinds)
    vectors = {key: reading.joint_values(("null_motion", key), arm, factors, np.zeros(arm.n)) for key in ("q", "rates")}
    table = reading.value("null_motion")
    if table is None:
        return None
    kind: Any = NULL_MOTIONS[table["kind"]]
    settings: dict[str, Any] = {"gain": table["gain"]} if "gain" in table else {}
    if "max_rate" in table:
        settings["max_rate"] = table["max_rate"] * reading.units.largest_rate(arm.kinds)
    settings |= {key: vector for key, vector in vectors.items() if vector is not None}
    try:
        motion: NullMotion = kind(**settings)
    except InputError as error:  # a max_rate so small that it is 0 in radians
        reading.refused(("null_motion",), error)
        return None
    return motion


def limits_of(reading: Reading, arm: Arm) -> dict[str, np.ndarray]:
    """The limits that the file sets in place of the arm's own, by the argument of Scenario."""
    factors = reading.units.joints(arm.kinds)
    own = {
        "velocity_limits": arm.velocity_limits,
        "position_limits": arm.position_limits,
        "acceleration_limits": arm.acceleration_limits,
    }
    found = {key: reading.joint_values((key,), arm, factors, values, one_for_all=True) for key, values in own.items()}
    return {key: values for key, values in found.items() if values is not None}
