"""stillreach keeps a redundant arm on its task after joints fail.

Given where the joints are, what the tool should do now, what is broken and what the drives allow, it returns the best
joint rates, every control tick, and it always answers.
"""

from __future__ import annotations

import importlib
import sys
import types
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stillreach._core import Solution
    from stillreach.arm import Arm, DHRow, Follower, Joint
    from stillreach.arm import catalogue as arms
    from stillreach.batch import BatchSolution, solve_batch
    from stillreach.bounds import Bounds
    from stillreach.control import Centring, Controller, Gradient, Manipulability, NullMotion, Posture, Rates
    from stillreach.errors import (
        InputError,
        MissingExtraError,
        Mistake,
        RobotFileError,
        ScenarioFileError,
        SimulationInterrupted,
        StillreachError,
        UnknownJointError,
    )
    from stillreach.faults import Derated, Fault, Locked, Runaway
    from stillreach.insight import Check
    from stillreach.laws import KeepDirection, Law, LeastError, Pseudoinverse, SingularityRobust
    from stillreach.rollouts import BatchRollout, rollout_batch
    from stillreach.simulate import (  # type: ignore[no-redef]
        Circle,
        Line,
        PoseTable,
        Run,
        Scenario,
        Twist,
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
    "arm": ("Arm", "DHRow", "Follower", "Joint"),
    "batch": ("BatchSolution", "solve_batch"),
    "bounds": ("Bounds",),
    "control": ("Centring", "Controller", "Gradient", "Manipulability", "NullMotion", "Posture", "Rates"),
    "errors": (
        "InputError",
        "MissingExtraError",
        "Mistake",
        "RobotFileError",
        "ScenarioFileError",
        "SimulationInterrupted",
        "StillreachError",
        "UnknownJointError",
    ),
    "faults": ("Derated", "Fault", "Locked", "Runaway"),
    "insight": ("Check",),
    "laws": ("KeepDirection", "Law", "LeastError", "Pseudoinverse", "SingularityRobust"),
    "rollouts": ("BatchRollout", "rollout_batch"),
    "simulate": (
        "Circle",
        "Line",
        "PoseTable",
        "Run",
        "Scenario",
        "Twist",
        "Waypoints",
        "scenario_names",
        "scenario_schema",
        "simulate",
    ),
    "status": ("Health", "Reason", "Status"),
    "task": ("Task", "Weights"),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [
    "Arm",
    "BatchRollout",
    "BatchSolution",
    "Bounds",
    "Centring",
    "Check",
    "Circle",
    "Controller",
    "DHRow",
    "Derated",
    "Fault",
    "Follower",
    "Gradient",
    "Health",
    "InputError",
    "Joint",
    "KeepDirection",
    "Law",
    "LeastError",
    "Line",
    "Locked",
    "Manipulability",
    "MissingExtraError",
    "Mistake",
    "NullMotion",
    "PoseTable",
    "Posture",
    "Pseudoinverse",
    "Rates",
    "Reason",
    "RobotFileError",
    "Run",
    "Runaway",
    "Scenario",
    "ScenarioFileError",
    "SimulationInterrupted",
    "SingularityRobust",
    "Solution",
    "Status",
    "StillreachError",
    "Task",
    "Twist",
    "UnknownJointError",
    "Waypoints",
    "Weights",
    "arms",
    "rollout_batch",
    "scenario_names",
    "scenario_schema",
    "simulate",
    "solve_batch",
]


def __getattr__(name: str) -> Any:
    if name == "arms":
        value: Any = importlib.import_module("stillreach.arm.catalogue")
    elif name in _HOME_OF:
        value = getattr(importlib.import_module(f"stillreach.{_HOME_OF[name]}"), name)
    elif name == "__version__":
        value = importlib.import_module("importlib.metadata").version("stillreach")
    else:
        raise AttributeError(f"module 'stillreach' has no attribute {name!r}")
    globals()[name] = value
    return value


class _Package(types.ModuleType):
    """``sr.simulate`` is the function: importing the subpackage of that name must not hide it."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name == "simulate" and isinstance(value, types.ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})
