"""Limits of a controller: checked, and scaled by the speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._labels import in_order
from stillreach.arm.model import Arm
from stillreach.errors import InputError


@dataclass(frozen=True, eq=False)
class Limits:
    """What the drives allow.

    Args:
        velocity: (n, 2) lower <= 0 <= upper [rad/s, m/s].
        position: (n, 2) lower <= upper [rad, m].
        acceleration: (n,) at least 0 [rad/s², m/s²].
        speed: fraction of everything that is commanded, from 0 to 1; rates stay below that fraction of their limits.
    """

    velocity: FloatArray
    position: FloatArray
    acceleration: FloatArray
    speed: float = 1.0

    def changed(self, arm: Arm, names: Mapping[str, str], **values: npt.ArrayLike | None) -> Limits:
        """The same limits with the given ones in place of theirs; None keeps a limit.

        Args:
            arm: whose joints have these limits.
            names: what each limit is called in messages.
            **values: velocity, position, acceleration.

        Raises:
            InputError: if a limit has a wrong shape, holds a NaN, or lower exceeds upper.
        """
        checks = {"velocity": velocity_limits, "position": position_limits, "acceleration": acceleration_limits}
        given: dict[str, Any] = {
            key: checks[key](names[key], value, arm) for key, value in values.items() if value is not None
        }
        return replace(self, **given)

    def rates(self) -> FloatArray:
        """(n, 2) the largest rates at this speed; none at speed 0, also of joints without a limit."""
        scaled: FloatArray = self.velocity * self.speed if self.speed > 0.0 else np.zeros_like(self.velocity)
        return scaled

    def core(self) -> dict[str, Any]:
        """What the compiled core reads."""
        rates = self.rates()
        return {
            "rate_lower": np.ascontiguousarray(rates[:, 0]),
            "rate_upper": np.ascontiguousarray(rates[:, 1]),
            "position_lower": np.ascontiguousarray(self.position[:, 0]),
            "position_upper": np.ascontiguousarray(self.position[:, 1]),
            "acceleration": self.acceleration,
            "speed": self.speed,
        }


def of_arm(arm: Arm) -> Limits:
    """The arm's own limits."""
    high = arm.velocity_limits
    return Limits(_door.frozen(np.stack([-high, high], axis=1)), arm.position_limits, arm.acceleration_limits)


def velocity_limits(name: str, value: npt.ArrayLike, arm: Arm) -> FloatArray:
    """(n, 2) from one number for all, (n,) or (n, 2); or by joint name."""
    given = _by_joint(name, value, arm)
    if given.ndim == 2:
        limits = _door.matrix(name, given, (arm.n, 2), allow_inf=True)
        if np.any(limits[:, 0] > 0.0) or np.any(limits[:, 1] < 0.0):
            raise InputError(name, _door.describe(value), "lower <= 0 <= upper for each joint")
        return limits
    high = _door.vector(name, given, arm.n, allow_inf=True, minimum=0.0)
    return _door.frozen(np.stack([-high, high], axis=1))


def position_limits(name: str, value: npt.ArrayLike, arm: Arm) -> FloatArray:
    """(n, 2) from one pair for all or (n, 2); or by joint name."""
    given = _by_joint(name, value, arm)
    both = np.broadcast_to(given, (arm.n, 2)) if given.shape == (2,) else given
    limits = _door.matrix(name, both, (arm.n, 2), allow_inf=True)
    lower, upper = limits.T
    if np.any(lower > upper) or np.any(lower == np.inf) or np.any(upper == -np.inf):
        raise InputError(name, _door.describe(value), "lower <= upper for each joint, with room for a position")
    return limits


def acceleration_limits(name: str, value: npt.ArrayLike, arm: Arm) -> FloatArray:
    """(n,) from one number for all or (n,); or by joint name."""
    return _door.vector(name, value, arm.n, allow_inf=True, minimum=0.0, labels=arm.labels)


def track_limits(value: npt.ArrayLike | None) -> tuple[float, float] | None:
    """Largest linear and angular correction as given; None: the controller chooses."""
    if value is None:
        return None
    linear, angular = _door.vector("track_limits", value, 2, allow_inf=True, minimum=0.0)
    return float(linear), float(angular)


def _by_joint(name: str, value: Any, arm: Arm) -> FloatArray:
    """The value as an array whose first axis is over the joints, or a number or pair for all."""
    given = _door.array(name, in_order(name, value, arm.labels), "numbers for each joint")
    return given.T if isinstance(value, Mapping) and given.ndim == 2 else given
