"""The serial chain between two nodes of a tree, from the steps that a robot file has between them."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm.follower import Follower
from stillreach.arm.joint import Joint
from stillreach.arm.led import LARGEST, MimicOf, positions
from stillreach.arm.placements import inverse, moved, rigid
from stillreach.arm.robot_file import RobotFile, shown

MAX_PASSED, MAX_MOVING = 2000, 1000
Node = TypeVar("Node", bound=Hashable)
Step = FloatArray | Joint
"""A transform (4, 4), or a joint that can move, whose placement does not count."""


class Chain(NamedTuple):
    """Parts of an arm: joints, tool (4, 4) seen from the last one, name, joints that follow."""

    joints: list[Joint]
    tool: FloatArray
    name: str
    followers: list[Follower]


def way(base: Node, tip: Node, parent: Callable[[Node], Node | None]) -> list[tuple[Node, bool]]:
    """The nodes between which and their parents the chain goes, each with whether it goes up, to the parent."""
    up, down = list(_below_root(base, parent)), list(_below_root(tip, parent))
    while up and down and up[-1] == down[-1]:
        up.pop()
        down.pop()
    return [(node, True) for node in up] + [(node, False) for node in reversed(down)]


def _below_root(node: Node, parent: Callable[[Node], Node | None]) -> Iterator[Node]:
    while (above := parent(node)) is not None:
        yield node
        node = above


def along(passed: list[tuple[Node, bool]], steps_to: Callable[[Node, bool], list[Step]]) -> list[Step]:
    """The steps along a way; ``steps_to`` has those from a node's parent to the node, whichever way it is passed."""
    steps: list[Step] = []
    for node, up in passed:
        own = steps_to(node, up)
        steps += [_back(step) for step in reversed(own)] if up else own
    return steps


def _back(step: Step) -> Step:
    return replace(step, axis=-step.axis) if isinstance(step, Joint) else inverse(step)


def check_length(file: RobotFile, passed: int) -> None:
    """Raises RobotFileError if there are too many joints between base and tip, the fixed ones included."""
    if passed > MAX_PASSED:
        raise file.error(f"{passed} joints between base and tip", f"at most {MAX_PASSED}")


def assembled(file: RobotFile, name: str, steps: list[Step], mimic_of: MimicOf, fixed: Any) -> Chain:
    """The chain of these steps, from base to tip.

    Raises:
        RobotFileError: if a joint is there twice or too far away, no joint moves, or too many do; and as of
            ``positions``, whose arguments ``mimic_of`` and ``fixed`` are.
        InputError: if ``fixed`` is not a mapping to numbers.
    """
    found = positions(file, [str(step.name) for step in steps if isinstance(step, Joint)], mimic_of, fixed)
    joints: list[Joint] = []
    led: list[tuple[Joint, Follower]] = []  # as in the file, with limits, and as in the arm
    names, since = set[str](), np.eye(4)
    for step in steps:
        if not isinstance(step, Joint):
            since = since @ step
            continue
        leader, factor, offset = found[str(step.name)]
        if leader is None:
            since = since @ moved(step.kind, step.axis, offset)
            continue
        label = f"joint {shown(step.name)}"
        if step.name in names:
            raise file.error("a second joint of that name between base and tip", "each name once", element=label)
        names.add(str(step.name))
        joint, since = replace(step, placement=_placement(file, since, label)), np.eye(4)
        if leader == step.name:
            joints.append(joint)
        else:
            place = len(names) - 1
            led.append((joint, Follower(joint, leader=leader, multiplier=factor, offset=offset, place=place)))
    if not joints:
        raise file.error("no joint that moves between base and tip", "at least one", argument="tip")
    if len(names) > MAX_MOVING:
        raise file.error(f"{len(names)} moving joints between base and tip", f"at most {MAX_MOVING}")
    tool = _placement(file, since, "the tool")
    return Chain([_limited(joint, led) for joint in joints], tool, name, [follower for _, follower in led])


def _placement(file: RobotFile, since: FloatArray, whose: str) -> FloatArray:
    """The transform since the last joint that moves, (4, 4)."""
    far = float(np.max(np.abs(since[:3, 3])))
    if not far <= LARGEST:
        got = f"a place {far:.9g} m away from the moving joint or the base before it"
        raise file.error(got, f"at most {LARGEST:g} m along each axis", element=whose)
    return rigid(since)


def _limited(leader: Joint, led: list[tuple[Joint, Follower]]) -> Joint:
    """A joint within its own limits and those of its followers.

    Limits of followers are often missing or copied from the leader; a range that would leave the leader none does not
    count.
    """
    own, ranges = leader.position_limits, [leader.position_limits]
    velocities, accelerations = [leader.velocity_limit], [leader.acceleration_limit]
    for joint, follower in led:
        if follower.leader != leader.name:
            continue
        ends = sorted((end - follower.offset) / follower.multiplier for end in joint.position_limits)
        if _common([own, (ends[0], ends[1])]):
            ranges.append((ends[0], ends[1]))
        velocities.append(joint.velocity_limit / abs(follower.multiplier))
        accelerations.append(joint.acceleration_limit / abs(follower.multiplier))
    return replace(
        leader,
        position_limits=_common(ranges) or own,
        velocity_limit=min(velocities),
        acceleration_limit=min(accelerations),
    )


def _common(ranges: list[tuple[float, float]]) -> tuple[float, float] | None:
    """The range that all have in common, or None where that is less than a range."""
    lower, upper = max(pair[0] for pair in ranges), min(pair[1] for pair in ranges)
    return (lower, upper) if lower < upper else None
