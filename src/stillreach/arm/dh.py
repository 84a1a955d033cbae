"""Arms from Denavit-Hartenberg rows, in the standard and in the modified convention.

Standard (Denavit and Hartenberg, 1955): ``A_i = Rz(theta) Tz(d) Tx(a) Rx(alpha)``; joint i moves about or
along z of frame i-1. Modified (Craig, 1986): ``A_i = Rx(alpha) Tx(a) Rz(theta) Tz(d)``; joint i moves about
or along z of frame i, and row i holds Craig's alpha and a of link i-1. In both, the joint value is added to
theta of a revolute row and to d of a prismatic one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm.joint import KINDS, Joint
from stillreach.arm.placements import moved, translation

CONVENTIONS = ("standard", "modified")
X_AXIS, Z_AXIS = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class DHRow:
    """One row of a Denavit-Hartenberg table; keywords only, because column order differs between tables.

    Args:
        a: link length, along x [m].
        alpha: link twist, about x [rad].
        d: link offset, along z [m]; for a prismatic joint the offset that the joint value is added to.
        theta: joint angle, about z [rad]; for a revolute joint the offset that the joint value is added to.
        kind: ``"revolute"`` or ``"prismatic"``.
        name: the joint's name; None: ``j1``, ``j2``, … by position.

    Raises:
        InputError: if a value is not a finite number or the kind is invalid.
    """

    a: float = 0.0
    alpha: float = 0.0
    d: float = 0.0
    theta: float = 0.0
    kind: str = "revolute"
    name: str | None = None

    def __post_init__(self) -> None:
        for field in ("a", "alpha", "d", "theta"):
            object.__setattr__(self, field, _door.scalar(field, getattr(self, field)))
        _door.choice("kind", self.kind, KINDS)


def dh_chain(rows: Iterable[DHRow], convention: str, base: npt.ArrayLike | None) -> tuple[list[Joint], FloatArray]:
    """Returns joints and tool of the arm that the rows describe.

    Args:
        rows: one DHRow for each joint, from the base on.
        convention: ``"standard"`` or ``"modified"``.
        base: (4, 4) [m] pose of the table's frame 0 seen from the arm's base; None is the identity.

    Returns:
        The joints, and frame n of the table (4, 4) seen from the last one.

    Raises:
        InputError: if an item is not a DHRow, rows are missing, the convention is unknown or the base is not rigid.
    """
    _door.choice("convention", convention, CONVENTIONS)
    expected = "a list of DHRow, one for each joint, e.g. [DHRow(a=0.4, alpha=0.0, d=0.1, theta=0.0)]"
    table = _door.members("rows", rows, DHRow, expected)
    fixed = np.eye(4) if base is None else _door.pose("base", base)
    joints = []
    for row in table:
        across = translation(row.a, 0.0, 0.0) @ moved("revolute", X_AXIS, row.alpha)  # the two commute
        along = translation(0.0, 0.0, row.d) @ moved("revolute", Z_AXIS, row.theta)  # likewise
        if convention == "standard":
            joints.append(Joint(name=row.name, kind=row.kind, placement=fixed))
            fixed = along @ across
        else:
            joints.append(Joint(name=row.name, kind=row.kind, placement=fixed @ across @ along))
            fixed = np.eye(4)
    return joints, fixed
