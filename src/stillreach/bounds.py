"""Rate bounds: the form in which laws see faults and limits."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.errors import InputError

__all__ = ["Bounds"]


@dataclass(frozen=True, eq=False)
class Bounds:
    """Lower and upper bound of each joint's rate. A fault is a bound: a locked joint has both at 0.

    Args:
        lower: (n,) [rad/s, m/s], -inf for none.
        upper: (n,) [rad/s, m/s], at least ``lower``; inf for none.

    Raises:
        InputError: if the vectors differ in length, hold a NaN, or a lower bound exceeds its upper bound.
    """

    lower: FloatArray
    upper: FloatArray

    def __init__(self, lower: npt.ArrayLike, upper: npt.ArrayLike) -> None:
        low = _door.vector("lower", lower, None, allow_inf=True)
        high = _door.vector("upper", upper, len(low), allow_inf=True)
        wrong = np.flatnonzero((low > high) | (low == np.inf) | (high == -np.inf))
        if len(wrong):
            i = int(wrong[0])
            raise InputError(
                "lower", f"bounds [{low[i]:g}, {high[i]:g}] of joint {i}", "lower <= upper with room for a finite rate"
            )
        object.__setattr__(self, "lower", low)
        object.__setattr__(self, "upper", high)

    @classmethod
    def symmetric(cls, limit: npt.ArrayLike, *, n: int) -> Bounds:
        """Rates within ±limit: (n,) or one for all [rad/s, m/s], at least 0 (0 means that the joint may not move)."""
        high = _door.vector("limit", limit, n, allow_inf=True, minimum=0.0)
        return cls(-high, high)

    @classmethod
    def unbounded(cls, n: int) -> Bounds:
        """No bounds on n joints."""
        return cls.symmetric(np.inf, n=n)

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.lower)

    @property
    def fixed(self) -> npt.NDArray[np.bool_]:
        """(n,) which joints have one rate left."""
        return np.equal(self.lower, self.upper)

    def lock(self, joints: Iterable[int]) -> Bounds:
        """These bounds with the given joints (0-based indices) locked at rate 0."""
        bounds = self
        for joint in joints:
            bounds = bounds.fix(joint, 0.0)
        return bounds

    def fix(self, joint: int, rate: float) -> Bounds:
        """These bounds with one joint fixed at a rate [rad/s, m/s], as of a runaway drive."""
        index = _door.count("joint", joint, minimum=0)
        if index >= self.n:
            raise InputError("joint", str(index), f"an index from 0 to {self.n - 1}")
        low, high = self.lower.copy(), self.upper.copy()
        low[index] = high[index] = _door.scalar("rate", rate)
        return Bounds(low, high)
