"""The parts of an arm: joints, tool and followers, as arrays and in the compiled core."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._core import ArmModel, JointKind
from stillreach._door import FloatArray
from stillreach._labels import Labels
from stillreach.arm.follower import Follower, Moving, chain, checked, note_of
from stillreach.arm.joint import KINDS, Joint, named
from stillreach.arm.value import Value
from stillreach.errors import InputError, UnknownJointError


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Structure(Value):
    """The parts of an ``Arm``; the methods are in ``Arm``."""

    joints: tuple[Joint, ...]
    tool: FloatArray
    name: str
    followers: tuple[Follower, ...]

    def __init__(
        self,
        joints: Iterable[Joint],
        *,
        tool: npt.ArrayLike | None = None,
        name: str = "arm",
        followers: Iterable[Follower] = (),
    ) -> None:
        if not isinstance(name, str) or not name:
            raise InputError("name", _door.describe(name), "the arm's name (text, not empty)")
        object.__setattr__(self, "joints", named(joints))
        object.__setattr__(self, "tool", _door.pose("tool", np.eye(4) if tool is None else tool))
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "followers", checked(followers, self.joints))

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, from the base on."""
        return tuple(str(joint.name) for joint in self.joints)

    @cached_property
    def labels(self) -> Labels:
        """Names of the joints, for values by name; those of followers are accepted and ignored."""
        return Labels("joint", self.joint_names, tuple(str(follower.joint.name) for follower in self.followers))

    @cached_property
    def kinds(self) -> npt.NDArray[np.int8]:
        """(n,) 0 for a revolute joint, 1 for a prismatic one."""
        codes = np.array([KINDS.index(joint.kind) for joint in self.joints], dtype=np.int8)
        codes.flags.writeable = False
        return codes

    @cached_property
    def joint_units(self) -> tuple[str, ...]:
        """(n,) unit of each joint's value, ``"rad"`` or ``"m"``."""
        return tuple("m" if kind else "rad" for kind in self.kinds)

    @cached_property
    def position_limits(self) -> FloatArray:
        """(n, 2) lower and upper limit of each joint [rad] or [m]."""
        return _door.frozen([joint.position_limits for joint in self.joints])

    @cached_property
    def velocity_limits(self) -> FloatArray:
        """(n,) largest velocity of each joint in either direction [rad/s] or [m/s]."""
        return _door.frozen([joint.velocity_limit for joint in self.joints])

    @cached_property
    def acceleration_limits(self) -> FloatArray:
        """(n,) largest acceleration of each joint in either direction [rad/s²] or [m/s²]."""
        return _door.frozen([joint.acceleration_limit for joint in self.joints])

    @cached_property
    def reach(self) -> float:
        """Upper bound of the tool's distance from the base [m]: all links stretched, slides at their ends."""
        links = [moving.joint.placement for moving in self.chain] + [self.tool]
        slides = [
            max(abs(moving.factor * end + moving.offset) for end in self.joints[moving.leader].position_limits)
            for moving in self.chain
            if moving.joint.kind == "prismatic"
        ]
        return math.fsum([*(math.hypot(*T[:3, 3]) for T in links), *slides])  # sum() rounds as its Python does

    @cached_property
    def chain(self) -> tuple[Moving, ...]:
        """All moving joints, including followers, from the base on."""
        return chain(self.joints, self.followers)

    @cached_property
    def model(self) -> ArmModel:
        """The arm in the compiled core."""
        placements = np.array([moving.joint.placement for moving in self.chain])
        axes = np.array([moving.joint.axis for moving in self.chain])
        kinds = [JointKind[moving.joint.kind.upper()] for moving in self.chain]
        if not self.followers:
            return ArmModel(kinds, placements, axes, self.tool)
        _, leaders, factors, offsets = zip(*self.chain, strict=True)
        return ArmModel(kinds, placements, axes, self.tool, leaders, np.array(factors), np.array(offsets))

    def joint_index(self, joint: str | int) -> int:
        """0-based index of a joint.

        Args:
            joint: its name, or its index (0 to n-1; no negative ones).

        Raises:
            UnknownJointError: if the arm has no such joint, or it is a follower; the message names the leader.
        """
        if isinstance(joint, str):
            if joint in self.joint_names:
                return self.joint_names.index(joint)
        elif _is_integer(joint) and 0 <= operator.index(joint) < self.n:
            return operator.index(joint)
        raise UnknownJointError("joint", _door.describe(joint) + note_of(joint, self.followers), self.joint_names)


def _is_integer(value: Any) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)
