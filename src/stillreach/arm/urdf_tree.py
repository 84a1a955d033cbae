"""The links and joints of a URDF file as a tree: what is connected to what, and whether it is one tree at all."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from stillreach._formats import advice
from stillreach.arm.robot_file import shown
from stillreach.arm.robot_xml import Element

VERSIONS = ("1.0", "1.1", "1.2")


Above = Mapping[str, tuple[Element, str]]
"""By link, the joint whose child it is, and that joint's parent; the root has none."""


class Tree(NamedTuple):
    """One tree of links.

    Attributes:
        links: their names, in the order of the file.
        joints: their elements by name, in the order of the file.
        above: how they are connected.
        root: the link that no joint has as its child.
        version: of URDF, (1, 0) to (1, 2): what the elements mean.
    """

    links: tuple[str, ...]
    joints: dict[str, Element]
    above: Above
    root: str
    version: tuple[int, int]

    def parent(self, link: str) -> str | None:
        """The link above another one; None for the root."""
        return self.above[link][1] if link in self.above else None

    def leaves(self, base: str) -> tuple[str, ...]:
        """The links without children below a base link, or all of them if there is nothing below it."""
        parents = {parent for _, parent in self.above.values()}
        leaves = tuple(link for link in self.links if link not in parents and link != base)
        tops = _tops(self.links, self.above, base)
        return tuple(link for link in leaves if tops[link] == base) or leaves


def build_tree(root: Element) -> Tree:
    """The tree of a parsed URDF file.

    Raises:
        RobotFileError: if it is not a robot or of an unknown version, a name is missing or there twice, a link does not
            exist or has two parents, or the links are in a cycle or not connected.
    """
    if root.tag != "robot":
        expected = f"<robot>, the root of a URDF file{advice(root.tag)}"
        raise root.file.error(root.label, expected, line=root.line)
    version = _version(root)
    links = tuple(_named(root, "link"))
    if not links:
        raise root.error("a robot without links", "at least one <link>")
    joints, known = _named(root, "joint"), set(links)
    above: dict[str, tuple[Element, str]] = {}
    for joint in joints.values():
        parent, child = (_end(joint, tag, known, links) for tag in ("parent", "child"))
        if child in above:
            got = f"a second parent for link {shown(child)}, which is the child of {above[child][0].label}, too"
            raise joint.error(got, "one parent for each link: a tree")
        above[child] = joint, parent
    return Tree(links, joints, above, _root(root, links, above), version)


def _version(root: Element) -> tuple[int, int]:
    """The version of URDF that the file is written in, 1.0 where it names none."""
    word = root.attributes.get("version", VERSIONS[0])
    numbers = re.fullmatch(r"\s*0*(\d{1,4})\.0*(\d{1,4})\s*", word, re.ASCII)
    if numbers is None or f"{numbers[1]}.{numbers[2]}" not in VERSIONS:
        raise root.error(f"version={shown(word)}", ", ".join(VERSIONS))
    return int(numbers[1]), int(numbers[2])


def _named(root: Element, tag: str) -> dict[str, Element]:
    """The links or the joints by name, each there and each once."""
    found: dict[str, Element] = {}
    for element in (child for child in root.children if child.tag == tag):
        name = element.word("name")
        if not name:
            raise element.error("no name", "a name")
        if name in found:
            raise element.error(f"a second {element.label}; the first is in line {found[name].line}", "each name once")
        found[name] = element
    return found


def _end(joint: Element, tag: str, known: set[str], links: tuple[str, ...]) -> str:
    """The link at one end of a joint."""
    ends = [child for child in joint.children if child.tag == tag]
    named = {end.word("link"): end for end in reversed(ends)}
    link, end = next(iter(named.items()), ("", joint))
    place: dict[str, Any] = {"line": end.line, "element": joint.label}
    if len(named) > 1:
        raise joint.file.error(f"{len(named)} <{tag}> that differ", "one", line=ends[1].line, element=joint.label)
    if not link:
        raise joint.file.error(f"no {tag} link", f'<{tag} link="..."/>', **place)
    if link not in known:
        raise joint.file.unknown(link, f"a link of the file as {tag}", links, **place)
    return link


def _root(robot: Element, links: tuple[str, ...], above: Above) -> str:
    """The one link without a parent, from which every link can be reached."""
    roots = [link for link in links if link not in above]
    if len(roots) > 1:
        got = f"{len(roots)} links without a parent: {', '.join(map(shown, roots[:5]))}{', ...' * (len(roots) > 5)}"
        raise robot.file.error(got, "one tree, all of whose links hang together", choices=tuple(roots))
    return _tops(links, above, None)[links[0]]


def _tops(links: tuple[str, ...], above: Above, base: str | None) -> dict[str, str]:
    """By link, where the way up from it ends: at the base or at the root; RobotFileError if it is a cycle."""
    tops: dict[str, str] = {}
    for link in links:
        walk = set[str]()
        while link in above and link != base and link not in tops:
            joint, parent = above[link]
            if link in walk:
                got = f"a cycle: link {shown(link)} is above its own parent {shown(parent)}"
                raise joint.error(got, "a tree, without cycles")
            walk.add(link)
            link = parent
        tops |= dict.fromkeys((*walk, link), tops.get(link, link))
    return tops
