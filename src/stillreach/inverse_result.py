"""What came out of a search for joint positions, in arrays and in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach._words import direction, joined, share, shown
from stillreach.arm import Arm
from stillreach.arm.dexterity import directions, full_rates, least_speeds, task_jacobian
from stillreach.arm.losses import random_configurations
from stillreach.errors import InputError
from stillreach.task import Task

__all__ = ["Inverse"]

POOR = 0.05
"""Remaining manipulability at the median below which an arm counts as nearly singular."""


@dataclass(frozen=True, eq=False, repr=False)
class Inverse:
    """Joint positions for poses; ``str()`` says how many were reached, ``explain`` why one was not.

    The leading axes (...) are those of the poses.

    With ``solutions=S`` the arrays ``q`` and ``residual`` have one more axis, of length S, whose first ``found``
    entries are valid and the others NaN.

    Args:
        arm: the arm.
        task: rows, frame and point of the task; None: all six rows at the arm's tool.
        poses: (..., 4, 4) [m].
        tolerance: [m, rad] largest entry of a reached pose's error.
        held: names of the joints that stood still.
        q: (..., n) [rad, m]; where no start reached the pose, the closest configuration that was met.
        residual: (...) [m, rad] largest entry of the pose error in the task's rows.
        found: (...) int32 number of different configurations found, at most S.
        too_far: (...) bool: the pose is farther away than the arm with all links stretched, so no arm of these lengths
            reaches it.
        starts: (...) int32 starts that were used.
        steps: (...) int32 Gauss-Newton steps of all starts.
    """

    arm: Arm
    task: Task | None
    poses: FloatArray
    tolerance: float
    held: tuple[str, ...]
    q: FloatArray
    residual: FloatArray
    found: npt.NDArray[np.int32]
    too_far: npt.NDArray[np.bool_]
    starts: npt.NDArray[np.int32]
    steps: npt.NDArray[np.int32]

    @property
    def reached(self) -> npt.NDArray[np.bool_]:
        """(...) bool: whether a configuration within the tolerance was found."""
        return np.asarray(self.found > 0)

    @property
    def share(self) -> float:
        """The share of the poses that are reached; NaN without poses."""
        return float(np.mean(self.reached)) if self.found.size else math.nan

    def explain(self, index: int | tuple[int, ...] = ()) -> str:
        """What came out for one pose, in a sentence.

        Args:
            index: of the pose in the leading axes; () if there is one pose.

        Raises:
            InputError: if there is no such pose.
        """
        place = index if isinstance(index, tuple) else (index,)
        try:
            found, starts = int(self.found[place]), int(self.starts[place])
        except (IndexError, TypeError, ValueError):
            got = f"{index!r}"
            raise InputError("index", got, f"the index of a pose in an array of shape {self.found.shape}") from None
        if found:
            return f"reached{f' in {found} ways' if found > 1 else ''} after {starts} start{'s' if starts > 1 else ''}"
        at = self.q[place] if self.q.ndim == self.found.ndim + 1 else self.q[(*place, 0)]
        off = f"the closest configuration is {self._distance(self.poses[place], at)} off"
        if self.too_far[place]:
            return f"out of reach: farther away than the stretched arm is long; {off}"
        held = f" with {self._held_joints} held{self._outside(at)}" if self.held else ""
        text = f"not reached from {starts} start{'s' if starts > 1 else ''}{held}; {off}{self._ways_out(at)}"
        return f"{text}. {self.warning}" if self.warning else text

    @cached_property
    def remaining(self) -> float:
        """The manipulability without the held joints over that of all, 0 to 1: the median over the arm's range.

        NaN if the whole arm cannot do the task in most configurations.
        """
        free = [i for i, name in enumerate(self.arm.joint_names) if name not in self.held]
        q = random_configurations(self.arm)
        whole = self.arm.manipulability(q, self.task)
        left = self.arm.manipulability(q, self.task, joints=free) if free else np.zeros(len(q))
        return float(np.median(left / np.where(whole > 0.0, whole, math.nan)))

    @property
    def _held_joints(self) -> str:
        return "every joint" if len(self.held) == self.arm.n else joined(self.held, "and")

    def _outside(self, q: FloatArray) -> str:
        """Which held joints are outside their limits."""
        lower, upper = self.arm.position_limits.T
        names = [self.arm.joint_names[i] for i in np.flatnonzero((q < lower) | (q > upper))]
        return (
            f", {joined(names, 'and')} outside {'its' if len(names) == 1 else 'their'} position limits" if names else ""
        )

    @cached_property
    def warning(self) -> str:
        """A sentence about an arm that can do little without the held joints; empty for others."""
        rows, free = 6 if self.task is None else len(self.task.indices), self.arm.n - len(self.held)
        if not self.held or not self.remaining < POOR:
            return ""
        if free < rows:
            joints = f"{free} free joint{'s' if free > 1 else ''}"
            return (
                f"{joints} cannot follow the {rows} rows of the task: hardly any pose can be reached." if free else ""
            )
        return (
            f"Without {self._held_joints} this arm is nearly singular in most configurations (at the median "
            f"{share(self.remaining)} of its manipulability remains), so a search may miss a pose that it reaches: "
            "more starts find more."
        )

    def _distance(self, pose: FloatArray, q: FloatArray) -> str:
        rows = range(6) if self.task is None else self.task.indices
        own = self.arm
        if self.task is not None and self.task.tool is not None:
            own = own.with_tool(own.tool @ self.task.tool)
        T = own.forward(q)
        turn = math.acos(float(np.clip((np.trace(T[:3, :3].T @ pose[:3, :3]) - 1.0) / 2.0, -1.0, 1.0)))
        linear = sorted(row for row in rows if row < 3)
        gap = pose[:3, 3] - T[:3, 3]
        if self.task is not None and self.task.frame == "tool":
            gap = T[:3, :3].T @ gap
        parts = [shown(float(np.linalg.norm(gap[linear])), "m")] if linear else []
        if any(row >= 3 for row in rows):
            parts.append(shown(turn, "rad"))
        return joined(parts, "and")

    def _ways_out(self, q: FloatArray) -> str:
        """What keeps the closest configuration from coming closer."""
        if len(self.held) == self.arm.n:
            return ""
        free = np.array([name not in self.held for name in self.arm.joint_names])
        J = task_jacobian(self.arm, q, self.task) * np.where(free, full_rates(self.arm.velocity_limits), 0.0)
        rows = tuple(range(6)) if self.task is None else self.task.indices
        lost = directions(J, least_speeds(rows)).lost.T
        lower, upper = self.arm.position_limits.T
        ends = [
            f"{name} is at its {'lower' if q[i] <= lower[i] else 'upper'} limit"
            for i, name in enumerate(self.arm.joint_names)
            if free[i] and not lower[i] < q[i] < upper[i]
        ]
        words = [direction(twist, rows, signed=False) for twist in lost]
        if words:
            ends.insert(0, f"the tool cannot move along {joined(words, 'or')}")
        return f"; there {joined(ends, 'and')}" if ends else ""

    def __len__(self) -> int:
        if not self.found.ndim:
            raise TypeError("the result of one pose has no length")
        return len(self.found)

    def __str__(self) -> str:
        if not self.found.ndim:
            return self.explain()
        total, reached, far = self.found.size, int(np.count_nonzero(self.found)), int(np.count_nonzero(self.too_far))
        parts = [f"{reached} of {total} poses reached"]
        if far:
            parts.append(f"{far} out of reach")
        rest = total - reached - far
        if rest:
            starts = int(self.starts.max())
            parts.append(f"{rest} not reached from {starts} start{'s' if starts > 1 else ''}")
        text = "; ".join(parts)
        return f"{text}. {self.warning}" if rest and self.warning else text

    def __repr__(self) -> str:
        return f"<Inverse of {self.arm.name}: {self}>"
