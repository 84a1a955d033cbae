"""Rotations in the forms that people write them, as matrices and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.errors import InputError


def exp(vectors: FloatArray) -> FloatArray:
    """Matrices (K, 3, 3) of rotation vectors (K, 3) [rad]: Rodrigues' formula, without cancellation near 0."""
    angle = np.linalg.norm(vectors, axis=1)
    first = np.sinc(angle / np.pi)[:, None, None]  # sin a / a
    second = 0.5 * np.sinc(angle / (2 * np.pi))[:, None, None] ** 2  # (1 - cos a) / a²
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    K = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    turns: FloatArray = np.eye(3) + first * K + second * (K @ K)
    return turns


def log(R: FloatArray) -> FloatArray:
    """Rotation vectors (K, 3) [rad] of matrices (K, 3, 3), no longer than π.

    Through the quaternion by its largest component (Shepperd, 1978), so that no angle loses digits.
    """
    quaternions = _quaternions(R)
    quaternions *= np.where(quaternions[:, :1] < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(quaternions[:, 1:], axis=1)
    small = sine < 1e-8
    gain = np.where(small, 2.0, 2.0 * np.arctan2(sine, quaternions[:, 0]) / np.where(small, 1.0, sine))
    vectors: FloatArray = gain[:, None] * quaternions[:, 1:]
    return vectors


def _quaternions(R: FloatArray) -> FloatArray:
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


def from_quaternions(name: str, quaternions: FloatArray) -> FloatArray:
    """Matrices (K, 3, 3) of quaternions (K, 4), w x y z; any length but 0 is scaled to 1."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
        scaled = quaternions / np.max(np.abs(quaternions), axis=1, keepdims=True)
        w, x, y, z = (scaled / np.linalg.norm(scaled, axis=1, keepdims=True)).T
    if not np.all(np.isfinite(w)):
        raise InputError(name, "a quaternion of length 0", "four numbers w, x, y, z, not all 0")
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    matrices: FloatArray = np.moveaxis(np.array(rows), 2, 0)
    return matrices


def from_rpy(angles: FloatArray) -> FloatArray:
    """Matrices (K, 3, 3) of roll, pitch and yaw (K, 3) [rad] as URDF has them: R = R_z(yaw) R_y(pitch) R_x(roll)."""
    x, y, z = _about(angles)
    turned: FloatArray = z @ y @ x
    return turned


def from_pitch_yaw_roll(angles: FloatArray) -> FloatArray:
    """Matrices (K, 3, 3) of pitch, yaw, roll (K, 3) [rad] as the paper's figures have them, R_y R_z R_x."""
    x, y, z = _about(angles[:, [2, 0, 1]])
    turned: FloatArray = y @ z @ x
    return turned


def _about(angles: FloatArray) -> tuple[FloatArray, ...]:
    """Rotations about x, y and z by the columns of angles (K, 3)."""
    return tuple(exp(angles[:, [k]] * np.eye(3)[k]) for k in range(3))


def orientation(name: str, value: Any) -> FloatArray:
    """A rotation matrix from a matrix (3, 3) or a rotation vector (3,) [rad]; InputError otherwise."""
    if _door.array(name, value, "a rotation matrix (3, 3) or a rotation vector (3,)").ndim == 1:
        turned: FloatArray = exp(_door.vector(name, value, 3)[None])[0]
        return turned
    T = np.eye(4)
    T[:3, :3] = _door.matrix(name, value, (3, 3))
    R: FloatArray = _door.pose(name, T)[:3, :3]
    return R
