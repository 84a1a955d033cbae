"""Arms from URDF files: the chain between two links of a tree, with the standard library alone.

Only what a chain's kinematics need is read: names and connections of all links and joints, numbers of the joints
between base and tip. Meshes, inertias, efforts, soft limits and transmissions are not looked at.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stillreach.arm.chain import Chain, Step, along, assembled, check_length, way
from stillreach.arm.joint import Joint
from stillreach.arm.led import Led
from stillreach.arm.robot_file import read, shown
from stillreach.arm.robot_xml import XACRO, XACRO_ADVICE, Element, parse
from stillreach.arm.urdf_joint import read_joint
from stillreach.arm.urdf_tree import Tree, build_tree
from stillreach.errors import RobotFileError


def chain(source: Any, tip: Any, base: Any, fixed: Mapping[str, float] | None) -> Chain:
    """The chain between two links; ``Arm.from_urdf`` says what the arguments are."""
    root = parse(read(source, "a URDF file"))
    calls = [child for child in root.children if child.tag.startswith(XACRO)]
    try:
        return _Urdf(root).chain(tip, base, fixed)
    except RobotFileError as error:
        if not calls:
            raise
        rest = f"{error.expected} (<{calls[0].tag[:80]}> in line {calls[0].line} is not expanded; {XACRO_ADVICE})"
        raise RobotFileError(error.argument, error.got, rest, *error.args[3:]) from None


class _Urdf:
    """A parsed file."""

    def __init__(self, root: Element) -> None:
        self.root, self.file = root, root.file
        self.tree: Tree = build_tree(root)
        self.read: dict[str, tuple[list[Step], Led | None]] = {}

    def chain(self, tip: Any, base: Any, fixed: Any) -> Chain:
        file, tree = self.file, self.tree
        start = tree.root if base is None else file.chosen("base", base, "a link of the file", tree.links)
        if tip is None:
            tip = file.only(tree.leaves(start), "a link's name")
        passed = way(start, file.chosen("tip", tip, "a link of the file", tree.links), tree.parent)
        check_length(file, len(passed))
        name = self.root.word("name") or file.stem
        return assembled(file, name, along(passed, self._steps), self._mimic_of, fixed)

    def _steps(self, link: str, up: bool) -> list[Step]:
        """The steps from a link's parent to the link."""
        joint = self.tree.above[link][0]
        if joint.word("type") == "floating":
            argument, verb = ("tip", "ends before") if up else ("base", "begins after")
            expected = f"a chain on one side of it: {argument}={shown(link)} {verb} it"
            got = "the type 'floating' between base and tip"
            raise joint.error(got, expected, argument=argument, choices=(link,))
        steps = self._joint(joint.word("name"))[0]
        for part in (step.name for step in steps if isinstance(step, Joint)):
            if part != joint.word("name") and part in self.tree.joints:
                got = f"a planar joint, whose part {shown(part)} has the name of another joint"
                raise joint.error(got, "each name once")
        return steps

    def _joint(self, name: str) -> tuple[list[Step], Led | None]:
        if name not in self.read:
            self.read[name] = read_joint(self.tree.joints[name], self.tree.version)
        return self.read[name]

    def _mimic_of(self, name: str) -> Led | None:
        """Whom a joint of the file follows."""
        if name not in self.tree.joints:  # a part of a planar joint
            return None
        mimic, joint = self._joint(name)[1], self.tree.joints[name]
        if mimic is None or mimic.leader is None:
            return None
        if mimic.leader not in self.tree.joints:
            raise joint.unknown(mimic.leader, "a joint to follow", self.tree.joints)
        if sum(isinstance(step, Joint) for step in self._joint(mimic.leader)[0]) > 1:
            got = f"a joint that follows the planar joint {shown(mimic.leader)}"
            raise joint.error(got, "a leader that moves in one way")
        return mimic
