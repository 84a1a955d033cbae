"""What an arm can do at a configuration, and what is left of it when one joint is locked there."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.arm.dexterity import (
    LEAST_SPEED,
    LEAST_TURN,
    Directions,
    directions,
    full_rates,
    least_speeds,
    task_jacobian,
)
from stillreach.task import Task

SHOWN = 0.05
"""Components of a direction below this are left out."""

CONFIGURATIONS = 200
SEED = 1994

COMPONENTS = ("vx", "vy", "vz", "wx", "wy", "wz")
WHOLE_POSE = Task()


@dataclass(frozen=True)
class Lock:
    """What locking one joint does.

    Args:
        joint: name.
        singular_values: (min(m, n - 1),) of the Jacobian without the joint, falling.
        rank: in how many directions the tool can move without it.
        manipulability: remaining manipulability, 0 to 1; 0 where a direction is lost.
        lost: (lost, m) orthonormal unit twists that were possible and no longer are [m, rad].
    """

    joint: str
    singular_values: FloatArray
    rank: int
    manipulability: float
    lost: FloatArray


@dataclass(frozen=True)
class Survey:
    """An arm over its range.

    Args:
        typical: (n,) median of the remaining manipulability without each joint, 0 to 1.
        best: (n,) the configuration of all those looked at where the tool moves best [rad, m].
    """

    typical: FloatArray
    best: FloatArray


@dataclass(frozen=True)
class Gauge:
    """What motion of the tool counts.

    Args:
        task: rows and axes.
        speed, turn: a direction in which full rates give less is lost [m/s], [rad/s].
    """

    task: Task = WHOLE_POSE
    speed: float = LEAST_SPEED
    turn: float = LEAST_TURN

    @property
    def least(self) -> FloatArray:
        """(m,) least speeds of the task's rows."""
        return least_speeds(self.task.indices, self.speed, self.turn)


USUAL = Gauge()


@dataclass(frozen=True)
class Place:
    """An arm at a configuration.

    Args:
        J: (m, n) Jacobian of the task's rows; 0 for joints that cannot move [m, rad].
        rates: (n,) full rates.
        least: (m,) least speeds of the rows.
        whole: directions of the whole arm.
    """

    J: FloatArray
    rates: FloatArray
    least: FloatArray
    whole: Directions

    @classmethod
    def of(cls, arm: Arm, q: FloatArray, gauge: Gauge) -> Place:
        """The arm at q (n,) [rad, m]."""
        rates = full_rates(arm.velocity_limits)
        J = task_jacobian(arm, q, gauge.task) * (rates > 0.0)
        return cls(J, rates, gauge.least, directions(J * rates, gauge.least))

    def lost_without(self, joint: int) -> FloatArray:
        """(m, lost) orthonormal directions that the whole arm serves, and not without a joint."""
        served = self.whole.served
        rest = np.delete(served.T @ (self.J * self.rates), joint, axis=1)
        return served @ directions(rest, self.least, served).lost

    def remaining(self) -> FloatArray:
        """(n,) manipulability without each joint over manipulability with it, in the directions that are served.

        It is the length of the joint's row in an orthonormal basis of the null space of J.
        """
        served = self.whole.served
        _, _, Vt = np.linalg.svd(served.T @ self.J, full_matrices=True)
        return np.asarray(np.linalg.norm(Vt[served.shape[1] :], axis=0))


@dataclass(frozen=True)
class Insight:
    """An arm at a configuration.

    Args:
        q: (n,) [rad, m].
        gauge: the task, and what counts as lost.
        singular_values: (min(m, n),) of the Jacobian, falling [m, rad].
        rank: in how many directions the tool can move.
        locks: what locking each joint does there.
        typical: (n,) median over the arm's range of the remaining manipulability without each joint.
    """

    q: FloatArray
    gauge: Gauge
    singular_values: FloatArray
    rank: int
    locks: list[Lock]
    typical: FloatArray


def insight(arm: Arm, q: FloatArray, seen: Survey, gauge: Gauge = USUAL) -> Insight:
    """What an arm can do at q (n,) [rad, m], and what is left of it without each joint."""
    place = Place.of(arm, q, gauge)
    rank = place.whole.served.shape[1]
    return Insight(q, gauge, _singular_values(place.J), rank, locks(arm, q, gauge), seen.typical)


def locks(arm: Arm, q: FloatArray, gauge: Gauge = USUAL) -> list[Lock]:
    """What locking each joint of an arm at q (n,) [rad, m] does, in metres and radians."""
    place = Place.of(arm, q, gauge)
    rank = place.whole.served.shape[1]
    found = []
    for i, (name, kept) in enumerate(zip(arm.joint_names, place.remaining(), strict=True)):
        lost = np.ascontiguousarray(place.lost_without(i).T)
        sigma = _singular_values(np.delete(place.J, i, axis=1))
        found.append(Lock(name, sigma, rank - len(lost), 0.0 if len(lost) else float(kept), lost))
    return found


def survey(arm: Arm, gauge: Gauge = USUAL) -> Survey:
    """Looks at an arm over its range.

    That is at CONFIGURATIONS random ones within the position limits (half a turn or 1 m to both sides where there are
    none); always the same ones. The best one has the most directions, and among equals the largest manipulability, with
    rates measured in their limits.
    """
    typical, marks = [], []
    poses = _configurations(arm)
    for q in poses:
        place = Place.of(arm, q, gauge)
        kept = place.remaining()
        typical.append([0.0 if place.lost_without(i).size else kept[i] for i in range(arm.n)])
        gains = place.whole.gains
        marks.append((len(gains), float(np.sum(np.log(gains)))))
    return Survey(np.median(typical, axis=0), poses[max(range(len(poses)), key=marks.__getitem__)])


def direction(twist: FloatArray, rows: Iterable[int] = range(6)) -> str:
    """A unit twist in words: its components that matter, e.g. ``vz`` or ``0.8 vx - 0.6 wy``.

    Args:
        twist: (m,) its components.
        rows: (m,) which ones of [v; w] they are.
    """
    parts = [(float(value), COMPONENTS[row]) for value, row in zip(twist, rows, strict=True) if abs(value) >= SHOWN]
    if parts[0][0] < 0.0:  # a direction and its opposite are lost together
        parts = [(-value, name) for value, name in parts]
    if len(parts) == 1:
        return parts[0][1]
    text = " ".join(f"{'-' if value < 0 else '+'} {abs(value):.2f} {name}" for value, name in parts)
    return text.removeprefix("+ ")


def _singular_values(J: FloatArray) -> FloatArray:
    """(min(m, n),) falling; none for no column."""
    return np.asarray(np.linalg.svd(J, compute_uv=False)) if J.size else np.zeros(0)


def _configurations(arm: Arm) -> FloatArray:
    """(CONFIGURATIONS, n) [rad, m]."""
    lower, upper = arm.position_limits.T
    span = np.where(arm.kinds == 1, 1.0, np.pi)
    low = np.where(np.isfinite(lower), lower, np.minimum(upper, span) - 2 * span)
    low = np.where(np.isfinite(lower) | np.isfinite(upper), low, -span)
    high = np.where(np.isfinite(upper), upper, low + 2 * span)
    return np.random.default_rng(SEED).uniform(low, high, (CONFIGURATIONS, arm.n))
