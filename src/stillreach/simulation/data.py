"""The settings of a scenario as data that JSON can hold, in the words of scenario files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from stillreach.faults import Fault
from stillreach.null_motions import NullMotion
from stillreach.simulation.scenario import Scenario


def law_data(scenario: Scenario) -> dict[str, Any]:
    """The law: its ``kind`` and its settings."""
    assert scenario.law is not None
    return {"kind": scenario.law.word, **_settings(scenario.law)}


def task_data(scenario: Scenario) -> dict[str, Any]:
    """The task: ``rows``, ``frame``, ``tool`` and ``weights``."""
    return _settings(scenario.task)


def null_motion_data(null_motion: Any) -> dict[str, Any] | None:
    """A null motion: its ``kind`` and its settings; None where there is none."""
    if null_motion is None:
        return None
    if isinstance(null_motion, NullMotion):
        return {"kind": null_motion.word, **_settings(null_motion)}
    return {"kind": "rates", "rates": _plain(null_motion)}


def fault_data(scenario: Scenario, fault: Fault) -> dict[str, Any]:
    """A fault: ``joint`` (a name), ``kind`` and its settings, ``at`` and ``until`` [s]."""
    joint = scenario.arm.joint_names[scenario.arm.joint_index(fault.joint)]
    kind = {"kind": fault.kind.word, **_settings(fault.kind)}
    return {"joint": joint, **kind, "at": fault.at, "until": _plain(fault.until)}


def _settings(value: Any) -> dict[str, Any]:
    """The fields of a dataclass that its constructor takes."""
    return {field.name: _plain(getattr(value, field.name)) for field in fields(value) if field.init}


def _plain(value: Any) -> Any:
    """The value in JSON's own types; null for infinity, the name of a function."""
    if hasattr(value, "tolist"):  # NumPy
        value = value.tolist()
    if is_dataclass(value):
        return _settings(value)
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if callable(value):
        return getattr(value, "__qualname__", type(value).__qualname__)
    return None if isinstance(value, float) and not math.isfinite(value) else value
