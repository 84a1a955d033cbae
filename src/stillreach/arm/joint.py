"""One joint of an arm: placement, kind, axis and limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._core import JointKind
from stillreach._door import FloatArray
from stillreach.arm.value import Value
from stillreach.errors import InputError

KINDS = tuple(kind.name.lower() for kind in JointKind)
"""Kinds of joints; the index in this tuple is the code in ``Arm.kinds``."""


@dataclass(frozen=True, init=False, eq=False)
class Joint(Value):
    """A revolute or prismatic joint with its fixed placement and its limits. Immutable.

    Args:
        name: its name; None: ``j1``, ``j2``, … by position in the arm.
        kind: ``"revolute"`` (turns about its axis) or ``"prismatic"`` (slides along it).
        placement: (4, 4) [m] pose of the joint's frame, at joint value 0, in the frame that the previous joint
            moves (in the base frame for the first joint); rigid to 1e-9.
        axis: (3,) direction of the axis in the joint's own frame; scaled to length 1.
        position_limits: (lower, upper) [rad] or [m]; infinite: no limit.
        velocity_limit: largest velocity in either direction [rad/s] or [m/s]; 0: it cannot move, inf: no limit.
        acceleration_limit: largest acceleration in either direction [rad/s²] or [m/s²]; inf: no limit.

    Raises:
        InputError: if an argument is invalid; the message names the joint.
    """

    name: str | None
    kind: str
    placement: FloatArray
    axis: FloatArray
    position_limits: tuple[float, float]
    velocity_limit: float
    acceleration_limit: float

    def __init__(
        self,
        *,
        name: str | None = None,
        kind: str = "revolute",
        placement: npt.ArrayLike | None = None,
        axis: npt.ArrayLike = (0.0, 0.0, 1.0),
        position_limits: npt.ArrayLike = (-math.inf, math.inf),
        velocity_limit: float = math.inf,
        acceleration_limit: float = math.inf,
    ) -> None:
        owner = "" if name is None else f" of joint {_joint_name(name)!r}"
        values = {
            "name": name,
            "kind": _door.choice(f"kind{owner}", kind, KINDS),
            "placement": _door.pose(f"placement{owner}", np.eye(4) if placement is None else placement),
            "axis": _door.unit_vector(f"axis{owner}", axis),
            "position_limits": _interval(f"position_limits{owner}", position_limits),
            "velocity_limit": _door.positive(f"velocity_limit{owner}", velocity_limit, or_zero=True, allow_inf=True),
            "acceleration_limit": _door.positive(
                f"acceleration_limit{owner}", acceleration_limit, or_zero=True, allow_inf=True
            ),
        }
        for field, value in values.items():
            object.__setattr__(self, field, value)


def named(joints: Any) -> tuple[Joint, ...]:
    """The joints, each with a unique name."""
    given = _door.members("joints", joints, Joint, "one or more Joint, from the base on")
    chain = [replace(joint, name=f"j{place + 1}") if joint.name is None else joint for place, joint in enumerate(given)]
    places: dict[str | None, int] = {}
    for place, joint in enumerate(chain):
        if joint.name in places:
            got = f"the name {joint.name!r} at places {places[joint.name]} and {place}"
            raise InputError("joints", got, "unique names")
        places[joint.name] = place
    return tuple(chain)


def _joint_name(name: Any) -> str:
    if not isinstance(name, str) or not name or name != name.strip():
        raise InputError("name", _door.describe(name), "a joint name (text, not empty, no space around it) or None")
    return name


def _interval(name: str, value: Any) -> tuple[float, float]:
    """(lower, upper) with lower <= upper, each possibly infinite on its own side."""
    expected = "two numbers (lower, upper) with lower <= upper, lower below inf and upper above -inf"
    limits = _door.vector(name, value, None, allow_inf=True)
    if limits.shape != (2,) or limits[0] > limits[1] or limits[0] == math.inf or limits[1] == -math.inf:
        raise InputError(name, _door.describe(value), expected)
    return float(limits[0]), float(limits[1])
