"""Limits for a whole chain at once: arrays over the joints, written into the joints."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm.joint import Joint


def limited(
    joints: Sequence[Joint],
    *,
    velocity: npt.ArrayLike | None = None,
    position: npt.ArrayLike | None = None,
    acceleration: npt.ArrayLike | None = None,
) -> tuple[Joint, ...]:
    """The same joints with other limits; None keeps the present ones.

    Args:
        joints: n joints.
        velocity: (n,) or one number for all [rad/s] or [m/s], at least 0.
        position: (n, 2) or one pair (lower, upper) for all [rad] or [m].
        acceleration: (n,) or one number for all [rad/s²] or [m/s²], at least 0.

    Raises:
        InputError: if a shape is wrong, a value is NaN, a velocity is negative, or lower is above upper.
    """
    n = len(joints)
    changes: list[dict[str, Any]] = [{} for _ in joints]
    if velocity is not None:
        _set(changes, "velocity_limit", symmetric_limits("velocity", velocity, n))
    if acceleration is not None:
        _set(changes, "acceleration_limit", symmetric_limits("acceleration", acceleration, n))
    if position is not None:
        _set(changes, "position_limits", _pairs("position", position, n))
    return tuple(replace(joint, **change) for joint, change in zip(joints, changes, strict=True))


def symmetric_limits(name: str, value: npt.ArrayLike, n: int) -> FloatArray:
    """Limits (n,) that hold in both directions, from n numbers or one for all: at least 0, inf for none."""
    return _door.vector(name, value, n, allow_inf=True, minimum=0.0)


def driven(joints: list[Joint], velocity_limits: npt.ArrayLike | None) -> Iterable[Joint]:
    """The joints with a builder's ``velocity_limits``; None: no limits."""
    if velocity_limits is None:
        return joints
    return limited(joints, velocity=symmetric_limits("velocity_limits", velocity_limits, len(joints)))


def _pairs(name: str, value: npt.ArrayLike, n: int) -> FloatArray:
    if isinstance(value, list | tuple | np.ndarray) and len(value) == 2 and np.ndim(value[0]) == 0:
        value = [value] * n
    return _door.matrix(name, value, (n, 2), allow_inf=True)


def _set(changes: list[dict[str, Any]], field: str, values: FloatArray) -> None:
    for change, value in zip(changes, values.tolist(), strict=True):
        change[field] = value


def sampling_range(kinds: npt.NDArray[np.int8], lower: FloatArray, upper: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n,) lower and upper ends of the positions that random configurations have [rad, m].

    They are the limits; without one, and where they are more than two turns or 4 m apart, a range of one turn or 2 m.
    """
    span = np.where(kinds == 1, 1.0, np.pi)
    wide = ~(upper - lower <= 4 * span) & np.isfinite(upper - lower)
    middle = np.clip(0.0, lower, upper)
    low = np.where(np.isfinite(lower), lower, np.minimum(upper, span) - 2 * span)
    low = np.where(np.isfinite(lower) | np.isfinite(upper), low, -span)
    low = np.where(wide, np.clip(middle - span, lower, upper - 2 * span), low)
    high = np.where(np.isfinite(upper) & ~wide, upper, low + 2 * span)
    return np.ascontiguousarray(low), np.ascontiguousarray(high)
