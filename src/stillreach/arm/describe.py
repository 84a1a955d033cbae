"""An arm as text: what a person checks before trusting the model."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stillreach._door import FloatArray
from stillreach._words import aligned
from stillreach.arm.placements import moved

if TYPE_CHECKING:
    from stillreach.arm.model import Arm

HEAD = ("joint", "kind", "place at zero [m]", "axis at zero", "position", "rate", "acceleration", "unit")


def describe(arm: Arm) -> str:
    """Reach, a table of the joints, and where the tool is.

    The table holds name, kind, place and axis (in base axes, all joints at 0), limits and their unit.
    """
    rows, T = [HEAD], np.eye(4)
    for joint, leader, factor, offset in arm.chain:
        T = T @ joint.placement
        lower, upper = joint.position_limits
        position = "free" if math.isinf(lower) and math.isinf(upper) else f"{_number(lower)} … {_number(upper)}"
        limits = (position, _limit(joint.velocity_limit), _limit(joint.acceleration_limit))
        if joint.name != arm.joints[leader].name:
            limits = (f"{_number(factor)} {arm.joints[leader].name}{_added(offset)}", "follows", "")
        frame = (_triple(T[:3, 3]), _triple(T[:3, :3] @ joint.axis))
        rows.append((str(joint.name), joint.kind, *frame, *limits, "m" if joint.kind == "prismatic" else "rad"))
        T = T @ moved(joint.kind, joint.axis, offset)
    tool = f"  tool at zero: {_triple((T @ arm.tool)[:3, 3])} m"
    return "\n".join([f"{headline(arm)}:", *(f"  {line}" for line in aligned(rows).splitlines()), tool])


def axes_at_zero(arm: Arm) -> FloatArray:
    """(n, 3) axes of the joints in the base frame, all joints at 0."""
    J = arm.jacobian(np.zeros(arm.n))
    return np.where(arm.kinds == 1, J[:3], J[3:]).T


def headline(arm: Arm) -> str:
    """Name, number and kinds of joints, reach."""
    slides = int(np.count_nonzero(arm.kinds))
    turns = arm.n - slides
    kinds = " + ".join(f"{count} {kind}" for count, kind in ((turns, "revolute"), (slides, "prismatic")) if count)
    return f"{arm.name}, {kinds} joint{'s' if arm.n > 1 else ''}, reach at most {arm.reach:.4g} m"


def _triple(vector: np.ndarray) -> str:
    whole = np.round(vector, 3) + 0.0  # + 0.0: no "-0"
    return f"({', '.join(_number(part) for part in whole)})"


def _added(offset: float) -> str:
    return f" {'-' if offset < 0 else '+'} {_number(abs(offset))}" if offset else ""


def _limit(value: float) -> str:
    return "free" if math.isinf(value) else _number(value)


def _number(value: float) -> str:
    return f"{value:.4g}"
