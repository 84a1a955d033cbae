"""Where a scenario's motion leads, and how far from it a run is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach._rotations import log
from stillreach.simulation.scenario import Scenario

if TYPE_CHECKING:
    from stillreach.simulation.run import Run
    from stillreach.task import Task

LOOKS = 10_000
"""A longer run is compared with its motion at about so many ticks, evenly spaced."""
LOOKS_BESIDE = 400
"""Likewise with the path as a whole, which takes longer."""


@dataclass(frozen=True)
class Commanded:
    """Where the task's point should be, whatever the arm does.

    Args:
        ticks: (K,) rising; the first, the last and those between that are looked at.
        poses: (K, 4, 4) [m] at these ticks.
    """

    ticks: npt.NDArray[np.int64]
    poses: FloatArray

    def length(self) -> tuple[float, float]:
        """Length [m] and angle [rad] of the way."""
        steps = np.linalg.norm(np.diff(self.poses[:, :3, 3], axis=0), axis=1)
        turns = log(self.poses[1:, :3, :3] @ np.swapaxes(self.poses[:-1, :3, :3], 1, 2))
        return float(np.sum(steps)), float(np.sum(np.linalg.norm(turns, axis=1)))


def commanded(scenario: Scenario, looks: int = LOOKS) -> Commanded:
    """Where the motion of a scenario leads, at up to about so many ticks, whatever its clock."""
    ticks = _looked_at(scenario, looks)
    return Commanded(ticks, scenario.schedule.poses(ticks.astype(np.float64)))


def commanded_in(run: Run) -> Commanded:
    """Where the motion of a run leads.

    A function of time is not called again: a run by the clock has recorded where it led, up to its last tick.
    """
    scenario = run.scenario
    if scenario.clock != "time" or not scenario.schedule.has_function:
        return commanded(scenario)
    ticks = _looked_at(scenario, LOOKS)
    ticks = ticks[ticks < len(run)]
    return Commanded(ticks, run.target[ticks])


def _looked_at(scenario: Scenario, looks: int) -> npt.NDArray[np.int64]:
    """The first and last tick of each part, and evenly spaced ones between; all ticks of a function of time."""
    plan, stride = scenario.schedule, max(1, scenario.steps // looks)
    ticks = [np.array([0])]
    for part, (first, end) in enumerate(plan.spans()):
        free = part < len(plan.motion) and callable(plan.motion[part])
        ticks.append(np.append(np.arange(first, end, 1 if free else stride), end)[1:])
    return np.concatenate(ticks)


def deviation(run: Run) -> tuple[FloatArray, FloatArray]:
    """How far the tool of a run is from its target, in the rows of the task.

    Returns:
        Distance (T,) [m] and angle (T,) [rad], 0 for rows that are not in the task.
    """
    return _off(run.task, run.pose, run.target)


def off_goal(run: Run, goal: Commanded) -> tuple[float, float]:
    """Distance [m] and angle [rad] at which a run's tool ends from where its motion does, in the rows of the task."""
    distance, angle = _off(run.task, run.pose[-1:], goal.poses[-1:])
    return float(distance[0]), float(angle[0])


def in_axes(task: Task, twists: FloatArray, poses: FloatArray) -> FloatArray:
    """Twists (T, 6) along the axes of the task's rows, which are the tool's at its poses (T, 4, 4) or the base's."""
    if not _along_tool(task):
        return twists
    return (twists.reshape(-1, 2, 3) @ poses[:, :3, :3]).reshape(-1, 6)  # rows times R: along the tool's axes


def _off(task: Task, actual: FloatArray, wanted: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (T,) [m] and angles (T,) [rad] between poses (T, 4, 4), in the rows of the task."""
    shift = wanted[:, :3, 3] - actual[:, :3, 3]
    turn = log(wanted[:, :3, :3] @ np.swapaxes(actual[:, :3, :3], 1, 2))
    both = in_axes(task, np.hstack([shift, turn]), actual).reshape(-1, 2, 3)
    distances = np.linalg.norm(both * _asked(task), axis=2)
    return distances[:, 0], distances[:, 1]


def beside_path(run: Run, goal: Commanded) -> float:
    """How far the tool of a run ever is from the commanded path [m], early or late.

    A tool that is late, and on its way, is far from where it should be and at 0 from its path. In the rows of the
    task; arguments as for ``off_goal``.
    """
    task = run.task
    ticks = goal.ticks[goal.ticks < len(run)]
    looked = ticks[np.unique(np.linspace(0, len(ticks) - 1, LOOKS_BESIDE).round().astype(np.int64))]
    path, asked = goal.poses[:, :3, 3], _asked(task)[0]
    path = np.concatenate([path, path[-1:]])  # also a path of one pose has a step
    farthest = 0.0
    for T in run.pose[looked]:
        seen = path - T[:3, 3]
        farthest = max(farthest, _nearest((seen @ T[:3, :3] if _along_tool(task) else seen) * asked))
    return farthest


def _nearest(points: FloatArray) -> float:
    """Distance from the origin to the line through points (K, 3) in their order."""
    start, step = points[:-1], points[1:] - points[:-1]
    length, along = _dot(step, step), _dot(start, step)
    share = np.clip(-along / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    nearest = start + share[:, None] * step
    return float(np.sqrt(np.min(_dot(nearest, nearest))))


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    """(K,) row by row; quicker than a sum along short rows."""
    return np.asarray(np.einsum("kx,kx->k", one, other))


def _along_tool(task: Task) -> bool:
    return task.frame == "tool"


def _asked(task: Task) -> FloatArray:
    """(2, 3) 1 for the rows of the task, 0 for the others."""
    mask = np.zeros(6)
    mask[list(task.indices)] = 1.0
    return mask.reshape(2, 3)
