"""A serial chain put together step by step, from whatever a robot file holds between base and tip."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm.joint import Joint
from stillreach.arm.placements import moved


class ChainBuilder:
    """Joints so far, and the fixed transform since the last of them."""

    def __init__(self) -> None:
        self.joints: list[Joint] = []
        self.since = np.eye(4)

    def fix(self, T: FloatArray) -> None:
        """Go on by a transform (4, 4) that does not change."""
        self.since = self.since @ T

    def hold(self, kind: str, axis: FloatArray, position: float) -> None:
        """Go on by a joint that stays where it is: axis (3,) of length 1, position [rad] or [m]."""
        self.fix(moved(kind, axis, position))

    def move(self, **joint: Any) -> None:
        """Go on by a joint that moves; the keywords of Joint but its placement."""
        self.joints.append(Joint(placement=rigid(self.since), **joint))
        self.since = np.eye(4)

    @property
    def tool(self) -> FloatArray:
        """(4, 4) what comes after the last joint."""
        return rigid(self.since)


def rigid(T: FloatArray) -> FloatArray:
    """The transform with the rounding of many products taken out of its rotation."""
    R = T[:3, :3]
    clean = np.eye(4)
    clean[:3, 3] = T[:3, 3]
    if np.max(np.abs(R @ R.T - np.eye(3))) > 1e-14:
        U, _, Vt = np.linalg.svd(R)
        R = U @ Vt
    clean[:3, :3] = R
    return clean


def inverse(T: FloatArray) -> FloatArray:
    """The inverse of a rigid transform."""
    back = np.eye(4)
    back[:3, :3] = T[:3, :3].T
    back[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return back
