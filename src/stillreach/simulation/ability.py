"""What rates inside their bounds can do along a direction of the task, and directions in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stillreach._door import FloatArray
from stillreach.simulation.fields import TWIST_COMPONENTS

LEAST_SPEED, LEAST_TURN = 1e-3, float(np.deg2rad(0.1))
"""[m/s] and [rad/s]: a direction in which no rates inside the bounds give more is lost."""
FULL_RATE = 1.0
"""[rad/s, m/s] what an infinite bound counts as."""
SHOWN = 0.05
"""Components of a direction below this are left out."""
ROUNDING = 1e-9
"""Relative; a joint that pushes less along a direction does not push."""


def most_along(J: FloatArray, lower: FloatArray, upper: FloatArray, direction: FloatArray) -> float:
    """The largest direction · (J rates) of all rates inside the bounds.

    Args:
        J: (m, n) Jacobian.
        lower: (n,) bounds of the rates.
        upper: likewise.
        direction: (m,).
    """
    push = direction @ J
    pushes = np.abs(push) > ROUNDING * np.linalg.norm(J, axis=0) * np.linalg.norm(direction)
    return float(np.sum(push[pushes] * np.where(push > 0.0, upper, lower)[pushes]))


def lost_directions(J: FloatArray, lower: FloatArray, upper: FloatArray, rows: Sequence[int]) -> FloatArray:
    """(lost, m) orthonormal directions in which no rates inside the bounds give LEAST_SPEED or LEAST_TURN.

    They are judged by gain, not by rank: rounded numbers in a robot's file leave a rank, and no motion.

    Args:
        J: (m, n) Jacobian [m, rad].
        lower: (n,) bounds of the rates [rad/s, m/s].
        upper: likewise.
        rows: (m,) which ones of [v; w] its rows are.
    """
    extent = np.maximum(np.abs(lower), np.abs(upper))
    extent = np.where(lower < upper, np.where(np.isinf(extent), FULL_RATE, extent), 0.0)
    least = np.array([LEAST_SPEED if row < 3 else LEAST_TURN for row in rows])
    scaled = J * extent / least[:, None]
    U, _, _ = np.linalg.svd(scaled, full_matrices=True)
    lost = U[:, np.sum(np.abs(U.T @ scaled), axis=1) < 1.0] / least[:, None]
    return np.ascontiguousarray(np.linalg.qr(lost)[0].T)


def in_words(direction: FloatArray, rows: Sequence[int], *, signed: bool = True) -> str:
    """A direction by its components that matter: ``-vz`` or ``0.32 vx + 0.94 wy``.

    Args:
        direction: (m,) of length 1.
        rows: (m,) which ones of [v; w] its components are.
        signed: whether the opposite direction is another one.
    """
    parts = [(float(value), TWIST_COMPONENTS[row]) for value, row in zip(direction, rows, strict=True)]
    parts = [part for part in parts if abs(part[0]) >= SHOWN]
    if not signed and parts[0][0] < 0.0:
        parts = [(-value, name) for value, name in parts]
    if len(parts) == 1:
        return f"{'-' if parts[0][0] < 0 else ''}{parts[0][1]}"
    text = " ".join(f"{'-' if value < 0 else '+'} {abs(value):.2f} {name}" for value, name in parts)
    return text.removeprefix("+ ").replace("- ", "-", 1) if parts[0][0] < 0 else text.removeprefix("+ ")
