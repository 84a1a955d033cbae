"""The settings of a scenario as data that JSON can hold, in the words of scenario files."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from stillreach.faults import Fault
from stillreach.null_motions import NullMotion
from stillreach.simulation.scenario import Scenario


def law_data(scenario: Scenario) -> dict[str, Any]:
    """The law: its ``kind`` and its settings."""
    return {"kind": kind_word(scenario.law), **_settings(scenario.law)}


def task_data(scenario: Scenario) -> dict[str, Any]:
    """The task: ``rows``, ``frame``, ``tool`` and ``weights``."""
    return _settings(scenario.task)


def null_motion_data(null_motion: Any) -> dict[str, Any] | None:
    """A null motion: its ``kind`` and its settings; None where there is none."""
    if null_motion is None:
        return None
    if isinstance(null_motion, NullMotion):
        return {"kind": kind_word(null_motion), **_settings(null_motion)}
    return {"kind": "rates", "rates": _plain(null_motion)}


def fault_data(scenario: Scenario, fault: Fault) -> dict[str, Any]:
    """A fault: ``joint`` (a name), ``kind``, what the kind takes (``fraction``, ``rate``), ``at`` and ``until`` [s]."""
    joint = scenario.arm.joint_names[scenario.arm.joint_index(fault.joint)]
    kind = {"kind": kind_word(fault.kind), **_settings(fault.kind)}
    return {"joint": joint, **kind, "at": fault.at, "until": _plain(fault.until)}


def kind_word(value: object) -> str:
    """The word of scenario files for a class: ``keep-direction`` for KeepDirection."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", type(value).__name__).lower()


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
