"""Where a scenario's motion leads, and how far from it a run is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach._rotations import log
from stillreach.simulation.motion import checked_motion
from stillreach.simulation.path import led_to, stretches
from stillreach.simulation.run import Run
from stillreach.simulation.scenario import Scenario

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
    stride, motion = max(1, scenario.steps // looks), checked_motion(scenario.motion)
    ticks = [np.array([0])]
    for part, (first, end) in enumerate(_spans(scenario)):
        free = part < len(motion) and callable(motion[part])
        # a function of time is followed tick by tick
        ticks.append(np.append(np.arange(first, end, 1 if free else stride), end)[1:])
    looked = np.concatenate(ticks)
    return Commanded(looked, _poses(scenario, looked.astype(np.float64)))


def _spans(scenario: Scenario) -> list[tuple[int, int]]:
    """First and last tick of each part of the motion and of the rest; a part that is never begun has none."""
    starts = scenario.part_starts()
    ends = [min(start, scenario.steps) for start in starts[1:]] + [scenario.steps]
    return [(first, max(first, end)) for first, end in zip(starts, ends, strict=True)]


def _poses(scenario: Scenario, at: FloatArray) -> FloatArray:
    """(K, 4, 4) where the motion leads, at ticks (K,) that do not fall, which may lie between whole ones."""
    motion, T = checked_motion(scenario.motion), scenario.task_pose(scenario.start)
    courses = stretches(motion, scenario.part_starts(), scenario.period, T)
    poses = np.repeat(T[None], len(at), axis=0)
    for part, (first, end) in enumerate(_spans(scenario)):
        if first == end:
            continue
        here = np.flatnonzero((at > first) & (at <= end))
        ticks = np.concatenate([[first], at[here], [end]])
        led = courses[part].at(ticks)[0] if part in courses else led_to(T, motion, part, ticks * scenario.period)
        poses[here], T = led[1:-1], led[-1]
    return poses


def deviation(scenario: Scenario, run: Run) -> tuple[FloatArray, FloatArray]:
    """How far the tool of a run is from its target, in the rows of the task.

    Args:
        scenario: whose task.
        run: what happened.

    Returns:
        Distance (T,) [m] and angle (T,) [rad], 0 for rows that are not in the task.
    """
    return _off(scenario, run.pose, run.target)


def off_goal(scenario: Scenario, run: Run, goal: Commanded) -> tuple[float, float]:
    """Distance [m] and angle [rad] at which a run's tool ends from where its motion does, in the rows of the task."""
    distance, angle = _off(scenario, run.pose[-1:], goal.poses[-1:])
    return float(distance[0]), float(angle[0])


def in_axes(scenario: Scenario, twists: FloatArray, poses: FloatArray) -> FloatArray:
    """Twists (T, 6) along the axes of the task's rows, which are the tool's at its poses (T, 4, 4) or the base's."""
    if not _along_tool(scenario):
        return twists
    return (twists.reshape(-1, 2, 3) @ poses[:, :3, :3]).reshape(-1, 6)  # rows times R: along the tool's axes


def _off(scenario: Scenario, actual: FloatArray, wanted: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (T,) [m] and angles (T,) [rad] between poses (T, 4, 4), in the rows of the task."""
    shift = wanted[:, :3, 3] - actual[:, :3, 3]
    turn = log(wanted[:, :3, :3] @ np.swapaxes(actual[:, :3, :3], 1, 2))
    both = in_axes(scenario, np.hstack([shift, turn]), actual).reshape(-1, 2, 3)
    distances = np.linalg.norm(both * _asked(scenario), axis=2)
    return distances[:, 0], distances[:, 1]


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
