"""What one joint element of a URDF file says, as numbers that have been checked."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stillreach._door import FloatArray, unit_vector
from stillreach._rotations import from_quaternions, from_rpy, shortest_turn_from_z
from stillreach.arm.chain import Move
from stillreach.arm.mimic import LARGEST, Mimic
from stillreach.arm.placements import translation, turned
from stillreach.arm.robot_file import RobotFile
from stillreach.arm.robot_xml import XACRO, XACRO_ADVICE, Element
from stillreach.arm.urdf_numbers import JointNumbers
from stillreach.arm.urdf_tree import UrdfJoint

TYPES = ("revolute", "continuous", "prismatic", "fixed", "planar")
QUATERNIONS, STRICT_LIMITS = (1, 1), (1, 2)
"""The versions of URDF from which quaternions, and limits of the acceleration and required ranges are part of it."""


@dataclass(frozen=True)
class Movement:
    """One joint's numbers.

    Attributes:
        origin: (4, 4) [m] the child's frame seen from the parent's, joint at 0.
        moves: how it moves, one after the other: a fixed joint not at all, a planar one in three ways.
        mimic: whom it follows, or None.
    """

    origin: FloatArray
    moves: tuple[Move, ...]
    mimic: Mimic | None


def read_movement(file: RobotFile, joint: UrdfJoint) -> Movement:
    """The numbers of one joint.

    Raises:
        RobotFileError: a type that is none of TYPES; numbers that are none, not finite, too many or too large; an axis
            of length 0; no limits where there must be some.
    """
    numbers, kind = JointNumbers(file, joint), _type(file, joint)
    for child in joint.element.children:
        if child.tag.startswith(XACRO):
            raise numbers.error(child, "xacro", XACRO_ADVICE)
    origin = _origin(numbers)
    if kind == "fixed":
        return Movement(origin, (), None)
    mimic, axis = _mimic(numbers), _axis(numbers)
    if kind == "planar":
        if mimic is not None:
            raise numbers.error(numbers.element("mimic"), "a planar joint that follows another", "one that does not")
        return Movement(origin, _planar(numbers, axis), None)
    kind_of = "prismatic" if kind == "prismatic" else "revolute"
    position = _position(numbers, kind, mimic)
    return Movement(origin, (Move(joint.name, kind_of, axis, position, *_rates(numbers, mimic)),), mimic)


def _type(file: RobotFile, joint: UrdfJoint) -> str:
    word = joint.element.attributes.get("type", "").strip()
    if word in TYPES:
        return word
    raise file.unknown(word, "a type of joint", TYPES, line=joint.element.line, element=joint.label)


def _origin(numbers: JointNumbers) -> FloatArray:
    element = numbers.element("origin")
    if element is None:
        return np.eye(4)
    place = translation(*numbers.several(element, "xyz", 3, (0.0, 0.0, 0.0), LARGEST))
    has_angles = "rpy" in element.attributes
    if "quat_xyzw" in element.attributes:
        if numbers.joint.version >= QUATERNIONS:
            if has_angles:
                raise numbers.error(element, "both rpy and quat_xyzw", "one of them")
            return place @ _turned(numbers, element)
        if not has_angles:
            raise numbers.error(element, "quat_xyzw in a file of URDF 1.0", 'rpy, or <robot version="1.1">')
    return place @ turned(from_rpy(numbers.several(element, "rpy", 3, (0.0, 0.0, 0.0), LARGEST)))


def _turned(numbers: JointNumbers, element: Element) -> FloatArray:
    xyzw = numbers.several(element, "quat_xyzw", 4)
    if not any(xyzw):
        raise numbers.error(element, "a quaternion of length 0", "quat_xyzw='0 0 0 1' for no turn")
    x, y, z, w = xyzw
    return turned(from_quaternions("quat_xyzw", (w, x, y, z)))


def _axis(numbers: JointNumbers) -> FloatArray:
    element = numbers.element("axis")
    axis = (1.0, 0.0, 0.0) if element is None else numbers.several(element, "xyz", 3)
    if not any(axis):
        raise numbers.error(element, "an axis of length 0", "a direction, e.g. xyz='0 0 1'")
    return unit_vector("axis", axis)


def _position(numbers: JointNumbers, kind: str, mimic: Mimic | None) -> tuple[float, float]:
    """The range of a joint; that of a joint which follows another, and cannot be kept, is none."""
    limit, strict = numbers.element("limit"), numbers.joint.version >= STRICT_LIMITS
    if kind == "continuous":
        return -math.inf, math.inf
    if limit is None and (strict or mimic is None):
        expected = '<limit lower="..." upper="..." velocity="..."/> (a joint without limits is of type continuous)'
        raise numbers.error(None, f"no <limit> in a {kind} joint", expected)
    for name in ("lower", "upper"):
        if strict and limit is not None and name not in limit.attributes:
            raise numbers.error(limit, f"no {name} in a {kind} joint", "lower and upper, which URDF 1.2 requires")
    lower, upper = (numbers.limit(limit, name, 0.0) for name in ("lower", "upper"))
    if lower > upper or lower == math.inf or upper == -math.inf:
        if mimic is not None and not strict:
            return -math.inf, math.inf
        raise numbers.error(limit, f"lower {lower:g} above upper {upper:g}", "lower at most upper")
    return lower, upper


def _rates(numbers: JointNumbers, mimic: Mimic | None) -> tuple[float, float]:
    """Largest velocity and acceleration."""
    limit = numbers.element("limit")
    names = ("velocity", "acceleration", "deceleration")
    limits = [math.inf] * len(names)
    for k, name in enumerate(names if numbers.joint.version >= STRICT_LIMITS else names[:1]):
        limits[k] = numbers.limit(limit, name, math.inf)
        if limits[k] < 0.0 and mimic is None:
            raise numbers.error(limit, f"the {name} limit {limits[k]:g}", "a number of at least 0")
        if limits[k] <= 0.0 and mimic is not None:
            limits[k] = math.inf
    return limits[0], min(limits[1:])


def _planar(numbers: JointNumbers, axis: FloatArray) -> tuple[Move, ...]:
    """Two slides across the axis and a turn about it, named as MuJoCo names them; URDF has no ranges for them."""
    name, free, rates = numbers.joint.name, (-math.inf, math.inf), _rates(numbers, None)
    across = shortest_turn_from_z(axis)
    return (
        Move(f"{name}_TX", "prismatic", across[:, 0], free, *rates),
        Move(f"{name}_TY", "prismatic", across[:, 1], free, *rates),
        Move(f"{name}_RZ", "revolute", axis, free, *rates),
    )


def _mimic(numbers: JointNumbers) -> Mimic | None:
    element = numbers.element("mimic")
    if element is None:
        return None
    leader = element.attributes.get("joint", "").strip()
    if not leader:
        raise numbers.error(element, "no joint to follow", '<mimic joint="..."/>')
    return Mimic(leader, numbers.one(element, "multiplier", 1.0, LARGEST), numbers.one(element, "offset", 0.0, LARGEST))
