"""Arms from URDF files: the chain between two links of a tree, with the standard library alone.

Only what a chain's kinematics need is read: names and connections of all links and joints, numbers of the joints
between base and tip. Meshes, inertias, efforts, soft limits and transmissions are not looked at.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm.chain import ChainBuilder, inverse
from stillreach.arm.joint import Joint
from stillreach.arm.robot_file import RobotFile, listing, read
from stillreach.arm.robot_xml import parse
from stillreach.arm.urdf_joint import LARGEST, Movement, read_movement
from stillreach.arm.urdf_tree import UrdfJoint, UrdfTree, build_tree
from stillreach.errors import InputError, RobotFileError

MAX_PASSED, MAX_MOVING = 10_000, 1000


def urdf_chain(
    path: Any, tip: Any, base: Any, fixed: Mapping[str, float] | None
) -> tuple[list[Joint], FloatArray, str]:
    """Joints, tool (4, 4) and name of the arm between two links; ``Arm.from_urdf`` says what the arguments are."""
    file = read(path, "a URDF file")
    tree = build_tree(file, parse(file))
    start = tree.root if base is None else _link(tree, "base", base)
    way = tree.path(start, _only_leaf(tree, start) if tip is None else _link(tree, "tip", tip))
    if len(way) > MAX_PASSED:
        raise file.error(f"{len(way)} joints between base and tip", f"at most {MAX_PASSED}")
    chain = _Chain(tree, way, fixed)
    builder = ChainBuilder()
    for joint, backwards in way:
        _pass(chain, builder, joint, backwards)
    if not builder.joints:
        raise file.error("no joint that moves between base and tip", "at least one", argument="tip")
    if len(builder.joints) > MAX_MOVING:
        raise file.error(f"{len(builder.joints)} moving joints between base and tip", f"at most {MAX_MOVING}")
    return builder.joints, builder.tool, tree.name


def _link(tree: UrdfTree, argument: str, value: Any) -> str:
    if isinstance(value, str) and value in tree.links:
        return str(value)
    raise tree.file.unknown(value, "a link of the file", tree.links, argument=argument)


def _only_leaf(tree: UrdfTree, base: str) -> str:
    leaves = tree.leaves(base)
    if len(leaves) == 1:
        return leaves[0]
    expected = f"a link's name, because the chain has {len(leaves)} ends: {listing(leaves)}"
    raise RobotFileError("tip", "None", expected, tree.file.name, choices=leaves)


@dataclass(frozen=True)
class _Value:
    """Position of a joint: factor times that of a leader (None: no leader), plus offset."""

    leader: str | None
    factor: float
    offset: float


class _Chain:
    """The joints between base and tip: their numbers, and which of them stand still."""

    def __init__(self, tree: UrdfTree, way: list[tuple[UrdfJoint, bool]], fixed: Any) -> None:
        self.tree = tree
        self.movements = {joint.name: read_movement(tree.file, joint) for joint, _ in way}
        self.moving = {name for name, movement in self.movements.items() if movement.kind != "fixed"}
        self.held: dict[str, float] = {}
        leaders = [leader for name in list(self.movements) for leader in self._leaders(name)]
        choices = tuple(dict.fromkeys([name for name in self.movements if name in self.moving] + leaders))
        self.held = self._positions(fixed, choices)

    def _leaders(self, name: str) -> list[str]:
        """Whom a joint follows, whom that one follows, and so on."""
        found: list[str] = []
        while (mimic := self.movement(name).mimic) is not None:
            joint = self.tree.joints[name]
            if mimic.leader not in self.tree.joints:
                raise self.file.unknown(
                    mimic.leader, "a joint to follow", self.tree.joints, line=joint.element.line, element=joint.label
                )
            name = mimic.leader
            if name in found:
                raise self.file.error(
                    f"a cycle of joints that follow each other, {name!r} among them",
                    "one that leads",
                    line=joint.element.line,
                    element=joint.label,
                )
            found.append(name)
        return found

    def movement(self, name: str) -> Movement:
        """The numbers of any joint of the file."""
        if name not in self.movements:
            self.movements[name] = read_movement(self.file, self.tree.joints[name])
        return self.movements[name]

    @property
    def file(self) -> RobotFile:
        """Where all comes from."""
        return self.tree.file

    def _positions(self, fixed: Any, choices: tuple[str, ...]) -> dict[str, float]:
        if fixed is None:
            return {}
        if not isinstance(fixed, Mapping):
            raise InputError("fixed", _door.describe(fixed), "{joint name: position [rad] or [m]} or None")
        for name in fixed:
            if name not in choices:
                raise self.file.unknown(name, "a joint between base and tip", choices, argument="fixed")
        return {name: _door.scalar(f"fixed[{name!r}]", position) for name, position in fixed.items()}

    def value(self, name: str) -> _Value:
        """Where a joint is: held, led by one of the arm's joints, or its own."""
        factor, offset = 1.0, 0.0
        while True:
            if name in self.held:
                return self._held(name, factor * self.held[name] + offset)
            mimic = self.movement(name).mimic
            if mimic is None:
                break
            factor, offset = factor * mimic.multiplier, factor * mimic.offset + offset
            name = mimic.leader
        return _Value(name, factor, offset) if name in self.moving else self._held(name, offset)

    def _held(self, name: str, position: float) -> _Value:
        if not abs(position) <= LARGEST:
            expected = f"a joint between -{LARGEST:g} and {LARGEST:g}"
            raise self.file.error(f"the position {position:g}", expected, element=self.tree.joints[name].label)
        return _Value(None, 0.0, position)


def _pass(chain: _Chain, builder: ChainBuilder, joint: UrdfJoint, backwards: bool) -> None:
    """Add one joint to the chain; from child to parent it moves the other way round."""
    movement = chain.movements[joint.name]
    if not backwards:
        builder.fix(movement.origin)
    if movement.kind != "fixed":
        axis = -movement.axis if backwards else movement.axis
        value = chain.value(joint.name)
        if value.leader is None:
            builder.hold(movement.kind, axis, value.offset)
        elif value.leader == joint.name:
            builder.move(
                name=joint.name,
                kind=movement.kind,
                axis=axis,
                position_limits=movement.position,
                velocity_limit=movement.velocity,
            )
        else:
            raise chain.file.error(
                f"a joint that follows {value.leader!r}, which is between base and tip, too",
                f"one of them held: fixed={{{joint.name!r}: position}}",
                line=joint.element.line,
                element=joint.label,
            )
    if backwards:
        builder.fix(inverse(movement.origin))
