"""The few rigid transforms that arms are built from: 4 x 4 matrices, to be chained with ``@``."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach._rotations import about, from_rpy


def translation(x: float, y: float, z: float) -> FloatArray:
    """Shift by (x, y, z) [m]."""
    T = np.eye(4)
    T[:3, 3] = (x, y, z)
    return T


def turned(R: FloatArray) -> FloatArray:
    """Turn by a rotation matrix (3, 3)."""
    T = np.eye(4)
    T[:3, :3] = R
    return T


def placed(x: float, y: float, z: float, roll: float, pitch: float, yaw: float) -> FloatArray:
    """Shift by (x, y, z) [m], then turn by roll, pitch and yaw [deg] as in URDF."""
    return translation(x, y, z) @ turned(from_rpy(np.radians((roll, pitch, yaw))))


def moved(kind: str, axis: npt.ArrayLike, position: float) -> FloatArray:
    """The motion of a joint: a turn about its axis [rad], or a shift along it [m].

    Args:
        kind: ``"revolute"`` or ``"prismatic"``.
        axis: (3,) of length 1.
        position: of the joint.
    """
    if kind == "prismatic":
        return translation(*(position * np.asarray(axis)))
    return turned(about(axis, position))


def rigid(T: FloatArray) -> FloatArray:
    """The transform with the rounding of many products taken out of its rotation."""
    R = T[:3, :3]
    if np.max(np.abs(R @ R.T - np.eye(3))) > 1e-14:
        U, _, Vt = np.linalg.svd(R)
        R = U @ Vt
    return translation(*T[:3, 3]) @ turned(R)


def inverse(T: FloatArray) -> FloatArray:
    """The inverse of a rigid transform."""
    back = turned(T[:3, :3].T)
    return back @ translation(*-T[:3, 3])
