"""Attitude as three angles, the way the paper's figures show it: R = R_y(pitch) R_z(yaw) R_x(roll)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray


def pitch_yaw_roll(R: npt.ArrayLike) -> FloatArray:
    """The angles of rotation matrices, R = R_y(pitch) R_z(yaw) R_x(roll).

    At a yaw of ±90 degrees only one combination of pitch and roll is defined; roll is 0 there.

    Args:
        R: (..., 3, 3) rotation matrices (poses (..., 4, 4) will do: the rest is not read).

    Returns:
        (..., 3) pitch, yaw, roll [rad]; pitch and roll in (-π, π], yaw in [-π/2, π/2].
    """
    R = np.asarray(R, dtype=np.float64)
    level = np.hypot(R[..., 0, 0], R[..., 2, 0])  # cos(yaw)
    yaw = np.arctan2(R[..., 1, 0], level)
    upright = level > 1e-12
    pitch = np.where(upright, np.arctan2(-R[..., 2, 0], R[..., 0, 0]), np.arctan2(R[..., 0, 2], R[..., 2, 2]))
    roll = np.where(upright, np.arctan2(-R[..., 1, 2], R[..., 1, 1]), 0.0)
    return np.stack([pitch, yaw, roll], axis=-1)
