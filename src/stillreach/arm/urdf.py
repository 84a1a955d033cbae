"""Arms from URDF files: the chain between two links of a tree, with the standard library alone.

Only what a chain's kinematics need is read: names and connections of all links and joints, numbers of the joints
between base and tip. Meshes, inertias, efforts, soft limits and transmissions are not looked at.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stillreach.arm.chain import Chain, ChainBuilder
from stillreach.arm.mimic import Mimic, Positions
from stillreach.arm.placements import inverse
from stillreach.arm.robot_file import RobotFile, listing, read, shown
from stillreach.arm.robot_xml import XACRO, XACRO_ADVICE, Element, parse
from stillreach.arm.urdf_joint import Movement, read_movement
from stillreach.arm.urdf_tree import UrdfJoint, UrdfTree, build_tree
from stillreach.errors import RobotFileError


def urdf_chain(source: Any, tip: Any, base: Any, fixed: Mapping[str, float] | None) -> Chain:
    """The chain between two links; ``Arm.from_urdf`` says what the arguments are."""
    file = read(source, "a URDF file")
    root = parse(file)
    calls = [child for child in root.children if child.tag.startswith(XACRO)]
    try:
        return _chain(file, root, tip, base, fixed)
    except RobotFileError as error:
        if not calls:
            raise
        rest = f"{error.expected} (<{calls[0].tag[:80]}> in line {calls[0].line} is not expanded; {XACRO_ADVICE})"
        raise RobotFileError(error.argument, error.got, rest, *error.args[3:]) from None


def _chain(file: RobotFile, root: Element, tip: Any, base: Any, fixed: Mapping[str, float] | None) -> Chain:
    tree = build_tree(file, root)
    start = tree.root if base is None else _link(tree, "base", base)
    way = tree.path(start, _only_leaf(tree, start) if tip is None else _link(tree, "tip", tip))
    builder = ChainBuilder(file, passed=len(way))
    movements = {joint.name: _movement(tree, joint, backwards) for joint, backwards in way}
    moving = [move.name for movement in movements.values() for move in movement.moves]
    positions = Positions(file, moving, _Mimics(tree, movements), fixed)
    for joint, backwards in way:
        _pass(builder, movements[joint.name], positions, backwards)
    return builder.chain(tree.name)


def _link(tree: UrdfTree, argument: str, value: Any) -> str:
    if isinstance(value, str) and value in tree.links:
        return str(value)
    raise tree.file.unknown(value, "a link of the file", tree.links, argument=argument)


def _only_leaf(tree: UrdfTree, base: str) -> str:
    leaves = tree.leaves(base)
    if len(leaves) == 1:
        return leaves[0]
    expected = f"a link's name, because the tree has {len(leaves)} ends: {listing(leaves)}"
    raise RobotFileError("tip", "None", expected, tree.file.name, choices=leaves)


def _movement(tree: UrdfTree, joint: UrdfJoint, backwards: bool) -> Movement:
    """The numbers of a joint between base and tip."""
    line, element = joint.element.line, joint.label
    if joint.element.attributes.get("type", "").strip() == "floating":
        argument, verb = ("tip", "ends before") if backwards else ("base", "begins after")
        got = "the type 'floating' between base and tip"
        expected = f"a chain on one side of it: {argument}={shown(joint.child)} {verb} it"
        choices = (joint.child,)
        raise tree.file.error(got, expected, line=line, element=element, argument=argument, choices=choices)
    movement = read_movement(tree.file, joint)
    for move in movement.moves:
        if move.name != joint.name and move.name in tree.joints:
            got = f"a planar joint, whose part {shown(move.name)} has the name of another joint"
            raise tree.file.error(got, "each name once", line=line, element=element)
    return movement


class _Mimics:
    """Whom a joint of the file follows."""

    def __init__(self, tree: UrdfTree, movements: dict[str, Movement]) -> None:
        self.tree = tree
        self.movements = dict(movements)

    def __call__(self, name: str) -> Mimic | None:
        if name not in self.tree.joints:  # a part of a planar joint
            return None
        joint = self.tree.joints[name]
        mimic = self._movement(name).mimic
        if mimic is None or mimic.leader is None:
            return mimic
        if mimic.leader not in self.tree.joints:
            raise self._unknown(joint, mimic.leader)
        if len(self._movement(mimic.leader).moves) > 1:
            got, line = f"a joint that follows the planar joint {shown(mimic.leader)}", joint.element.line
            raise self.tree.file.error(got, "a leader that moves in one way", line=line, element=joint.label)
        return mimic

    def _movement(self, name: str) -> Movement:
        if name not in self.movements:
            self.movements[name] = read_movement(self.tree.file, self.tree.joints[name])
        return self.movements[name]

    def _unknown(self, joint: UrdfJoint, leader: str) -> RobotFileError:
        line, names = joint.element.line, self.tree.joints
        return self.tree.file.unknown(leader, "a joint to follow", names, line=line, element=joint.label)


def _pass(builder: ChainBuilder, movement: Movement, positions: Positions, backwards: bool) -> None:
    """Add one joint to the chain; from child to parent it moves the other way round."""
    if not backwards:
        builder.fix(movement.origin)
    for move in reversed(movement.moves) if backwards else movement.moves:
        builder.go(positions.of(move.name), move, backwards=backwards)
    if backwards:
        builder.fix(inverse(movement.origin))
