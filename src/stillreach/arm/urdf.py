"""Arms from URDF files: the chain between two links of a tree, with the standard library alone.

Only what a chain's kinematics need is read: names and connections of all links and joints, numbers of the joints
between base and tip. Meshes, inertias, efforts, soft limits and transmissions are not looked at.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stillreach.arm.chain import Chain, ChainBuilder, inverse
from stillreach.arm.mimic import Mimic, Positions
from stillreach.arm.robot_file import listing, read
from stillreach.arm.robot_xml import parse
from stillreach.arm.urdf_joint import Movement, read_movement
from stillreach.arm.urdf_tree import UrdfJoint, UrdfTree, build_tree
from stillreach.errors import RobotFileError


def urdf_chain(path: Any, tip: Any, base: Any, fixed: Mapping[str, float] | None) -> Chain:
    """The chain between two links; ``Arm.from_urdf`` says what the arguments are."""
    file = read(path, "a URDF file")
    tree = build_tree(file, parse(file))
    start = tree.root if base is None else _link(tree, "base", base)
    way = tree.path(start, _only_leaf(tree, start) if tip is None else _link(tree, "tip", tip))
    builder = ChainBuilder(file, passed=len(way))
    movements = {joint.name: read_movement(file, joint) for joint, _ in way}
    moving = [name for name, movement in movements.items() if movement.kind != "fixed"]
    positions = Positions(file, moving, _Mimics(tree, movements), fixed)
    for joint, backwards in way:
        _pass(builder, movements[joint.name], joint.name, positions, backwards)
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


class _Mimics:
    """Whom a joint of the file follows."""

    def __init__(self, tree: UrdfTree, movements: dict[str, Movement]) -> None:
        self.tree = tree
        self.movements = dict(movements)

    def __call__(self, name: str) -> Mimic | None:
        joint = self.tree.joints[name]
        if name not in self.movements:
            self.movements[name] = read_movement(self.tree.file, joint)
        mimic = self.movements[name].mimic
        if mimic is not None and mimic.leader is not None and mimic.leader not in self.tree.joints:
            raise self._unknown(joint, mimic.leader)
        return mimic

    def _unknown(self, joint: UrdfJoint, leader: str) -> RobotFileError:
        line, names = joint.element.line, self.tree.joints
        return self.tree.file.unknown(leader, "a joint to follow", names, line=line, element=joint.label)


def _pass(builder: ChainBuilder, movement: Movement, name: str, positions: Positions, backwards: bool) -> None:
    """Add one joint to the chain; from child to parent it moves the other way round."""
    if not backwards:
        builder.fix(movement.origin)
    if movement.kind != "fixed":
        builder.go(
            positions.of(name),
            name=name,
            kind=movement.kind,
            axis=-movement.axis if backwards else movement.axis,
            position_limits=movement.position,
            velocity_limit=movement.velocity,
        )
    if backwards:
        builder.fix(inverse(movement.origin))
