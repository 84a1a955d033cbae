"""What an arm can do at a configuration, and what is left of it when one joint is locked there."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm import Arm

RANK_TOLERANCE = 1e-10
"""Singular values below this, relative to the largest, count as zero, as the laws count them."""

SHOWN = 0.05
"""Components of a direction below this are left out."""

CONFIGURATIONS = 200
SEED = 1994

COMPONENTS = ("vx", "vy", "vz", "wx", "wy", "wz")


@dataclass(frozen=True)
class Lock:
    """What locking one joint does.

    Args:
        joint: name.
        singular_values: (min(6, n - 1),) of the Jacobian without the joint, falling.
        rank: how many of them count.
        manipulability: what is left of the manipulability, 0 to 1; 0 where a direction is lost, or was lost before.
        lost: (lost, 6) orthonormal unit twists that were possible and no longer are [m, rad].
    """

    joint: str
    singular_values: FloatArray
    rank: int
    manipulability: float
    lost: FloatArray


@dataclass(frozen=True)
class Insight:
    """An arm at a configuration.

    Args:
        q: (n,) [rad, m].
        singular_values: (min(6, n),) of the Jacobian, falling [m, rad].
        locks: what locking each joint does there.
        typical: (n,) median over the arm's range of what is left of the manipulability without each joint.
    """

    q: FloatArray
    singular_values: FloatArray
    locks: list[Lock]
    typical: FloatArray

    @property
    def rank(self) -> int:
        """In how many directions the tool can move."""
        return rank(self.singular_values)


def insight(arm: Arm, q: FloatArray) -> Insight:
    """What an arm can do at q (n,) [rad, m], and what is left of it without each joint."""
    return Insight(q, singular_values(arm.jacobian(q)), locks(arm, q), typical(arm))


def singular_values(J: FloatArray) -> FloatArray:
    """(min(m, n),) falling; none for no column."""
    return np.asarray(np.linalg.svd(J, compute_uv=False)) if J.size else np.zeros(0)


def rank(sigma: FloatArray) -> int:
    """How many singular values count."""
    return int(np.count_nonzero(sigma > RANK_TOLERANCE * sigma[0])) if len(sigma) else 0


def locks(arm: Arm, q: FloatArray) -> list[Lock]:
    """What locking each joint of an arm at q (n,) [rad, m] does, in metres and radians.

    Manipulability without joint i over manipulability with it is the length of row i of an orthonormal basis of the
    null space of J.
    """
    J = arm.jacobian(q)
    U, sigma, Vt = np.linalg.svd(J, full_matrices=True)
    whole = rank(sigma)
    null_space = Vt[whole:].T
    found = []
    for i, name in enumerate(arm.joint_names):
        rest = np.delete(J, i, axis=1)
        left = singular_values(rest)
        lost = _lost(rest, U[:, :whole])
        kept = 0.0 if len(lost) else float(np.linalg.norm(null_space[i]))
        found.append(Lock(name, left, rank(left), kept, lost))
    return found


def typical(arm: Arm) -> FloatArray:
    """(n,) median manipulability without each joint, relative to the whole arm's, over its range.

    Over CONFIGURATIONS random ones within the position limits (half a turn or 1 m to both sides where there are none);
    always the same ones.
    """
    lower, upper = arm.position_limits.T
    span = np.where(arm.kinds == 1, 1.0, np.pi)
    low = np.where(np.isfinite(lower), lower, np.minimum(upper, span) - 2 * span)
    low = np.where(np.isfinite(lower) | np.isfinite(upper), low, -span)
    high = np.where(np.isfinite(upper), upper, low + 2 * span)
    q = np.random.default_rng(SEED).uniform(low, high, (CONFIGURATIONS, arm.n))
    _, sigma, Vt = np.linalg.svd(arm.jacobian(q), full_matrices=True)
    left = []
    for values, rows in zip(sigma, Vt, strict=True):
        left.append(np.linalg.norm(rows[rank(values) :], axis=0))
    return np.asarray(np.median(left, axis=0))


def _lost(rest: FloatArray, served: FloatArray) -> FloatArray:
    """(lost, 6) directions within those served (6, k) that a Jacobian without a joint does not serve."""
    if rest.size == 0:
        return np.ascontiguousarray(served.T)
    U, sigma, _ = np.linalg.svd(served.T @ rest, full_matrices=True)
    return np.ascontiguousarray((served @ U[:, rank(sigma) :]).T)


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
