"""The steps that one joint element of a URDF file stands for, with numbers that have been checked."""

from __future__ import annotations

import math

from stillreach._door import FloatArray, unit_vector
from stillreach._rotations import from_quaternions, from_rpy, shortest_turn_from_z
from stillreach.arm.chain import Step
from stillreach.arm.joint import Joint
from stillreach.arm.led import LARGEST, Led
from stillreach.arm.placements import translation, turned
from stillreach.arm.robot_xml import XACRO, XACRO_ADVICE, Element

TYPES = ("revolute", "continuous", "prismatic", "fixed", "planar")
QUATERNIONS, STRICT_LIMITS = (1, 1), (1, 2)
"""The versions of URDF from which quaternions, and limits of the acceleration and required ranges are part of it."""
NO_LIMIT = 1e9
"""A limit of this size or more [SI units] is none: URDF has no word for infinity."""
NONE = (0.0, 0.0, 0.0)


def read_joint(joint: Element, version: tuple[int, int]) -> tuple[list[Step], Led | None]:
    """The steps from a joint's parent to its child, and whom it follows: a planar joint moves in three ways.

    Raises:
        RobotFileError: if its type is not one of TYPES, numbers are invalid, not finite, too many or too large, its
            axis has length 0, or required limits are missing.
    """
    kind = joint.word("type")
    if kind not in TYPES:
        raise joint.unknown(kind, "a type of joint", TYPES)
    for child in joint.children:
        if child.tag.startswith(XACRO):
            raise child.error("xacro", XACRO_ADVICE)
    origin = _origin(joint.child("origin"), version)
    if kind == "fixed":
        return [origin], None
    mimic, axis = _mimic(joint.child("mimic")), _axis(joint.child("axis"))
    limit, strict = joint.child("limit"), version >= STRICT_LIMITS
    if kind == "planar":
        if mimic is not None:
            raise joint.child("mimic").error("a planar joint that follows another", "one that does not")
        return [origin, *_planar(joint.word("name"), axis, _rates(limit, strict, False))], None
    position = (-math.inf, math.inf) if kind == "continuous" else _position(joint, kind, strict, mimic is not None)
    velocity, acceleration = _rates(limit, strict, mimic is not None)
    moving = Joint(
        name=joint.word("name"),
        kind="prismatic" if kind == "prismatic" else "revolute",
        axis=axis,
        position_limits=position,
        velocity_limit=velocity,
        acceleration_limit=acceleration,
    )
    return [origin, moving], mimic


def _origin(origin: Element, version: tuple[int, int]) -> FloatArray:
    place = translation(*origin.numbers("xyz", 3, NONE, LARGEST))
    has_angles = "rpy" in origin.attributes
    if "quat_xyzw" in origin.attributes:
        if version >= QUATERNIONS:
            if has_angles:
                raise origin.error("both rpy and quat_xyzw", "one of them")
            x, y, z, w = origin.numbers("quat_xyzw", 4)
            if not any((x, y, z, w)):
                raise origin.error("a quaternion of length 0", "quat_xyzw='0 0 0 1' for no turn")
            return place @ turned(from_quaternions("quat_xyzw", (w, x, y, z)))
        if not has_angles:
            raise origin.error("quat_xyzw in a file of URDF 1.0", 'rpy, or <robot version="1.1">')
    return place @ turned(from_rpy(origin.numbers("rpy", 3, NONE, LARGEST)))


def _axis(axis: Element) -> FloatArray:
    xyz = (1.0, 0.0, 0.0) if axis.missing else axis.numbers("xyz", 3)
    if not any(xyz):
        raise axis.error("an axis of length 0", "a direction, e.g. xyz='0 0 1'")
    return unit_vector("axis", xyz)


def _position(joint: Element, kind: str, strict: bool, follows: bool) -> tuple[float, float]:
    """The range of a joint; an invalid one of a joint that follows another is none."""
    limit = joint.child("limit")
    if limit.missing and (strict or not follows):
        expected = '<limit lower="..." upper="..." velocity="..."/> (a joint without limits is of type continuous)'
        raise joint.error(f"no <limit> in a {kind} joint", expected)
    for name in ("lower", "upper"):
        if strict and name not in limit.attributes:
            raise limit.error(f"no {name} in a {kind} joint", "lower and upper, which URDF 1.2 requires")
    lower, upper = (_limit(limit, name, 0.0) for name in ("lower", "upper"))
    if lower > upper or lower == math.inf or upper == -math.inf:
        if follows and not strict:
            return -math.inf, math.inf
        raise limit.error(f"lower {lower:g} above upper {upper:g}", "lower at most upper")
    return lower, upper


def _rates(limit: Element, strict: bool, follows: bool) -> tuple[float, float]:
    """Largest velocity and acceleration; those of a joint that follows another count above 0."""
    names = ("velocity", "acceleration", "deceleration")
    limits = [math.inf] * len(names)
    for k, name in enumerate(names if strict else names[:1]):
        limits[k] = _limit(limit, name, math.inf)
        if limits[k] < 0.0 and not follows:
            raise limit.error(f"the {name} limit {limits[k]:g}", "a number of at least 0")
        if limits[k] <= 0.0 and follows:
            limits[k] = math.inf
    return limits[0], min(limits[1:])


def _limit(limit: Element, name: str, default: float) -> float:
    """A limit; infinite where it is too large to be one."""
    number = limit.number(name, default)
    return math.copysign(math.inf, number) if abs(number) >= NO_LIMIT else number


def _planar(name: str, axis: FloatArray, rates: tuple[float, float]) -> list[Joint]:
    """Two slides across the axis and a turn about it, named as MuJoCo names them; URDF has no ranges for them."""
    across = shortest_turn_from_z(axis)
    ways = (("TX", "prismatic", across[:, 0]), ("TY", "prismatic", across[:, 1]), ("RZ", "revolute", axis))
    velocity, acceleration = rates
    return [
        Joint(name=f"{name}_{end}", kind=kind, axis=along, velocity_limit=velocity, acceleration_limit=acceleration)
        for end, kind, along in ways
    ]


def _mimic(mimic: Element) -> Led | None:
    if mimic.missing:
        return None
    leader = mimic.word("joint")
    if not leader:
        raise mimic.error("no joint to follow", '<mimic joint="..."/>')
    return Led(leader, mimic.number("multiplier", 1.0, LARGEST), mimic.number("offset", 0.0, LARGEST))
