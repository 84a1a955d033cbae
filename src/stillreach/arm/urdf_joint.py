"""What one joint element of a URDF file says, as numbers that have been checked."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from stillreach._door import FloatArray, unit_vector
from stillreach.arm.mimic import LARGEST, Mimic
from stillreach.arm.placements import rotation_x, rotation_y, rotation_z, translation
from stillreach.arm.robot_file import RobotFile, shown
from stillreach.arm.robot_xml import XACRO_ADVICE, Element
from stillreach.arm.urdf_tree import UrdfJoint, only
from stillreach.errors import RobotFileError

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
NO_LIMIT = 1e9
"""A limit [rad, m, rad/s, m/s] of this size or more is none: URDF has no word for infinity."""
KIND_OF = {"revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic", "fixed": "fixed"}


@dataclass(frozen=True)
class Movement:
    """One joint's numbers.

    Attributes:
        kind: ``"revolute"``, ``"prismatic"`` or ``"fixed"``.
        origin: (4, 4) [m] the child's frame seen from the parent's, joint at 0.
        axis: (3,) of length 1, in the child's frame.
        position: (lower, upper) [rad] or [m]; infinite for a continuous joint.
        velocity: largest rate [rad/s] or [m/s]; infinite where the file has none.
        mimic: whom it follows, or None.
    """

    kind: str
    origin: FloatArray
    axis: FloatArray
    position: tuple[float, float]
    velocity: float
    mimic: Mimic | None


def read_movement(file: RobotFile, joint: UrdfJoint) -> Movement:
    """The numbers of one joint.

    Raises:
        RobotFileError: a type that is none of revolute, continuous, prismatic and fixed; numbers that are none, not
            finite, too many or too large; an axis of length 0; no limits where there must be some.
    """
    kind = _kind(file, joint)
    origin = _origin(file, joint)
    if kind == "fixed":
        return Movement(kind, origin, np.array([1.0, 0.0, 0.0]), (0.0, 0.0), 0.0, None)
    limit = only(file, joint.element, "limit", joint.label)
    position = _position(file, joint, limit)
    velocity = math.inf if limit is None else _limit(file, joint, limit, "velocity", math.inf)
    if velocity < 0.0:
        raise _error(file, joint, limit, f"the velocity limit {velocity:g}", "a number of at least 0")
    return Movement(kind, origin, _axis(file, joint), position, velocity, _mimic(file, joint))


def _kind(file: RobotFile, joint: UrdfJoint) -> str:
    word = joint.element.attributes.get("type", "").strip()
    if word in KIND_OF:
        return KIND_OF[word]
    if word in ("floating", "planar"):
        got, expected = f"the type {word!r} between base and tip", "a chain of joints that move in one way each"
        choices = ", ".join(KIND_OF)
        raise file.error(got, f"{expected} ({choices})", line=joint.element.line, element=joint.label)
    raise file.unknown(word, "a type of joint", KIND_OF, line=joint.element.line, element=joint.label)


def _origin(file: RobotFile, joint: UrdfJoint) -> FloatArray:
    element = only(file, joint.element, "origin", joint.label)
    if element is None:
        return np.eye(4)
    x, y, z = _three(file, joint, element, "xyz", (0.0, 0.0, 0.0), LARGEST)
    roll, pitch, yaw = _three(file, joint, element, "rpy", (0.0, 0.0, 0.0), LARGEST)
    return translation(x, y, z) @ rotation_z(yaw) @ rotation_y(pitch) @ rotation_x(roll)


def _axis(file: RobotFile, joint: UrdfJoint) -> FloatArray:
    element = only(file, joint.element, "axis", joint.label)
    axis = (1.0, 0.0, 0.0) if element is None else _three(file, joint, element, "xyz", None, math.inf)
    if not any(axis):
        raise _error(file, joint, element, "an axis of length 0", "a direction, e.g. xyz='0 0 1'")
    return unit_vector("axis", axis)


def _position(file: RobotFile, joint: UrdfJoint, limit: Element | None) -> tuple[float, float]:
    word = joint.element.attributes["type"].strip()
    if word == "continuous":
        return -math.inf, math.inf
    if limit is None:
        expected = '<limit lower="..." upper="..." velocity="..."/> (a joint without limits is of type continuous)'
        raise _error(file, joint, None, f"no <limit> in a {word} joint", expected)
    lower, upper = (_limit(file, joint, limit, name, 0.0) for name in ("lower", "upper"))
    if lower > upper or lower == math.inf or upper == -math.inf:
        raise _error(file, joint, limit, f"lower {lower:g} above upper {upper:g}", "lower at most upper")
    return lower, upper


def _mimic(file: RobotFile, joint: UrdfJoint) -> Mimic | None:
    element = only(file, joint.element, "mimic", joint.label)
    if element is None:
        return None
    leader = element.attributes.get("joint", "").strip()
    if not leader:
        raise _error(file, joint, element, "no joint to follow", '<mimic joint="..."/>')
    multiplier = _number(file, joint, element, "multiplier", 1.0, LARGEST)
    return Mimic(leader, multiplier, _number(file, joint, element, "offset", 0.0, LARGEST))


def _limit(file: RobotFile, joint: UrdfJoint, element: Element, name: str, default: float) -> float:
    number = _number(file, joint, element, name, default)
    return math.copysign(math.inf, number) if abs(number) >= NO_LIMIT else number


def _number(
    file: RobotFile, joint: UrdfJoint, element: Element, name: str, default: float, largest: float = math.inf
) -> float:
    text = element.attributes.get(name)
    return default if text is None else _convert(file, joint, element, name, text, largest)


def _three(
    file: RobotFile,
    joint: UrdfJoint,
    element: Element,
    name: str,
    default: tuple[float, float, float] | None,
    largest: float,
) -> tuple[float, float, float]:
    text = element.attributes.get(name)
    if text is None and default is not None:
        return default
    if text is not None and "$" in text:
        raise _error(file, joint, element, f"xacro in {name}={shown(text)}", XACRO_ADVICE)
    words = [] if text is None else text.split()
    if len(words) != 3:
        got = f"no {name}" if text is None else f"{len(words)} numbers in {name}={shown(text)}"
        raise _error(file, joint, element, got, f"3 numbers, e.g. {name}='0 0 1'")
    x, y, z = (_convert(file, joint, element, name, word, largest) for word in words)
    return x, y, z


def _convert(file: RobotFile, joint: UrdfJoint, element: Element, name: str, word: str, largest: float) -> float:
    if "$" in word:
        raise _error(file, joint, element, f"xacro in {name}={shown(word)}", XACRO_ADVICE)
    number = float(word) if NUMBER.fullmatch(word.strip()) else math.nan
    if not math.isfinite(number):
        raise _error(file, joint, element, f"{name}={shown(word)}", "a finite number, e.g. '0.5'")
    if abs(number) > largest:
        raise _error(file, joint, element, f"{name}={shown(word)}", f"a number between -{largest:g} and {largest:g}")
    return number


def _error(file: RobotFile, joint: UrdfJoint, element: Element | None, got: str, expected: str) -> RobotFileError:
    tag, line = ("", joint.element.line) if element is None else (f" <{element.tag}>", element.line)
    return file.error(got, expected, line=line, element=f"{joint.label}{tag}")
