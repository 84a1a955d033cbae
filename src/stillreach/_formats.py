"""The formats of robot files: what ``Arm.from_urdf`` and its like, the command line and scenario files read."""

from __future__ import annotations

from typing import NamedTuple


class Format(NamedTuple):
    """A format of robot files.

    Attributes:
        word: its name.
        root: tag of a file's root element.
        suffix: of its files.
        tip: the kinds of things that can carry the tool.
    """

    word: str
    root: str
    suffix: str
    tip: str


FORMATS = {
    "urdf": Format("URDF", "robot", "urdf", "link"),
    "mjcf": Format("MJCF", "mujoco", "xml", "body or site"),
}
"""By name, as in ``Arm.from_urdf``; the module of that name in ``stillreach.arm`` reads it."""


def advice(root: str) -> str:
    """`` (Arm.from_mjcf reads MJCF files)`` for the root element of another format, else nothing."""
    return "".join(f" (Arm.from_{key} reads {f.word} files)" for key, f in FORMATS.items() if f.root == root)
