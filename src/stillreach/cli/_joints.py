"""Joint values from the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stillreach.cli._units import ANGLES, LENGTHS, quantity
from stillreach.errors import InputError, UnknownJointError

if TYPE_CHECKING:
    from stillreach._door import FloatArray
    from stillreach.arm import Arm

ANY_UNIT = {"": 1.0, **ANGLES, **LENGTHS}


def assignments(option: str, texts: list[str]) -> dict[str, float]:
    """Pairs ``joint=value``, one a text or several with commas between them, as a dict; values in [rad] or [m].

    Raises:
        InputError: a text is no such pair, or names a joint for the second time.
    """
    found: dict[str, float] = {}
    for pair in [pair for text in texts for pair in _pairs(text)]:
        joint, equals, value = pair.partition("=")
        if not (joint and equals):
            raise InputError(option, repr(pair), "joint=value, e.g. panda_finger_joint1=0.04 or j4=-90deg")
        if joint in found:
            raise InputError(option, f"joint {joint!r} twice", "each joint once")
        found[joint] = quantity(f"{option} {joint}", value, ANY_UNIT)
    return found


def _pairs(text: str) -> list[str]:
    parts = text.split(",")
    return [part.strip() for part in parts] if all("=" in part for part in parts) else [text]


def configuration(arm: Arm, text: str | None) -> tuple[FloatArray, str]:
    """A configuration, and in words where it comes from.

    Args:
        arm: whose.
        text: ``"zero"``, ``"middle"`` (of the limits; the default), n numbers separated by commas, or ``joint=value``
            pairs separated by commas, the other joints in the middle. Numbers are in rad or m, or carry a unit.

    Returns:
        q (n,) [rad, m] and its source.

    Raises:
        InputError: it is none of these.
        UnknownJointError: a pair names a joint that the arm does not have.
    """
    import numpy as np

    if text is None or text == "middle":
        return middle(arm), "in the middle of its limits"
    if text == "zero":
        return np.zeros(arm.n), "with all joints at zero"
    parts = text.split(",")
    if "=" not in text:
        if len(parts) != arm.n:
            expected = f"{arm.n} numbers separated by commas, joint=value pairs, zero or middle"
            raise InputError("--q", f"{len(parts)} values ({text!r})", expected)
        values = [_value(arm, i, part) for i, part in enumerate(parts)]
        return np.array(values), "as given"
    q = middle(arm)
    for part in parts:
        joint, equals, value = part.strip().partition("=")
        if not equals:
            raise InputError("--q", repr(part), "joint=value pairs separated by commas, e.g. j2=30deg,j4=-90deg")
        i = joint_index(arm, "--q", joint)
        q[i] = _value(arm, i, value)
    return q, "as given, the other joints in the middle of their limits"


def joint_index(arm: Arm, option: str, joint: str) -> int:
    """Index of a joint by its name or its 0-based index.

    Raises:
        UnknownJointError: the arm has no such joint.
    """
    try:
        by_index = joint.isdecimal() and len(joint) < 10 and joint not in arm.joint_names
        return arm.joint_index(int(joint) if by_index else joint)
    except UnknownJointError as error:
        raise UnknownJointError(option, error.got, error.choices) from None


def middle(arm: Arm) -> FloatArray:
    """(n,) the middle of each joint's limits; for one without both, the value nearest to 0 [rad, m]."""
    import numpy as np

    lower, upper = arm.position_limits.T
    both = np.isfinite(lower) & np.isfinite(upper)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(both, (lower + upper) / 2, np.clip(0.0, lower, upper)))


def _value(arm: Arm, i: int, text: str) -> float:
    units = LENGTHS if arm.kinds[i] else ANGLES
    return quantity(f"--q, joint {arm.joint_names[i]}", text, units)
