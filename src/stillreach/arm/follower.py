"""Joints that follow another joint of their arm, and the chain of both kinds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from stillreach import _door
from stillreach.arm.joint import Joint
from stillreach.arm.value import Value
from stillreach.errors import InputError


@dataclass(frozen=True, init=False, eq=False)
class Follower(Value):
    """A joint without a drive of its own: it is at ``multiplier`` times another joint's position, plus ``offset``.

    It is not one of the arm's n joints: it moves with its leader, whose Jacobian column includes the motion of both.

    Args:
        joint: name, kind, placement and axis; its limits are those of its leader.
        leader: name of the joint it follows.
        multiplier: its rate per rate of the leader.
        offset: its position with the leader at 0 [rad] or [m].
        place: its index in the chain of all moving joints, from 0 at the base.

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
    """The followers of an arm with these joints, in order of ``place``.

    Raises:
        InputError: if an item is not a Follower, a name is repeated, a leader is missing, or places are not
            consecutive.
    """
    expected = "Follower, each with a name and a place of its own, that follow joints of the arm"
    found = _door.members("followers", followers, Follower, expected, least=0)
    for follower in found:
        _door.choice(f"leader of {follower.joint.name!r}", follower.leader, [str(joint.name) for joint in joints])
    names = [joint.name for joint in joints] + [follower.joint.name for follower in found]
    places = [follower.place for follower in found]
    if len(set(names)) < len(names) or len(set(places)) < len(places) or max(places, default=0) >= len(names):
        raise InputError("followers", f"names {names} and places {places}", expected)
    return tuple(sorted(found, key=lambda follower: follower.place))


def chain(joints: tuple[Joint, ...], followers: tuple[Follower, ...]) -> tuple[Moving, ...]:
    """All moving joints, from the base on."""
    index = {joint.name: i for i, joint in enumerate(joints)}
    whole = [Moving(joint, i, 1.0, 0.0) for i, joint in enumerate(joints)]
    for follower in followers:
        led = Moving(follower.joint, index[follower.leader], follower.multiplier, follower.offset)
        whole.insert(follower.place, led)
    return tuple(whole)


def note_of(joint: Any, followers: tuple[Follower, ...]) -> str:
    """A note for error messages if the name is a follower's; empty otherwise."""
    leaders = [follower.leader for follower in followers if follower.joint.name == joint]
    return f", which follows {leaders[0]!r} and moves with it" if leaders else ""
