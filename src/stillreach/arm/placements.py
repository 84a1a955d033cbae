"""The few rigid transforms that arms are built from: 4 x 4 matrices, to be chained with ``@``."""

from __future__ import annotations

import math

import numpy as np

from stillreach._door import FloatArray


def translation(x: float, y: float, z: float) -> FloatArray:
    """Shift by (x, y, z) [m]."""
    T = np.eye(4)
    T[:3, 3] = (x, y, z)
    return T


def rotation_x(angle: float) -> FloatArray:
    """Turn about x by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])


def rotation_z(angle: float) -> FloatArray:
    """Turn about z by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def rotation_y(angle: float) -> FloatArray:
    """Turn about y by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1.0]])


def from_quaternion(w: float, x: float, y: float, z: float) -> FloatArray:
    """Turn by a quaternion of length 1, w its scalar part."""
    T = np.eye(4)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    T[:3, :3] += 2.0 * w * K + 2.0 * (K @ K)
    return T


def shortest_turn_from_z(direction: FloatArray) -> FloatArray:
    """(3, 3) rotation matrix of the shortest turn of the z axis into a direction of length 1; to -z it is about x."""
    x, y, z = direction
    across = x * x + y * y
    if across < 1e-18:  # rounding of ±z
        return np.diag([1.0, math.copysign(1.0, z), math.copysign(1.0, z)])
    k = 1.0 / (1.0 + z) if z > 0.0 else (1.0 - z) / across  # equal; each where it is accurate
    return np.array([[1.0 - k * x * x, -k * x * y, x], [-k * x * y, 1.0 - k * y * y, y], [-x, -y, z]])


def moved(kind: str, axis: FloatArray, position: float) -> FloatArray:
    """What a joint at a position does: a turn about its axis [rad] (Rodrigues), or a shift along it [m].

    Args:
        kind: ``"revolute"`` or ``"prismatic"``.
        axis: (3,) of length 1.
        position: of the joint.
    """
    T = np.eye(4)
    if kind == "prismatic":
        T[:3, 3] = position * axis
        return T
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    T[:3, :3] += math.sin(position) * K + 2.0 * math.sin(position / 2.0) ** 2 * (K @ K)
    return T
