"""A serial chain put together step by step, from whatever a robot file holds between base and tip."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm.follower import Follower
from stillreach.arm.joint import Joint
from stillreach.arm.mimic import LARGEST, Place
from stillreach.arm.placements import moved
from stillreach.arm.robot_file import RobotFile, shown

MAX_PASSED, MAX_MOVING = 2000, 1000


class Chain(NamedTuple):
    """What an arm is made of: joints, tool (4, 4) seen from the last one, name, joints that follow."""

    joints: list[Joint]
    tool: FloatArray
    name: str
    followers: list[Follower]


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
        self.followers: list[tuple[Joint, Follower]] = []  # as in the file, with limits, and as in the arm
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
            return
        placement, self.since = self._placement(f"joint {shown(name)}"), np.eye(4)
        joint = Joint(
            name=name,
            kind=kind,
            placement=placement,
            axis=axis,
            position_limits=position_limits,
            velocity_limit=velocity_limit,
        )
        if place.leader == name:
            self.joints.append(joint)
            return
        at = len(self.joints) + len(self.followers)
        led = Follower(joint, leader=place.leader, multiplier=place.factor, offset=place.offset, place=at)
        self.followers.append((joint, led))

    def chain(self, name: str) -> Chain:
        """What was put together.

        Raises:
            RobotFileError: no joint moves, or too many do; the tool is too far away.
        """
        moving = len(self.joints) + len(self.followers)
        if not self.joints:
            raise self.file.error("no joint that moves between base and tip", "at least one", argument="tip")
        if moving > MAX_MOVING:
            raise self.file.error(f"{moving} moving joints between base and tip", f"at most {MAX_MOVING}")
        joints = [self._limited(joint) for joint in self.joints]
        return Chain(joints, self._placement("the tool"), name, [follower for _, follower in self.followers])

    def _placement(self, whose: str) -> FloatArray:
        """What was fixed since the last joint that moves, (4, 4)."""
        far = float(np.max(np.abs(self.since[:3, 3])))
        if not far <= LARGEST:
            got = f"a place {far:.9g} m away from the moving joint or the base before it"
            raise self.file.error(got, f"at most {LARGEST:g} m along each axis", element=whose)
        return rigid(self.since)

    def _limited(self, leader: Joint) -> Joint:
        """A joint within its own limits and those of the joints that follow it."""
        (lower, upper), rate = leader.position_limits, leader.velocity_limit
        for joint, follower in self.followers:
            if follower.leader == leader.name:
                ends = [(end - follower.offset) / follower.multiplier for end in joint.position_limits]
                lower, upper = max(lower, min(ends)), min(upper, max(ends))
                rate = min(rate, joint.velocity_limit / abs(follower.multiplier))
        if lower > upper:
            got = "no position within its limits and those of the joints that follow it"
            raise self.file.error(got, "limits that allow one", element=f"joint {shown(leader.name)}")
        return replace(leader, position_limits=(lower, upper), velocity_limit=rate)


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
