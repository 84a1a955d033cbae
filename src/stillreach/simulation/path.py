"""Paths of commanded twists.

Followed exactly from a pose (p, R) for a time t, a constant twist [v; w] in base axes leads to (p + v t, exp(w t) R):
the point moves on a straight line while the attitude turns about a fixed axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stillreach._door import FloatArray
from stillreach._rotations import exp, log
from stillreach.errors import InputError
from stillreach.simulation.course import Course, Plan
from stillreach.simulation.motion import ConstantTwist, Motion, commands

GAUSS = np.array([0.5 - np.sqrt(3.0) / 6.0, 0.5 + np.sqrt(3.0) / 6.0])
"""Nodes of the two-point rule on [0, 1]."""


@dataclass(frozen=True)
class Stretch:
    """A course in the ticks of a scenario: it begins and ends at ticks, stretched by less than a tick.

    Args:
        plan: the course from its start.
        goal: the argument of the course that sets its goal.
        duration: its own [s].
        first, end: its first and last tick.
        period: time between ticks [s].
    """

    plan: Plan
    goal: str
    duration: float
    first: int
    end: int
    period: float

    def at(self, ticks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses (K, 4, 4) and twists (K, 6) at ticks (K,), which may lie between whole ones."""
        count = self.end - self.first
        poses, twists = self.plan.at((ticks - self.first) / count * self.duration)
        return poses, twists * (self.duration / (count * self.period))


def stretches(
    motion: Sequence[Motion], starts: Sequence[int], period: float, T_start: FloatArray
) -> dict[int, Stretch]:
    """The courses of a motion, each from the final pose of the previous parts.

    Args:
        motion: the parts.
        starts: (parts + 1,) tick at which each part begins, and the last one ends.
        period: time between ticks [s].
        T_start: (4, 4) [m] pose at the start.

    Returns:
        By the index of the part.

    Raises:
        InputError: if a course is shorter than a tick, or cannot begin at the final pose of the previous parts.
    """
    found: dict[int, Stretch] = {}
    last_course = max((place for place, part in enumerate(motion) if isinstance(part, Course)), default=-1)
    for place, part in enumerate(motion[: last_course + 1]):
        first, end = starts[place : place + 2]
        if isinstance(part, ConstantTwist):
            T_start = _held(T_start, part.twist, np.array([(end - first) * period]))[0]
        elif isinstance(part, Course):
            if end <= first or part.duration < period:
                raise InputError(
                    f"motion[{place}].duration", f"{part.duration:g} s", f"at least a period, {period:g} s"
                )
            try:
                plan = part.plan(T_start)
            except InputError as error:
                raise InputError(f"motion[{place}].{error.argument}", error.got, error.expected) from None
            found[place] = Stretch(plan, part.goal, part.duration, first, end, period)
            T_start = plan.at(np.array([part.duration]))[0][0]
    return found


def held_between(poses: FloatArray, period: float) -> FloatArray:
    """The twists (K, 6) that lead, each in one period, from pose to pose of (K + 1, 4, 4)."""
    turns = poses[1:, :3, :3] @ np.swapaxes(poses[:-1, :3, :3], 1, 2)
    return np.hstack([np.diff(poses[:, :3, 3], axis=0), log(turns)]) / period


def led_to(
    T_start: FloatArray, motion: Sequence[Motion], part: int, times: FloatArray, since: float | None = None
) -> FloatArray:
    """Poses (K, 4, 4) [m] at times (K,) [s] within one part of a motion.

    T_start is the pose at the first time; of a constant twist that at the time ``since``, if that is given.

    A constant twist is followed exactly, a function of time to fourth order in the differences of the times (Magnus
    expansion).
    """
    if part >= len(motion) or isinstance(motion[part], ConstantTwist):
        begun = times[0] if since is None else since
        return _held(T_start, commands(motion, times[:1], part)[0], times - begun)
    steps = np.diff(times)[:, None]
    nodes = times[:-1, None] + steps * GAUSS
    early, late = np.moveaxis(commands(motion, nodes.ravel(), part).reshape(-1, 2, 6), 1, 0)
    moves = 0.5 * steps * (early + late)
    moves[:, 3:] += np.sqrt(3.0) / 12.0 * steps**2 * np.cross(late[:, 3:], early[:, 3:])
    return _moved(T_start, moves)


def _held(T_start: FloatArray, twist: FloatArray, times: FloatArray) -> FloatArray:
    """The poses (K, 4, 4) of a constant twist from T_start after times (K,) [s]."""
    moves = times[:, None] * twist
    poses = np.tile(T_start, (len(times), 1, 1))
    poses[:, :3, 3] += moves[:, :3]
    poses[:, :3, :3] = exp(moves[:, 3:]) @ T_start[:3, :3]
    return poses


def _moved(T_start: FloatArray, moves: FloatArray) -> FloatArray:
    """The poses after moves (K, 6), shift [m] and rotation vector [rad] along base axes; the start first."""
    poses = np.tile(np.eye(4), (len(moves) + 1, 1, 1))
    poses[0] = T_start
    poses[1:, :3, 3] = moves[:, :3]
    poses[:, :3, 3] = np.cumsum(poses[:, :3, 3], axis=0)  # one after the other, wherever a chunk begins
    for k, turn in enumerate(exp(moves[:, 3:])):
        poses[k + 1, :3, :3] = turn @ poses[k, :3, :3]
    return poses
