"""The labels of a run: texts and numbers that a file can hold; settings as JSON."""

from __future__ import annotations

import json
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from stillreach.simulation.data import fault_data, law_data, null_motion_data, task_data
from stillreach.simulation.scenario import Scenario

Attribute = str | int | float


def run_attributes(scenario: Scenario, *, interrupted: bool) -> dict[str, Attribute]:
    """The labels of a run of a scenario.

    ``law``, ``task``, ``faults`` and ``null_motion`` hold JSON. ``interrupted`` is 1 for a run that Ctrl-C ended early,
    else 0. ``velocity_limits`` is "infinite: no rate limit" where there are none.
    """
    limits = (
        scenario.arm.velocity_limits
        if scenario.velocity_limits is None
        else np.asarray(scenario.velocity_limits, dtype=float)
    )
    return {
        "title": scenario.name or f"{scenario.arm.name} under {type(scenario.law).__name__}",
        "arm": scenario.arm.name,
        "law": json.dumps(law_data(scenario)),
        "task": json.dumps(task_data(scenario)),
        "faults": json.dumps([fault_data(scenario, fault) for fault in scenario.faults]),
        "velocity_limits": "infinite: no rate limit" if np.all(np.isinf(limits)) else "see lower and upper",
        "null_motion": json.dumps(null_motion_data(scenario.null_motion)),
        "feedback": f"on the pose, {scenario.track_gain:g} 1/s" if scenario.loop == "closed" else "none",
        "clock": scenario.clock,
        "integrator": scenario.integrator,
        "period": float(scenario.period),
        "duration": float(scenario.duration or 0.0),
        "interrupted": int(interrupted),
        "source": f"stillreach {_version()}",
    }


def _version() -> str:
    try:
        return version("stillreach")
    except PackageNotFoundError:
        return "(not installed)"
