"""The formats of robot files: their names, roots and suffixes, and the module that reads each."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Format:
    """A format of robot files; ``Arm.from_...`` reads it with ``chain(source, tip, base, fixed)`` of the module.

    Attributes:
        word: its name.
        root: tag of a file's root element.
        suffix: of its files.
        module: the module that reads it.
        tips: what its tips are.
    """

    word: str
    root: str
    suffix: str
    module: str
    tips: str = "link"


FORMATS = {
    "urdf": Format("URDF", "robot", "urdf", "stillreach.arm.urdf"),
    "mjcf": Format("MJCF", "mujoco", "xml", "stillreach.arm.mjcf", "body or site"),
}
"""By the ending of the method of ``Arm`` that reads it."""


def advice(root: str) -> str:
    """`` (Arm.from_mjcf reads MJCF files)`` for the root element of another format, else nothing."""
    return "".join(f" (Arm.from_{key} reads {f.word} files)" for key, f in FORMATS.items() if f.root == root)
