"""A scenario as a JSON document in the record of a run, from which it is rebuilt exactly."""

from __future__ import annotations

import inspect
import json
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NoReturn

import numpy as np

from stillreach import _door
from stillreach.arm import Arm, Follower, Joint
from stillreach.errors import InputError
from stillreach.faults import FAULTS, Fault
from stillreach.laws import LAWS
from stillreach.null_motions import NULL_MOTIONS, NullMotion
from stillreach.plants import PLANTS
from stillreach.simulation.motion import MOTIONS
from stillreach.simulation.scenario import Scenario
from stillreach.simulation.shapes import Waypoints
from stillreach.task import Task, Weights

FORMAT = 2
"""Format of the document; others are rejected."""
PYTHON = "python"
"""Kind of a Python function; the document has its name."""
KINDS: dict[str, Any] = {kind.word: kind for kind in (*LAWS, *FAULTS, *MOTIONS, *NULL_MOTIONS, *PLANTS)}
"""Every law, fault, motion, null motion and plant that a document can hold."""
PARTS = (Arm, Joint, Follower, Task, Weights, Fault)
"""Other classes of a document; their position identifies them."""


class NotStored:
    """Placeholder for a Python function in a scenario read from a record.

    Args:
        name: of the function.
    """

    def __init__(self, name: str) -> None:
        self.__qualname__ = name

    def __call__(self, *_: object) -> NoReturn:
        """Raises InputError."""
        raise InputError(
            "scenario",
            f"a function read from a record, which contains its name {self.__qualname__!r} and not its code",
            "the function again, by dataclasses.replace(run.scenario, motion=...) or null_motion=...",
        )


def check_whole(scenario: Scenario) -> None:
    """Raises InputError for a scenario with a function that its record does not contain."""
    for value in (*scenario.schedule.motion, getattr(scenario.null_motion, "gradient", None)):
        if isinstance(value, NotStored):
            value()


def scenario_data(scenario: Scenario) -> dict[str, Any]:
    """A scenario in JSON's own types; an infinite number is ``{"float": "inf"}``.

    Raises:
        InputError: if a law, motion or null motion is not of a class of stillreach.
    """
    values = {name: getattr(scenario, name) for name in inspect.signature(Scenario).parameters}
    if isinstance(scenario.null_motion, NullMotion):
        values["null_motion"] = _in_joint_order(scenario.null_motion, scenario.arm)
    return {"format": FORMAT, **{name: _data(value) for name, value in values.items()}}


def scenario_text(scenario: Scenario) -> str:
    """The document as text."""
    return json.dumps(scenario_data(scenario), ensure_ascii=False, allow_nan=False)


def scenario_of(text: str) -> Scenario:
    """The scenario of a document.

    Raises:
        InputError: if the text is not a document of this format.
    """
    expected = "a scenario as run.save() writes it"
    try:
        data = json.loads(text, object_hook=_with_infinity)
        version = data.pop("format")
        if version != FORMAT:
            raise InputError("scenario", f"format {version!r}", f"format {FORMAT}, of this version of stillreach")
        return _scenario(data)
    except (InputError, MemoryError):
        raise
    except Exception as error:  # invalid arguments from a corrupt document
        raise InputError("scenario", f"{type(error).__name__}: {error}", expected) from None


def settings_text(value: Arm | Task) -> str:
    """The settings of an arm or a task as JSON with sorted keys, the same for the same settings."""
    return json.dumps(_data(value), ensure_ascii=False, allow_nan=False, sort_keys=True)


def arm_of(text: str) -> Arm:
    """The arm of such a text."""
    return _arm(json.loads(text, object_hook=_with_infinity))


def _in_joint_order(motion: NullMotion, arm: Arm) -> NullMotion:
    """A null motion whose numbers for each joint have no labels."""
    vector: Any = motion.core(arm.labels)[2]
    names = [name for name in ("q", "rates", "gradient") if hasattr(motion, name)]
    return motion if vector is None else replace(motion, **dict.fromkeys(names, vector))


def _data(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        if value.dtype.kind == "f" and np.all(np.isfinite(value)):
            return value.tolist()
        value = value.tolist()
    if isinstance(value, float):
        return value if math.isfinite(value) else {"float": repr(value)}
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, Mapping):
        return {str(key): _data(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_data(item) for item in value]
    if isinstance(value, PARTS):
        return _settings(value)
    if type(value) in KINDS.values():
        return {"kind": value.word, **_settings(value)}
    if inspect.isroutine(value) or isinstance(value, NotStored):
        return {"kind": PYTHON, "name": value.__qualname__}
    raise InputError("scenario", _door.describe(value), f"one of {', '.join(KINDS)} or a function")


def _settings(value: Any) -> dict[str, Any]:
    """The constructor's arguments of a value."""
    kind = Arm if isinstance(value, Arm) else type(value)
    names = list(inspect.signature(kind).parameters)
    if isinstance(value, Waypoints) and value.times is not None:
        names.remove("duration")  # which follows from the times
    return {name: _data(getattr(value, name)) for name in names}


def _with_infinity(table: dict[str, Any]) -> Any:
    return float(table["float"]) if table.keys() == {"float"} else table


def _scenario(data: dict[str, Any]) -> Scenario:
    known: dict[str, Weights] = {}  # law and task may share their weights, and then they are one object

    def weighted(table: dict[str, Any]) -> dict[str, Any]:
        given = table.get("weights")
        shared = given and known.setdefault(json.dumps(given), Weights(**given))
        return {**table, "weights": shared} if "weights" in table else table

    task = weighted(data["task"])
    if isinstance(task["rows"], list):
        task["rows"] = tuple(task["rows"])
    parts = {
        "arm": _arm(data["arm"]),
        "law": _of_kind(weighted(data["law"])),
        "task": Task(**task),
        "plant": _of_kind(data["plant"]),
        "motion": [_of_kind(part) for part in data["motion"]],
        "faults": [Fault(**{**fault, "kind": _of_kind(fault["kind"])}) for fault in data["faults"]],
        "null_motion": data["null_motion"] and _null_motion(data["null_motion"]),
    }
    return Scenario(**{**data, **parts})


def _arm(data: dict[str, Any]) -> Arm:
    followers = [Follower(**{**table, "joint": Joint(**table["joint"])}) for table in data["followers"]]
    return Arm(**{**data, "joints": [Joint(**joint) for joint in data["joints"]], "followers": followers})


def _null_motion(data: dict[str, Any]) -> Any:
    gradient = data.get("gradient")
    return _of_kind({**data, "gradient": _of_kind(gradient)} if isinstance(gradient, dict) else data)


def _of_kind(data: dict[str, Any]) -> Any:
    settings = dict(data)
    kind = settings.pop("kind")
    if kind == PYTHON:
        return NotStored(_door.text("name", settings["name"]))
    return KINDS[kind](**settings)
