"""Law, task, null motion and limits of a scenario file."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach.arm import Arm
from stillreach.control import Centring, Manipulability, NullMotion, Posture, Rates
from stillreach.errors import InputError
from stillreach.laws import KeepDirection, Law, LeastError, Pseudoinverse, SingularityRobust
from stillreach.simulate.scenario_file.motions import rotation
from stillreach.simulate.scenario_file.reading import Reading
from stillreach.task import Task, Weights

LAWS: dict[str, type[Law]] = {
    "least-error": LeastError,
    "singularity-robust": SingularityRobust,
    "keep-direction": KeepDirection,
    "pseudoinverse": Pseudoinverse,
}


def law_of(reading: Reading) -> Law | None:
    """The law; None for the default."""
    table = reading.value("law")
    if table is None:
        return None
    settings = {key: value for key, value in table.items() if key != "kind"}
    if settings.get("max_gain") == "none":
        settings["max_gain"] = None
    try:
        return LAWS[table["kind"]](**settings)
    except InputError as error:
        reading.refused(("law",), error)
        return None


def task_of(reading: Reading) -> Task | None:
    """The task; None for the default."""
    table = reading.value("task")
    if table is None:
        return None
    try:
        return Task(
            rows=table.get("rows", "pose"),
            frame=table.get("frame", "base"),
            tool=_tool(reading, table["tool"]) if "tool" in table else None,
            weights=_weights(reading, table["weights"]) if "weights" in table else None,
        )
    except InputError as error:
        reading.refused(("task",), error)
        return None


def _tool(reading: Reading, table: dict[str, Any]) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3] = np.array(table.get("position", (0.0, 0.0, 0.0)), dtype=float) * reading.units.length
    if "orientation" in table:
        T[:3, :3] = rotation("tool.orientation", table["orientation"], reading.units)
    return T


def _weights(reading: Reading, table: dict[str, Any]) -> Weights:
    settings: dict[str, Any] = {
        key: table[key] * getattr(reading.units, key) for key in ("length", "angle") if key in table
    }
    settings |= {key: table[key] for key in ("task", "joints") if key in table}
    try:
        return Weights(**settings)
    except InputError as error:
        raise InputError(f"weights.{error.argument}", error.got, error.expected) from None


def null_motion_of(reading: Reading, arm: Arm) -> NullMotion | None:
    """The null motion; None for none."""
    factors = reading.units.joints(arm.kinds)
    vectors = {key: reading.joint_values(("null_motion", key), arm, factors, np.zeros(arm.n)) for key in ("q", "rates")}
    table = reading.value("null_motion")
    if table is None:
        return None
    settings = {"gain": table["gain"]} if "gain" in table else {}
    if "max_rate" in table:
        settings["max_rate"] = table["max_rate"] * reading.units.largest_rate(arm.kinds)
    match table["kind"]:
        case "manipulability":
            return Manipulability(**settings)
        case "centring":
            return Centring(**settings)
        case "posture":
            return Posture(q=vectors["q"], **settings)
        case _:
            return Rates(rates=vectors["rates"], **settings)


def limits_of(reading: Reading, arm: Arm) -> dict[str, np.ndarray]:
    """The limits that the file sets in place of the arm's own, by the argument of Scenario."""
    factors = reading.units.joints(arm.kinds)
    own = {
        "rate_limits": arm.velocity_limits,
        "position_limits": arm.position_limits,
        "acceleration_limits": arm.acceleration_limits,
    }
    found = {key: reading.joint_values((key,), arm, factors, values, one_for_all=True) for key, values in own.items()}
    positions = found["position_limits"]
    if positions is not None:
        for joint in np.flatnonzero(positions[:, 0] > positions[:, 1])[:1]:
            low, high = positions[joint] / factors[joint]
            reading.wrong(
                ("position_limits",), f"{low:g} above {high:g} for {arm.joint_names[joint]}", "lower <= upper"
            )
    return {key: values for key, values in found.items() if values is not None}
