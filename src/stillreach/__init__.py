"""stillreach keeps a redundant arm on its task after joints fail.

Given where the joints are, what the tool should do now, what is broken and what the drives allow, it returns the best
joint rates, every control tick, and it always answers.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stillreach import arms, errors, insight, null_motions
    from stillreach._core import Solution
    from stillreach._cpp import get_cmake_dir, get_include
    from stillreach.arm import Arm, DHRow, Follower, Joint
    from stillreach.batch import BatchSolution, solve_batch
    from stillreach.bounds import Bounds
    from stillreach.control import Controller
    from stillreach.errors import InputError, StillreachError
    from stillreach.faults import Confined, Derated, Fault, Locked, OneWay, Runaway
    from stillreach.laws import KeepDirection, Law, LeastError, Pseudoinverse, SingularityRobust
    from stillreach.rollouts import BatchRollout, rollout_batch
    from stillreach.simulation import (
        Circle,
        ConstantTwist,
        Line,
        PoseTable,
        Run,
        Scenario,
        Wait,
        Waypoints,
        scenario_names,
        scenario_schema,
        simulate,
    )
    from stillreach.status import Health, Reason, Status
    from stillreach.task import Task, Weights

# Where each public name lives. They are imported on first use: `stillreach --version` needs none of them, nor NumPy.
_HOMES = {
    "_core": ("Solution",),
    "_cpp": ("get_cmake_dir", "get_include"),
    "arm": ("Arm", "DHRow", "Follower", "Joint"),
    "batch": ("BatchSolution", "solve_batch"),
    "bounds": ("Bounds",),
    "control": ("Controller",),
    "errors": ("InputError", "StillreachError"),
    "faults": ("Confined", "Derated", "Fault", "Locked", "OneWay", "Runaway"),
    "laws": ("KeepDirection", "Law", "LeastError", "Pseudoinverse", "SingularityRobust"),
    "rollouts": ("BatchRollout", "rollout_batch"),
    "simulation": (
        "Circle",
        "Line",
        "PoseTable",
        "Run",
        "Scenario",
        "ConstantTwist",
        "Wait",
        "Waypoints",
        "scenario_names",
        "scenario_schema",
        "simulate",
    ),
    "status": ("Health", "Reason", "Status"),
    "task": ("Task", "Weights"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}
_MODULES = {
    "arms": "arms",
    "errors": "errors",
    "insight": "insight",
    "null_motions": "null_motions",
}

__all__ = [
    "Arm",
    "BatchRollout",
    "BatchSolution",
    "Bounds",
    "Circle",
    "Confined",
    "ConstantTwist",
    "Controller",
    "DHRow",
    "Derated",
    "Fault",
    "Follower",
    "Health",
    "InputError",
    "Joint",
    "KeepDirection",
    "Law",
    "LeastError",
    "Line",
    "Locked",
    "OneWay",
    "PoseTable",
    "Pseudoinverse",
    "Reason",
    "Run",
    "Runaway",
    "Scenario",
    "SingularityRobust",
    "Solution",
    "Status",
    "StillreachError",
    "Task",
    "Wait",
    "Waypoints",
    "Weights",
    "arms",
    "errors",
    "get_cmake_dir",
    "get_include",
    "insight",
    "null_motions",
    "rollout_batch",
    "scenario_names",
    "scenario_schema",
    "simulate",
    "solve_batch",
]


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        value: Any = importlib.import_module(f"stillreach.{_MODULES[name]}")
    elif name in _HOME_OF:
        value = getattr(importlib.import_module(f"stillreach.{_HOME_OF[name]}"), name)
    elif name == "__version__":
        value = importlib.import_module("importlib.metadata").version("stillreach")
    else:
        raise AttributeError(f"module 'stillreach' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*(name for name in globals() if name.startswith("__")), *__all__, "__version__"})
