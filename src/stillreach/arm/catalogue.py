"""Arms that come with the package (``stillreach.arms``); all have finite rate limits."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach.arm.joint import Joint
from stillreach.arm.model import Arm
from stillreach.arm.placements import translation

__all__ = ["canadarm2", "nasa_modular", "planar", "snake"]

X_AXIS, Y_AXIS, Z_AXIS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
LINK_30_INCH = 0.762


def nasa_modular(lengths: npt.ArrayLike = (LINK_30_INCH,) * 6) -> Arm:
    """The modular arm of Bedrossian (1994): R P R P R P R P R P R, straight up along +z at zero, 50 deg/s.

    It has no position limits. The paper gives its reach, 15 ft, and no lengths; six equal segments of 30 in
    are inferred from what it reports.

    Args:
        lengths: (6,) [m] base to first pitch, four between pitches, last pitch to tool; or one for all.

    Raises:
        InputError: the lengths are something else.
    """
    return Arm.from_modules("RPRPRPRPRPR", lengths, velocity_limits=np.deg2rad(50.0), name="nasa_modular")


def planar(n: int) -> Arm:
    """Unit links along x that turn about z: an arm in the xy-plane, 1 rad/s, no position limits.

    Args:
        n: number of joints.

    Raises:
        InputError: n is not an integer of at least 1.
    """
    n = _door.count("n", n)
    link = translation(1.0, 0.0, 0.0)
    joints = [Joint(placement=None if i == 0 else link, axis=Z_AXIS, velocity_limit=1.0) for i in range(n)]
    return Arm(joints, tool=link, name=f"planar{n}")


def snake(n: int) -> Arm:
    """Links of 0.1 m along x that pitch (about y) and yaw (about z) in turn, 1 rad/s, no position limits.

    Args:
        n: number of joints.

    Raises:
        InputError: n is not an integer of at least 1.
    """
    n = _door.count("n", n)
    link = translation(0.1, 0.0, 0.0)
    axes = [Y_AXIS if i % 2 == 0 else Z_AXIS for i in range(n)]
    joints = [Joint(placement=None if i == 0 else link, axis=axis, velocity_limit=1.0) for i, axis in enumerate(axes)]
    return Arm(joints, tool=link, name=f"snake{n}")


def canadarm2() -> Arm:
    """The 7-joint arm of the International Space Station, stretched out along x at zero; ±270 deg, 4 deg/s.

    Published geometry: a shift from joint to joint [m] and an axis each; at zero no frame is turned.
    """
    chain = [
        ((1.3589, 0.0, 0.0), X_AXIS),  # shoulder roll
        ((0.0, 0.0, 0.7026), Z_AXIS),  # shoulder yaw
        ((0.0, -0.5692, 0.0), Y_AXIS),  # shoulder pitch
        ((7.11, -0.475, 0.0), Y_AXIS),  # elbow pitch
        ((7.11, 0.0, 0.0), Y_AXIS),  # wrist pitch
        ((0.0, -0.5692, 0.0), Z_AXIS),  # wrist yaw
        ((0.0, 0.0, -0.7026), X_AXIS),  # wrist roll
    ]
    turn = np.deg2rad(270.0)
    joints = [
        Joint(
            placement=translation(*shift),
            axis=axis,
            position_limits=(-turn, turn),
            velocity_limit=np.deg2rad(4.0),
        )
        for shift, axis in chain
    ]
    return Arm(joints, tool=translation(1.3589, 0.0, 0.0), name="canadarm2")
