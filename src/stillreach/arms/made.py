"""Arms that are made by a rule; all have finite rate limits. NumPy is imported when one is made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy.typing as npt

    from stillreach.arm import Arm

LINK_30_INCH = 0.762
Axis = tuple[float, float, float]
Y_AXIS: Axis = (0.0, 1.0, 0.0)
Z_AXIS: Axis = (0.0, 0.0, 1.0)


def nasa_modular(lengths: npt.ArrayLike = (LINK_30_INCH,) * 6) -> Arm:
    """The modular arm of Bedrossian (1994): R P R P R P R P R P R, straight up along +z at zero, 50 deg/s.

    It has no position limits. The paper gives its reach, 15 ft, and no lengths; six equal segments of 30 in
    are inferred from what it reports.

    Args:
        lengths: (6,) [m] base to first pitch, four between pitches, last pitch to tool; or one for all.

    Raises:
        InputError: if the lengths are invalid.
    """
    from stillreach.arm import Arm

    return Arm.from_modules("RPRPRPRPRPR", lengths, velocity_limits=math.radians(50.0), name="nasa_modular")


def planar(n: int) -> Arm:
    """N links of 1 m along x that turn about z: an arm in the xy-plane, 1 rad/s, no position limits.

    Args:
        n: number of joints.

    Raises:
        InputError: if n is not an integer of at least 1.
    """
    return _links("planar", n, length=1.0, axes=(Z_AXIS,))


def snake(n: int) -> Arm:
    """N links of 0.1 m along x that pitch (about y) and yaw (about z) in turn, 1 rad/s, no position limits.

    Args:
        n: number of joints.

    Raises:
        InputError: if n is not an integer of at least 1.
    """
    return _links("snake", n, length=0.1, axes=(Y_AXIS, Z_AXIS))


def _links(name: str, n: int, *, length: float, axes: Sequence[Axis]) -> Arm:
    """Links of one length along x, whose joints have these axes in turn."""
    from stillreach import _door
    from stillreach.arm import Arm, Joint
    from stillreach.arm.placements import translation

    n = _door.count("n", n)
    link = translation(length, 0.0, 0.0)
    joints = [Joint(placement=link if i else None, axis=axes[i % len(axes)], velocity_limit=1.0) for i in range(n)]
    return Arm(joints, tool=link, name=f"{name}{n}")
