"""Joints that follow another joint of their arm, and the chain that both kinds make."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from stillreach import _door
from stillreach.arm.joint import Joint
from stillreach.arm.value import Value
from stillreach.errors import InputError


@dataclass(frozen=True, init=False, eq=False)
class Follower(Value):
    """A joint without a drive of its own: it is at ``multiplier`` times another joint's position, plus ``offset``.

    It is none of the arm's n joints: it moves with its leader, whose column of the Jacobian holds the motion of both.

    Args:
        joint: name, kind, placement and axis; its limits are those of its leader.
        leader: name of the joint that it follows.
        multiplier: its rate per rate of the leader.
        offset: its position where the leader is at 0 [rad] or [m].
        place: its place in the chain of all joints that move, from 0 at the base on.

    Raises:
        InputError: if an argument is invalid.
    """

    joint: Joint
    leader: str
    multiplier: float
    offset: float
    place: int

    def __init__(self, joint: Joint, *, leader: str, place: int, multiplier: float = 1.0, offset: float = 0.0) -> None:
        if not isinstance(joint, Joint) or joint.name is None:
            raise InputError("joint", _door.describe(joint), "a Joint with a name")
        if not isinstance(leader, str):
            raise InputError("leader", _door.describe(leader), "the name of a joint")
        free = (float("-inf"), float("inf"))
        driven = replace(joint, position_limits=free, velocity_limit=free[1], acceleration_limit=free[1])
        object.__setattr__(self, "joint", driven)
        object.__setattr__(self, "leader", leader)
        object.__setattr__(self, "multiplier", _door.scalar("multiplier", multiplier))
        object.__setattr__(self, "offset", _door.scalar("offset", offset))
        object.__setattr__(self, "place", _door.count("place", place, minimum=0))


class Moving(NamedTuple):
    """One joint of a chain: it is at ``factor`` times the position of the arm's joint ``leader``, plus ``offset``."""

    joint: Joint
    leader: int
    factor: float
    offset: float


def checked(followers: Any, joints: tuple[Joint, ...]) -> tuple[Follower, ...]:
    """The followers of an arm with these joints, in order of their places.

    Raises:
        InputError: something else than followers, a name that is taken, a leader that is none of the joints, places
            that leave a gap.
    """
    expected = "Follower, each with a name and a place of its own, that follow joints of the arm"
    if not isinstance(followers, Iterable):
        raise InputError("followers", _door.describe(followers), expected)
    found = tuple(followers)
    for follower in found:
        if not isinstance(follower, Follower):
            raise InputError("followers", _door.describe(follower), expected)
        _door.choice(f"leader of {follower.joint.name!r}", follower.leader, [str(joint.name) for joint in joints])
    names = [joint.name for joint in joints] + [follower.joint.name for follower in found]
    places = [follower.place for follower in found]
    if len(set(names)) < len(names) or len(set(places)) < len(places) or max(places, default=0) >= len(names):
        raise InputError("followers", f"names {names} and places {places}", expected)
    return tuple(sorted(found, key=lambda follower: follower.place))


def chain(joints: tuple[Joint, ...], followers: tuple[Follower, ...]) -> tuple[Moving, ...]:
    """All joints that move, from the base on."""
    index = {joint.name: i for i, joint in enumerate(joints)}
    whole = [Moving(joint, i, 1.0, 0.0) for i, joint in enumerate(joints)]
    for follower in followers:
        led = Moving(follower.joint, index[follower.leader], follower.multiplier, follower.offset)
        whole.insert(follower.place, led)
    return tuple(whole)


def note_of(joint: Any, followers: tuple[Follower, ...]) -> str:
    """Addition to a message for the name of a follower; empty for other names."""
    leaders = [follower.leader for follower in followers if follower.joint.name == joint]
    return f", which follows {leaders[0]!r} and moves with it" if leaders else ""
