"""A serial chain put together step by step, from whatever a robot file holds between base and tip."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm.follower import Follower
from stillreach.arm.joint import Joint
from stillreach.arm.mimic import LARGEST, Place
from stillreach.arm.placements import moved, rigid
from stillreach.arm.robot_file import RobotFile, shown

MAX_PASSED, MAX_MOVING = 2000, 1000


class Chain(NamedTuple):
    """What an arm is made of: joints, tool (4, 4) seen from the last one, name, joints that follow."""

    joints: list[Joint]
    tool: FloatArray
    name: str
    followers: list[Follower]


class Move(NamedTuple):
    """One way in which a chain moves: what a file says of a revolute or prismatic joint; axis (3,) of length 1."""

    name: str
    kind: str
    axis: FloatArray
    position_limits: tuple[float, float]
    velocity_limit: float = math.inf
    acceleration_limit: float = math.inf


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
        self.names: set[str] = set()
        self.since = np.eye(4)

    def fix(self, T: FloatArray) -> None:
        """Go on by a transform (4, 4) that does not change."""
        self.since = self.since @ T

    def go(self, place: Place, move: Move, *, backwards: bool = False) -> None:
        """Go on by a joint that moves or is held; backwards: from its child to its parent.

        Raises:
            RobotFileError: a joint of that name is there already, or is too far away.
        """
        axis = -move.axis if backwards else move.axis
        if place.leader is None:
            self.fix(moved(move.kind, axis, place.offset))
            return
        label = f"joint {shown(move.name)}"
        if move.name in self.names:
            raise self.file.error("a second joint of that name between base and tip", "each name once", element=label)
        self.names.add(move.name)
        placement, self.since = self._placement(label), np.eye(4)
        joint = Joint(placement=placement, **{**move._asdict(), "axis": axis})
        if place.leader == move.name:
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
        """A joint within its own limits and those of its followers.

        Limits of followers are often missing or copied from the leader; a range that would leave the leader none does
        not count.
        """
        led = [(joint, follower) for joint, follower in self.followers if follower.leader == leader.name]
        own, theirs = leader.position_limits, [_of_leader(*pair) for pair in led]
        ranges = [own, *(pair for pair in theirs if _common([own, pair]))]
        factors = [abs(follower.multiplier) for _, follower in led]
        rates = [joint.velocity_limit / factor for (joint, _), factor in zip(led, factors, strict=True)]
        changes = [joint.acceleration_limit / factor for (joint, _), factor in zip(led, factors, strict=True)]
        return replace(
            leader,
            position_limits=_common(ranges) or own,
            velocity_limit=min([leader.velocity_limit, *rates]),
            acceleration_limit=min([leader.acceleration_limit, *changes]),
        )


def _of_leader(joint: Joint, follower: Follower) -> tuple[float, float]:
    """The leader's range that keeps a follower in its own."""
    ends = sorted((end - follower.offset) / follower.multiplier for end in joint.position_limits)
    return ends[0], ends[1]


def _common(ranges: list[tuple[float, float]]) -> tuple[float, float] | None:
    """The range that all have in common, or None where that is less than a range."""
    lower, upper = max(pair[0] for pair in ranges), min(pair[1] for pair in ranges)
    return (lower, upper) if lower < upper else None
