"""Where a scenario's motion leads, and how far from it a run is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach.simulate.motion import Twist, checked_motion
from stillreach.simulate.path import led_to, stretches
from stillreach.simulate.rotations import log
from stillreach.simulate.run import Run
from stillreach.simulate.scenario import Scenario

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
    """Where the motion of a scenario leads, at up to about so many ticks."""
    stride = max(1, scenario.steps // looks)
    motion, starts = checked_motion(scenario.motion), scenario.part_starts()
    T = scenario.task_pose(scenario.start)
    courses = stretches(motion, starts, scenario.period, T)
    ends = [min(start, scenario.steps) for start in starts[1:]] + [scenario.steps]
    ticks, poses = [np.array([0])], [T[None]]
    for part, (first, end) in enumerate(zip(starts, ends, strict=True)):
        if first >= end:
            continue
        free = part < len(motion) and not isinstance(motion[part], Twist)
        step = 1 if free and part not in courses else stride  # a function of time is followed tick by tick
        looked = np.append(np.arange(first, end, step), end)
        if part in courses:
            led = courses[part].at(looked.astype(np.float64))[0]
        else:
            led = led_to(poses[-1][-1], motion, part, looked * scenario.period)
        ticks.append(looked[1:])
        poses.append(led[1:])
    return Commanded(np.concatenate(ticks), np.concatenate(poses))


def deviation(scenario: Scenario, run: Run) -> tuple[FloatArray, FloatArray]:
    """How far the tool of a run is from its target, in the rows of the task.

    Args:
        scenario: whose task.
        run: what happened.

    Returns:
        Distance (T,) [m] and angle (T,) [rad], 0 for rows that are not in the task.
    """
    shift = run.target[:, :3, 3] - run.pose[:, :3, 3]
    turn = log(run.target[:, :3, :3] @ np.swapaxes(run.pose[:, :3, :3], 1, 2))
    both = in_axes(scenario, np.hstack([shift, turn]), run.pose).reshape(-1, 2, 3)
    distances = np.linalg.norm(both * _asked(scenario), axis=2)
    return distances[:, 0], distances[:, 1]


def in_axes(scenario: Scenario, twists: FloatArray, poses: FloatArray) -> FloatArray:
    """Twists (T, 6) along the axes of the task's rows, which are the tool's at its poses (T, 4, 4) or the base's."""
    if not _along_tool(scenario):
        return twists
    return (twists.reshape(-1, 2, 3) @ poses[:, :3, :3]).reshape(-1, 6)  # rows times R: along the tool's axes


def beside_path(scenario: Scenario, run: Run, goal: Commanded) -> float:
    """How far the tool of a run ever is from the commanded path [m], early or late.

    A tool that is late, and on its way, is far from where it should be and at 0 from its path. In the rows of the
    task; arguments as for ``deviation``.
    """
    ticks = goal.ticks[goal.ticks < len(run)]
    looked = ticks[np.unique(np.linspace(0, len(ticks) - 1, LOOKS_BESIDE).round().astype(np.int64))]
    path, asked = goal.poses[:, :3, 3], _asked(scenario)[0]
    path = np.concatenate([path, path[-1:]])  # also a path of one pose has a step
    farthest = 0.0
    for T in run.pose[looked]:
        seen = path - T[:3, 3]
        farthest = max(farthest, _nearest((seen @ T[:3, :3] if _along_tool(scenario) else seen) * asked))
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


def _along_tool(scenario: Scenario) -> bool:
    return scenario.task is not None and scenario.task.frame == "tool"


def _asked(scenario: Scenario) -> FloatArray:
    """(2, 3) 1 for the rows of the task, 0 for the others."""
    mask = np.zeros(6)
    mask[list(scenario.task.indices) if scenario.task is not None else range(6)] = 1.0
    return mask.reshape(2, 3)
