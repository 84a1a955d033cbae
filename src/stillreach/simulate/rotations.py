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
    diagonal = np.diagonal(R, axis1=1, axis2=2)
    four = np.concatenate([np.trace(R, axis1=1, axis2=2)[:, None], diagonal], axis=1)
    largest = np.argmax(four, axis=1)
    rows = np.array([_quaternion(matrix, big) for matrix, big in zip(R, largest, strict=True)]).reshape(-1, 4)
    rows *= np.where(rows[:, :1] < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(rows[:, 1:], axis=1)
    small = sine < 1e-8
    gain = np.where(small, 2.0, 2.0 * np.arctan2(sine, rows[:, 0]) / np.where(small, 1.0, sine))
    vectors: FloatArray = gain[:, None] * rows[:, 1:]
    return vectors


def _quaternion(R: FloatArray, big: int) -> list[float]:
    """(w, x, y, z) of one matrix; ``big`` is the place of its largest component."""
    if big == 0:
        w = 0.5 * np.sqrt(1.0 + R[0, 0] + R[1, 1] + R[2, 2])
        return [w, *(float(R[c, b] - R[b, c]) / (4.0 * w) for b, c in ((1, 2), (2, 0), (0, 1)))]
    a = big - 1
    b, c = (a + 1) % 3, (a + 2) % 3
    v = [0.0, 0.0, 0.0]
    v[a] = 0.5 * np.sqrt(1.0 + R[a, a] - R[b, b] - R[c, c])
    v[b], v[c] = (float(R[a, other] + R[other, a]) / (4.0 * v[a]) for other in (b, c))
    return [float(R[c, b] - R[b, c]) / (4.0 * v[a]), *v]


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
    return np.moveaxis(np.array(rows), 2, 0)


def from_rpy(angles: FloatArray) -> FloatArray:
    """Matrices (K, 3, 3) of roll, pitch and yaw (K, 3) [rad] as URDF has them: R = R_z(yaw) R_y(pitch) R_x(roll)."""
    x, y, z = _about(angles)
    return z @ y @ x


def from_pitch_yaw_roll(angles: FloatArray) -> FloatArray:
    """Matrices (K, 3, 3) of pitch, yaw, roll (K, 3) [rad] as the paper's figures have them, R_y R_z R_x."""
    x, y, z = _about(angles[:, [2, 0, 1]])
    return y @ z @ x


def _about(angles: FloatArray) -> tuple[FloatArray, ...]:
    """Rotations about x, y and z by the columns of angles (K, 3)."""
    return tuple(exp(angles[:, [k]] * np.eye(3)[k]) for k in range(3))


def orientation(name: str, value: Any) -> FloatArray:
    """A rotation matrix from a matrix (3, 3) or a rotation vector (3,) [rad]; InputError otherwise."""
    if np.ndim(value) == 1:
        return exp(_door.vector(name, value, 3)[None])[0]
    T = np.eye(4)
    T[:3, :3] = _door.matrix(name, value, (3, 3))
    return _door.pose(name, T)[:3, :3]
