"""A serial chain put together step by step, from whatever a robot file holds between base and tip."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm.joint import Joint
from stillreach.arm.mimic import Place
from stillreach.arm.placements import moved
from stillreach.arm.robot_file import RobotFile, shown

MAX_PASSED, MAX_MOVING = 2000, 1000


class Chain(NamedTuple):
    """What an arm is made of: joints, tool (4, 4) seen from the last one, name."""

    joints: list[Joint]
    tool: FloatArray
    name: str


class ChainBuilder:
    """Joints so far, and the fixed transform since the last of them.

    Args:
        file: for messages.
        passed: number of joints between base and tip, the fixed ones included.

    Raises:
        RobotFileError: there are too many.
    """

    def __init__(self, file: RobotFile, passed: int) -> None:
        if passed > MAX_PASSED:
            raise file.error(f"{passed} joints between base and tip", f"at most {MAX_PASSED}")
        self.file = file
        self.joints: list[Joint] = []
        self.since = np.eye(4)

    def fix(self, T: FloatArray) -> None:
        """Go on by a transform (4, 4) that does not change."""
        self.since = self.since @ T

    def go(
        self,
        place: Place,
        *,
        name: str,
        kind: str,
        axis: FloatArray,
        position_limits: tuple[float, float],
        velocity_limit: float,
    ) -> None:
        """Go on by a joint that moves or is held; axis (3,) of length 1, the rest as for Joint."""
        if place.leader is None:
            self.fix(moved(kind, axis, place.offset))
        elif place.leader == name:
            placement, self.since = rigid(self.since), np.eye(4)
            self.joints.append(
                Joint(
                    name=name,
                    kind=kind,
                    placement=placement,
                    axis=axis,
                    position_limits=position_limits,
                    velocity_limit=velocity_limit,
                )
            )
        else:
            raise self.file.error(
                f"a joint that follows {shown(place.leader)}, which is between base and tip, too",
                f"one of the two held: fixed={{{name!r}: position}}",
                element=f"joint {shown(name)}",
            )

    def chain(self, name: str) -> Chain:
        """What was put together.

        Raises:
            RobotFileError: no joint moves, or too many do.
        """
        if not self.joints:
            raise self.file.error("no joint that moves between base and tip", "at least one", argument="tip")
        if len(self.joints) > MAX_MOVING:
            raise self.file.error(f"{len(self.joints)} moving joints between base and tip", f"at most {MAX_MOVING}")
        return Chain(self.joints, rigid(self.since), name)


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
