"""Joint values outside their position limits, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stillreach._door import FloatArray

if TYPE_CHECKING:
    from stillreach.arm.model import Arm

ROUNDING = 1e-6
"""[rad, m] tolerance for values rounded to six decimals."""


class Outside(NamedTuple):
    """A joint value outside its limits.

    Args:
        joint: index.
        got: joint and value, in words.
        expected: its limits, in words.
    """

    joint: int
    got: str
    expected: str


def outside(arm: Arm, q: FloatArray, limits: FloatArray) -> list[Outside]:
    """The joints of q (n,) [rad, m] that are outside their position limits (n, 2)."""
    lower, upper = limits.T
    found = []
    for i in np.flatnonzero((q < lower - ROUNDING) | (q > upper + ROUNDING)):
        show = _metres if arm.kinds[i] else _radians
        expected = f"a value within its position limits, {show(lower[i], upper[i])}"
        found.append(Outside(int(i), f"{arm.joint_names[i]} at {show(q[i])}", expected))
    return found


def _metres(*values: float) -> str:
    return f"{' … '.join(f'{value:.4g}' for value in values)} m"


def _radians(*values: float) -> str:
    degrees = " … ".join(f"{np.degrees(value):.4g}" for value in values)
    return f"{' … '.join(f'{value:.4g}' for value in values)} rad ({degrees} deg)"
