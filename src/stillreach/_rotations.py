"""Rotation matrices from and to the forms that people write rotations in; any number at once."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.errors import InputError


def about(axes: npt.ArrayLike, angles: npt.ArrayLike) -> FloatArray:
    """Matrices (..., 3, 3) of turns about axes (..., 3) of length 1 by angles (...) [rad] (Rodrigues)."""
    axes, angles = np.asarray(axes, float), np.asarray(angles, float)[..., None, None]
    x, y, z = np.moveaxis(axes, -1, 0)
    zero = np.zeros_like(x)
    K = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*axes.shape, 3)
    turns: FloatArray = np.eye(3) + np.sin(angles) * K + 2.0 * np.sin(angles / 2.0) ** 2 * (K @ K)
    return turns


def exp(vectors: npt.ArrayLike) -> FloatArray:
    """Matrices (..., 3, 3) of rotation vectors (..., 3) [rad]."""
    vectors = np.asarray(vectors, float)
    angles = np.linalg.norm(vectors, axis=-1)
    return about(vectors / np.where(angles == 0.0, 1.0, angles)[..., None], angles)


def log(R: FloatArray) -> FloatArray:
    """Rotation vectors (K, 3) [rad] of matrices (K, 3, 3), no longer than π.

    Through the quaternion by its largest component (Shepperd, 1978), so that no angle loses digits.
    """
    quaternions = to_quaternions(R)
    quaternions *= np.where(quaternions[:, :1] < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(quaternions[:, 1:], axis=1)
    small = sine < 1e-8
    gain = np.where(small, 2.0, 2.0 * np.arctan2(sine, quaternions[:, 0]) / np.where(small, 1.0, sine))
    vectors: FloatArray = gain[:, None] * quaternions[:, 1:]
    return vectors


def to_quaternions(R: FloatArray) -> FloatArray:
    """(K, 4) w x y z of matrices (K, 3, 3).

    Row k of the symmetric 4 x 4 matrix below is 4 q_k times the quaternion; the row of the largest q_k is taken.
    """
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(R, 0, 2)
    rows = np.array(
        [
            [1 + a + e + i, h - f, c - g, d - b],
            [h - f, 1 + a - e - i, b + d, c + g],
            [c - g, b + d, 1 - a + e - i, f + h],
            [d - b, c + g, f + h, 1 - a - e + i],
        ]
    )
    largest = np.argmax(np.diagonal(rows), axis=1)
    chosen: FloatArray = rows[largest, :, np.arange(len(R))]
    chosen /= np.linalg.norm(chosen, axis=1, keepdims=True)
    return chosen


def from_quaternions(name: str, quaternions: npt.ArrayLike) -> FloatArray:
    """Matrices (..., 3, 3) of quaternions (..., 4), w x y z; any length but 0 is scaled to 1.

    Raises:
        InputError: if one has length 0; the argument is ``name``.
    """
    quaternions = np.asarray(quaternions, float)
    with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
        scaled = quaternions / np.max(np.abs(quaternions), axis=-1, keepdims=True)
        w, x, y, z = np.moveaxis(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True), -1, 0)
    if not np.all(np.isfinite(w)):
        raise InputError(name, "a quaternion of length 0", "four numbers w, x, y, z, not all 0")
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    matrices: FloatArray = np.moveaxis(np.array(rows), (0, 1), (-2, -1))
    return matrices


def from_rpy(angles: npt.ArrayLike) -> FloatArray:
    """Matrices (..., 3, 3) of roll, pitch and yaw (..., 3) [rad] as in URDF: R = R_z(yaw) R_y(pitch) R_x(roll)."""
    x, y, z = _about_axes(angles)
    return z @ y @ x


def rpy(R: FloatArray) -> FloatArray:
    """Roll, pitch and yaw (3,) [rad] of a matrix (3, 3), accurate to rounding also at a pitch of ±90 deg."""
    yaw = np.arctan2(R[1, 0], R[0, 0])
    left = about((0.0, 0.0, 1.0), -yaw) @ R  # the rotation that remains after each angle
    pitch = np.arctan2(-left[2, 0], left[0, 0])
    left = about((0.0, 1.0, 0.0), -pitch) @ left
    return np.array([np.arctan2(left[2, 1], left[1, 1]), pitch, yaw])


def from_pitch_yaw_roll(angles: npt.ArrayLike) -> FloatArray:
    """Matrices (..., 3, 3) of pitch, yaw, roll (..., 3) [rad] as in the paper's figures, R = R_y R_z R_x."""
    x, y, z = _about_axes(np.asarray(angles)[..., [2, 0, 1]])
    return y @ z @ x


def pitch_yaw_roll(R: npt.ArrayLike) -> FloatArray:
    """Pitch, yaw, roll (..., 3) [rad] of matrices (..., 3, 3) or poses (..., 4, 4): R = R_y(pitch) R_z(yaw) R_x(roll).

    Pitch and roll are in (-π, π], yaw in [-π/2, π/2]. At a yaw of ±90 degrees only one combination of pitch and roll
    is defined; roll is 0 there.
    """
    R = np.asarray(R, dtype=np.float64)
    level = np.hypot(R[..., 0, 0], R[..., 2, 0])  # cos(yaw)
    yaw = np.arctan2(R[..., 1, 0], level)
    upright = level > 1e-12
    pitch = np.where(upright, np.arctan2(-R[..., 2, 0], R[..., 0, 0]), np.arctan2(R[..., 0, 2], R[..., 2, 2]))
    roll = np.where(upright, np.arctan2(-R[..., 1, 2], R[..., 1, 1]), 0.0)
    return np.stack([pitch, yaw, roll], axis=-1)


def _about_axes(angles: npt.ArrayLike) -> tuple[FloatArray, ...]:
    """Turns (..., 3, 3) about x, y and z by the columns of angles (..., 3)."""
    angles = np.asarray(angles, float)
    return tuple(about(np.broadcast_to(np.eye(3)[k], angles.shape), angles[..., k]) for k in range(3))


def shortest_turn_from_z(direction: FloatArray) -> FloatArray:
    """(3, 3) rotation matrix of the shortest turn of the z axis into a direction of length 1; to -z it is about x."""
    x, y, z = direction
    across = x * x + y * y
    if across < 1e-18:  # rounding of ±z
        return np.diag([1.0, np.copysign(1.0, z), np.copysign(1.0, z)])
    k = 1.0 / (1.0 + z) if z > 0.0 else (1.0 - z) / across  # equal; each where it is accurate
    return np.array([[1.0 - k * x * x, -k * x * y, x], [-k * x * y, 1.0 - k * y * y, y], [-x, -y, z]])


def orientation(name: str, value: Any) -> FloatArray:
    """A rotation matrix from a matrix (3, 3) or a rotation vector (3,) [rad]; InputError otherwise."""
    if _door.array(name, value, "a rotation matrix (3, 3) or a rotation vector (3,)").ndim == 1:
        return exp(_door.vector(name, value, 3))
    T = np.eye(4)
    T[:3, :3] = _door.matrix(name, value, (3, 3))
    R: FloatArray = _door.pose(name, T)[:3, :3]
    return R
