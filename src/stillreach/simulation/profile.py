"""Speed profiles: the fraction of the path over the fraction of the time."""

from __future__ import annotations

import numpy as np

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.errors import InputError

PROFILES = ("constant", "trapezoidal", "minimum-jerk")
RAMP = 0.25


def checked_profile(profile: str, ramp: float) -> tuple[str, float]:
    """A valid profile and ramp; raises InputError otherwise."""
    number = _door.scalar("ramp", ramp)
    if not 0.0 < number <= 0.5:
        raise InputError("ramp", f"{number:g}", "a fraction of the time above 0, at most 0.5")
    return _door.choice("profile", profile, PROFILES), number


def progress(profile: str, ramp: float, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Fraction of the path, and its slope, at fractions of the time.

    ``constant``: constant speed. ``trapezoidal``: constant acceleration during the first ``ramp``, deceleration during
    the last. ``minimum-jerk``: 10 u³ - 15 u⁴ + 6 u⁵, the quintic that starts and ends at rest without acceleration
    (Flash and Hogan, 1985).

    Args:
        profile: one of PROFILES.
        ramp: fraction of the time, for ``trapezoidal`` only.
        u: (K,) from 0 to 1.

    Returns:
        (K,) fractions from 0 to 1, and (K,) slopes: speed over mean speed.
    """
    if profile == "constant":
        return u, np.ones_like(u)
    if profile == "minimum-jerk":
        return u**3 * (10.0 + u * (6.0 * u - 15.0)), 30.0 * (u * (1.0 - u)) ** 2
    peak = 1.0 / (1.0 - ramp)
    near = np.minimum(u, 1.0 - u)  # time to the nearer end
    way = np.where(near < ramp, peak * near**2 / (2.0 * ramp), peak * (near - ramp / 2.0))
    return np.where(u <= 0.5, way, 1.0 - way), peak * np.minimum(near / ramp, 1.0)
