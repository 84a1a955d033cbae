"""What a scenario can hardly mean: a start outside the position limits, a goal that the arm cannot reach."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm.outside import outside
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.simulation.scenario import Scenario
    from stillreach.task import Task

ADVICE = "numbers are in rad and m, or in the [units] of a scenario file; allow_outside = true takes it as it is"
ROUNDING = 1e-9


def start_outside(scenario: Scenario) -> list[InputError]:
    """An error for each joint that starts outside its position limits."""
    found = outside(scenario.arm, scenario.start, _limits(scenario))
    return [InputError("start", got, f"{expected}; {ADVICE}") for _, got, expected in found]


def goals_beyond_reach(scenario: Scenario) -> list[InputError]:
    """An error for each course that leads farther from the base than the arm reaches.

    A course names places. A twist names a velocity, and may lead anywhere.
    """
    assert scenario.task is not None
    rows = _seen(scenario.task)
    reach = _reach(scenario)
    if not rows or not np.isfinite(reach):
        return []
    found = []
    for place, stretch in scenario.schedule.stretches.items():
        points = stretch.plan.at(stretch.plan.knots)[0][:, rows, 3]
        far = float(np.max(np.linalg.norm(points, axis=1)))
        if far > reach * (1.0 + ROUNDING):
            along = "" if len(rows) == 3 else f" along {', '.join('xyz'[row] for row in rows)}"
            got = f"a point {far:.4g} m from the base{along}"
            expected = f"at most {reach:.4g} m, as far as the arm reaches; {ADVICE}"
            found.append(InputError(f"motion[{place}].{stretch.goal}", got, expected))
    return found


def _seen(task: Task) -> list[int]:
    """Axes of the base along which the task asks for a position; none where they turn with the tool."""
    rows = [row for row in task.indices if row < 3]
    return [] if task.frame == "tool" and len(rows) < 3 else rows


def _limits(scenario: Scenario) -> FloatArray:
    """(n, 2) position limits that hold in the scenario."""
    limits = scenario.position_limits
    return scenario.arm.position_limits if limits is None else np.asarray(limits)


def _reach(scenario: Scenario) -> float:
    """How far from the base the task's point can ever be [m]; a slide that starts outside its limits may stay there."""
    lower, upper = _limits(scenario).T
    widened = np.column_stack([np.minimum(lower, scenario.start), np.maximum(upper, scenario.start)])
    task = scenario.task
    point = 0.0 if task is None or task.tool is None else float(np.linalg.norm(task.tool[:3, 3]))
    return scenario.arm.with_limits(position=widened).reach + point
