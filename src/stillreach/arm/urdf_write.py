"""An arm as a URDF file: one link for each joint, a base, a tool; kinematics and limits alone, for MuJoCo, too."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._files import new_file
from stillreach._rotations import rpy
from stillreach.arm.follower import Moving
from stillreach.arm.urdf_joint import NO_LIMIT
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm.model import Arm

LONGEST = 900
"""Characters of a joint's name that its link is called after: readers, ours too, have a limit for all names."""
FOR_MUJOCO = '  <mujoco><compiler boundmass="1" boundinertia="0.01" fusestatic="false"/></mujoco>'
"""What makes MuJoCo read links without a mass, and keep those that do not move; other readers skip it."""
NOT_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def urdf_text(arm: Arm) -> str:
    """The file's text.

    Raises:
        InputError: a name holds characters that XML cannot hold.
    """
    names = _Names(str(moving.joint.name) for moving in arm.chain)
    parent = names.new("base_link")
    body = [f"  <link name={parent}/>"]
    for moving in arm.chain:
        child = names.new(f"{str(moving.joint.name)[:LONGEST]}_link")
        body += [f"  <link name={child}/>", *_joint(moving, str(arm.joints[moving.leader].name), parent, child)]
        parent = child
    tool = names.new("tool")
    body += [
        f"  <link name={tool}/>",
        f'  <joint name={names.new("tool_mount")} type="fixed">',
        *_placed(arm.tool, parent, tool),
        "  </joint>",
    ]
    version = ' version="1.2"' if np.isfinite(arm.acceleration_limits).any() else ""
    head = ['<?xml version="1.0"?>', f"<robot name={_quoted(arm.name)}{version}>", FOR_MUJOCO]
    return "\n".join([*head, *body, "</robot>", ""])


def write_urdf(arm: Arm, path: str | os.PathLike[str] | None) -> str:
    """The file's text, written to a path unless that is None.

    Raises:
        InputError: a name that XML cannot hold, or something else than a path.
        OSError: the file cannot be written.
    """
    text = urdf_text(arm)
    if path is not None:
        with new_file(path) as file:
            file.write(text.encode())
    return text


class _Names:
    """Names for links and joints, each once."""

    def __init__(self, taken: Iterable[str]) -> None:
        self.taken = set(taken)

    def new(self, wanted: str) -> str:
        """The name, with underscores where it is taken, quoted."""
        while wanted in self.taken:
            wanted += "_"
        self.taken.add(wanted)
        return _quoted(wanted)


def _quoted(name: str) -> str:
    if NOT_XML.search(name):
        raise InputError("name", _door.describe(name), "a name of characters that XML can hold")
    return quoteattr(name, {"\t": "&#9;", "\n": "&#10;", "\r": "&#13;"})


def _joint(moving: Moving, leader: str, parent: str, child: str) -> list[str]:
    joint, _, factor, offset = moving
    mimic = [f'    <mimic joint={_quoted(leader)} multiplier="{factor!r}" offset="{offset!r}"/>']
    lower, upper = joint.position_limits
    free = math.isinf(lower) and math.isinf(upper)
    word = "continuous" if free and joint.kind == "revolute" else joint.kind
    limit = [f'velocity="{_limit(joint.velocity_limit)}"', f'effort="{NO_LIMIT:g}"']
    if word != "continuous":
        limit = [f'lower="{_limit(lower)}"', f'upper="{_limit(upper)}"', *limit]
    if math.isfinite(joint.acceleration_limit):
        limit.append(f'acceleration="{_limit(joint.acceleration_limit)}"')
    return [
        f'  <joint name={_quoted(str(joint.name))} type="{word}">',
        *_placed(joint.placement, parent, child),
        f'    <axis xyz="{_numbers(joint.axis)}"/>',
        f"    <limit {' '.join(limit)}/>",
        *(mimic if joint.name != leader else []),
        "  </joint>",
    ]


def _placed(T: FloatArray, parent: str, child: str) -> list[str]:
    return [
        f"    <parent link={parent}/>",
        f"    <child link={child}/>",
        f'    <origin xyz="{_numbers(T[:3, 3])}" rpy="{_numbers(rpy(T[:3, :3]))}"/>',
    ]


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value) + 0.0) for value in np.asarray(list(values)))


def _limit(value: float) -> str:
    return repr(float(np.clip(value, -NO_LIMIT, NO_LIMIT)))
