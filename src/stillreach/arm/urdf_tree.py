"""The links and joints of a URDF file as a tree: what is connected to what, and whether it is one tree at all."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from stillreach.arm.robot_file import RobotFile, shown
from stillreach.arm.robot_xml import Element
from stillreach.errors import RobotFileError

VERSIONS = ("1.0", "1.1", "1.2")


@dataclass(frozen=True)
class UrdfJoint:
    """A joint as the file has it; only its name and its two links have been read.

    Attributes:
        name: its name.
        parent, child: the links that it connects.
        element: the rest.
        version: of the file, (1, 0) to (1, 2): what the element means.
    """

    name: str
    parent: str
    child: str
    element: Element
    version: tuple[int, int]

    @property
    def label(self) -> str:
        """How messages call it."""
        return f"joint {shown(self.name)}"


@dataclass(frozen=True)
class UrdfTree:
    """One tree of links.

    Attributes:
        file: where it comes from.
        name: the robot's name.
        links: their names, in the order of the file.
        joints: by name, in the order of the file.
        above: by link, the joint whose child it is; the root has none.
        root: the link that is no joint's child.
    """

    file: RobotFile
    name: str
    links: tuple[str, ...]
    joints: dict[str, UrdfJoint]
    above: dict[str, UrdfJoint]
    root: str

    def path(self, base: str, tip: str) -> list[tuple[UrdfJoint, bool]]:
        """The joints from base to tip, each with whether it is passed from child to parent."""
        up, down = list(self._to_root(base)), list(self._to_root(tip))
        while up and down and up[-1] is down[-1]:
            up.pop()
            down.pop()
        return [(joint, True) for joint in up] + [(joint, False) for joint in reversed(down)]

    def leaves(self, base: str) -> tuple[str, ...]:
        """The links without children below a base link, or all of them if there is nothing below it."""
        children: dict[str, list[str]] = {}
        for joint in self.joints.values():
            children.setdefault(joint.parent, []).append(joint.child)
        below, stack = set(), list(children.get(base, [])) or [self.root]
        while stack:
            link = stack.pop()
            below.add(link)
            stack += children.get(link, [])
        return tuple(link for link in self.links if link in below and link not in children and link != base)

    def _to_root(self, link: str) -> Iterator[UrdfJoint]:
        while link in self.above:
            joint = self.above[link]
            yield joint
            link = joint.parent


def build_tree(file: RobotFile, root: Element) -> UrdfTree:
    """The tree of a parsed URDF file.

    Raises:
        RobotFileError: no robot, an unknown version, a name twice or missing, a link that does not exist or has two
            parents, a cycle, links that are not connected.
    """
    if root.tag != "robot":
        advice = " (Arm.from_mjcf reads MJCF files)" if root.tag == "mujoco" else ""
        raise file.error(f"<{root.tag[:80]}>", f"<robot>, the root of a URDF file{advice}", line=root.line)
    version = _version(file, root)
    links = tuple(_names(file, [child for child in root.children if child.tag == "link"]))
    if not links:
        raise file.error("a robot without links", "at least one <link>", line=root.line, element="<robot>")
    elements = [child for child in root.children if child.tag == "joint"]
    joints: dict[str, UrdfJoint] = {}
    above: dict[str, UrdfJoint] = {}
    known = set(links)
    for name, element in zip(_names(file, elements), elements, strict=True):
        parent, child = (_end(file, element, name, tag, known, links) for tag in ("parent", "child"))
        joint = joints[name] = UrdfJoint(name, parent, child, element, version)
        if child in above:
            got = f"a second parent for link {shown(child)}, which is the child of {above[child].label}, too"
            raise file.error(got, "one parent for each link: a tree", line=element.line, element=joint.label)
        above[child] = joint
    name = root.attributes.get("name", "").strip() or file.stem
    return UrdfTree(file, name, links, joints, above, _root(file, links, above))


def _version(file: RobotFile, root: Element) -> tuple[int, int]:
    """The version of URDF that the file is written in, 1.0 where it names none."""
    word = root.attributes.get("version", VERSIONS[0])
    numbers = re.fullmatch(r"\s*0*(\d{1,4})\.0*(\d{1,4})\s*", word, re.ASCII)
    if numbers is None or f"{numbers[1]}.{numbers[2]}" not in VERSIONS:
        raise file.error(f"version={shown(word)}", ", ".join(VERSIONS), line=root.line, element="<robot>")
    return int(numbers[1]), int(numbers[2])


def _names(file: RobotFile, elements: list[Element]) -> Iterator[str]:
    """The names of links or of joints, each there and each once."""
    seen: dict[str, int] = {}
    for element in elements:
        name = element.attributes.get("name", "").strip()
        if not name:
            raise file.error("no name", "a name", line=element.line, element=f"<{element.tag}>")
        if name in seen:
            got = f"a second {element.tag} {shown(name)}; the first is in line {seen[name]}"
            raise file.error(got, "each name once", line=element.line, element=f"{element.tag} {shown(name)}")
        seen[name] = element.line
        yield name


def _end(file: RobotFile, element: Element, name: str, tag: str, known: set[str], links: tuple[str, ...]) -> str:
    """The link at one end of a joint."""
    label = f"joint {shown(name)}"
    ends = [child for child in element.children if child.tag == tag]
    named = {end.attributes.get("link", "").strip(): end for end in reversed(ends)}
    if len(named) > 1:
        raise file.error(f"{len(named)} <{tag}> that differ", "one", line=ends[1].line, element=label)
    link, end = next(iter(named.items()), ("", element))
    if not link:
        raise file.error(f"no {tag} link", f'<{tag} link="..."/>', line=end.line, element=label)
    if link not in known:
        raise file.unknown(link, f"a link of the file as {tag}", links, line=end.line, element=label)
    return link


def _root(file: RobotFile, links: tuple[str, ...], above: dict[str, UrdfJoint]) -> str:
    """The one link without a parent, from which every link can be reached."""
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        expected = "one tree, all of whose links hang together"
        got = f"{len(roots)} links without a parent"
        raise RobotFileError("path", f"{got}: {_first(roots)}", expected, file.name, None, None, tuple(roots))
    walk_of = dict.fromkeys(roots, 0)
    for walk, start in enumerate(links, 1):
        if start in walk_of:
            continue
        link = start
        while link not in walk_of:
            walk_of[link] = walk
            link = above[link].parent
        if walk_of[link] == walk:
            joint = above[link]
            got = f"a cycle: link {shown(link)} is above its own parent {shown(joint.parent)}"
            raise file.error(got, "a tree, without cycles", line=joint.element.line, element=joint.label)
    return roots[0]


def _first(names: list[str]) -> str:
    more = ", ..." if len(names) > 5 else ""
    return ", ".join(shown(name) for name in names[:5]) + more
