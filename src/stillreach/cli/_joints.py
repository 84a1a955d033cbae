"""Joint values from the command line."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from stillreach._messages import listing, nearest
from stillreach._units import ANGLES, LENGTHS, quantity
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach._door import FloatArray
    from stillreach.arm import Arm

SHOWN = 3
"""Joints outside their limits that a message names."""
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


def configuration(arm: Arm, text: str | None, *, outside: bool) -> tuple[FloatArray | None, str]:
    """A configuration, and in words where it comes from.

    Args:
        arm: whose.
        text: ``"best"`` (the default), ``"zero"``, ``"middle"`` (of the limits), n numbers separated by commas, or
            ``joint=value`` pairs separated by commas, the other joints in the middle. Numbers are in rad or m, or carry
            a unit.
        outside: whether values may be outside the position limits.

    Returns:
        q (n,) [rad, m], None for the best, and its source.

    Raises:
        InputError: the text is none of these, or a value is outside the position limits.
    """
    import numpy as np

    if text is None or text == "best":
        return None, "where it moves best, of a sample of its range"
    if text == "middle":
        return middle(arm), "in the middle of its limits"
    if text == "zero":
        return np.zeros(arm.n), "with all joints at zero"
    q, source = _given(arm, text)
    if not outside:
        _refuse_outside(arm, q)
    return q, source


def _given(arm: Arm, text: str) -> tuple[FloatArray, str]:
    """A configuration from numbers or pairs."""
    import numpy as np

    parts = text.split(",")
    if "=" not in text:
        if len(parts) != arm.n:
            expected = f"{arm.n} numbers separated by commas, joint=value pairs, zero, middle or best"
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


def _refuse_outside(arm: Arm, q: FloatArray) -> None:
    from stillreach.arm.outside import outside

    found = outside(arm, q, arm.position_limits)
    if found:
        got = " and ".join(joint.got for joint in found[:SHOWN]) + (", among others" if len(found) > SHOWN else "")
        advice = "a bare number is in rad or m, as in files without [units]: -45deg, 50mm; --outside takes it as it is"
        raise InputError("--q", got, f"{found[0].expected}; {advice}")


def joint_index(arm: Arm, option: str, joint: str) -> int:
    """Index of a joint by its name; a bare number could count from 0 or from 1, and is no name.

    Raises:
        InputError: the arm has no such joint.
    """
    if joint in arm.joint_names:
        return arm.joint_names.index(joint)
    numbered = [name for name in arm.joint_names if re.fullmatch(rf"(.*\D)?0*{re.escape(joint)}", name)]
    near = numbered[0] if joint.isdecimal() and len(numbered) == 1 else nearest(joint, arm.joint_names)
    hint = f" (did you mean {near!r}?)" if near else ""
    raise InputError(option, repr(joint), f"the name of a joint: {listing(arm.joint_names)}{hint}")


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
