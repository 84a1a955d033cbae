"""The commanded path of a scenario, and the distance of a run from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stillreach._core import pose_distances
from stillreach._door import FloatArray
from stillreach._rotations import log
from stillreach.simulation.scenario import Scenario

if TYPE_CHECKING:
    from stillreach.simulation.run import Run
    from stillreach.task import Task

LOOKS = 10_000
"""Number of ticks, evenly spaced, at which a longer run is compared with its motion."""
LOOKS_BESIDE = 400
"""The same for the path as a whole, which takes longer."""


@dataclass(frozen=True)
class Commanded:
    """The commanded poses of the task's point.

    Args:
        ticks: (K,) rising: the first, the last and a sample between them.
        poses: (K, 4, 4) [m] at these ticks.
    """

    ticks: npt.NDArray[np.int64]
    poses: FloatArray

    def length(self) -> tuple[float, float]:
        """Length [m] and angle [rad] of the path."""
        steps = np.linalg.norm(np.diff(self.poses[:, :3, 3], axis=0), axis=1)
        turns = log(self.poses[1:, :3, :3] @ np.swapaxes(self.poses[:-1, :3, :3], 1, 2))
        return float(np.sum(steps)), float(np.sum(np.linalg.norm(turns, axis=1)))


def commanded(scenario: Scenario, looks: int = LOOKS) -> Commanded:
    """The commanded path of a scenario, at up to about ``looks`` ticks, for any clock."""
    ticks = _looked_at(scenario, looks)
    return Commanded(ticks, scenario.schedule.poses(ticks.astype(np.float64)))


def commanded_in(run: Run) -> Commanded:
    """The commanded path of a run.

    A function of time is not called again: with clock "time" the run has recorded its poses up to the last tick.
    """
    scenario = run.scenario
    if scenario.clock != "time" or not scenario.schedule.has_function:
        return commanded(scenario)
    ticks = _looked_at(scenario, LOOKS)
    ticks = ticks[ticks < len(run)]
    return Commanded(ticks, run.target[ticks])


def _looked_at(scenario: Scenario, looks: int) -> npt.NDArray[np.int64]:
    """First and last tick of each part, and evenly spaced ticks between; all ticks of a function of time."""
    plan, stride = scenario.schedule, max(1, scenario.steps // looks)
    ticks = [np.array([0])]
    for part, (first, end) in enumerate(plan.spans()):
        free = part < len(plan.motion) and callable(plan.motion[part])
        ticks.append(np.append(np.arange(first, end, 1 if free else stride), end)[1:])
    return np.concatenate(ticks)


def deviation(run: Run) -> tuple[FloatArray, FloatArray]:
    """Distance and angle of a run's tool from its target, in the rows of the task.

    Returns:
        Distance (T,) [m] and angle (T,) [rad], 0 for rows that are not in the task.
    """
    return _off(run.task, run.pose, run.target)


def off_goal(run: Run, goal: Commanded) -> tuple[float, float]:
    """Distance [m] and angle [rad] of a run's tool from its goal at the end, in the rows of the task."""
    distance, angle = _off(run.task, run.pose[-1:], goal.poses[-1:])
    return float(distance[0]), float(angle[0])


def in_axes(task: Task, twists: FloatArray, poses: FloatArray) -> FloatArray:
    """Twists (T, 6) along the axes of the task's rows, which are the tool's at its poses (T, 4, 4) or the base's."""
    if not along_tool(task):
        return twists
    return (twists.reshape(-1, 2, 3) @ poses[:, :3, :3]).reshape(-1, 6)  # rows times R: along the tool's axes


def _off(task: Task, actual: FloatArray, wanted: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (T,) [m] and angles (T,) [rad] between poses (T, 4, 4), in the rows of the task."""
    distance, angle = pose_distances(actual, wanted, asked(task).ravel(), along_tool(task))
    return distance, angle


def beside_path(run: Run, goal: Commanded) -> float:
    """Largest distance of a run's tool from the commanded path [m], at any time.

    A late tool on the path is far from its target, but at distance 0 from the path. In the rows of the
    task; arguments as for ``off_goal``.
    """
    task = run.task
    ticks = goal.ticks[goal.ticks < len(run)]
    looked = ticks[np.unique(np.linspace(0, len(ticks) - 1, LOOKS_BESIDE).round().astype(np.int64))]
    path, counts = goal.poses[:, :3, 3], asked(task)[0]
    path = np.concatenate([path, path[-1:]])  # a path of one pose also has a step
    farthest = 0.0
    for T in run.pose[looked]:
        seen = path - T[:3, 3]
        farthest = max(farthest, _nearest((seen @ T[:3, :3] if along_tool(task) else seen) * counts))
    return farthest


def _nearest(points: FloatArray) -> float:
    """Distance from the origin to the line through points (K, 3) in their order."""
    start, step = points[:-1], points[1:] - points[:-1]
    length, along = _dot(step, step), _dot(start, step)
    share = np.clip(-along / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    nearest = start + share[:, None] * step
    return float(np.sqrt(np.min(_dot(nearest, nearest))))


def _dot(one: FloatArray, other: FloatArray) -> FloatArray:
    """(K,) dot products of rows; faster than a sum along short rows."""
    return np.asarray(np.einsum("kx,kx->k", one, other))


def along_tool(task: Task) -> bool:
    """Whether the rows of the task are along the axes of the tool."""
    return task.frame == "tool"


def asked(task: Task) -> FloatArray:
    """(2, 3) 1 for the rows of the task, 0 for the others."""
    mask = np.zeros(6)
    mask[list(task.indices)] = 1.0
    return mask.reshape(2, 3)
