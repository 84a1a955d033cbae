"""The default law: the true optimum inside the bounds, smooth where it must be."""

from __future__ import annotations

from dataclasses import dataclass

from stillreach import _core, _door
from stillreach.laws.law import LEAST_ERROR, Law


@dataclass(frozen=True, kw_only=True)
class LeastError(Law):
    """The least weighted task error inside the bounds, then the rates nearest to the reference.

    The bare optimum (``max_gain=None``) is not continuous: near a singularity, or where the task cannot be met, joints
    jump or run at full speed for next to nothing. With ``max_gain`` g the rates minimise |twist - J dq|² + κ |dq|²
    inside the bounds; κ is 0 (exact tracking) where the pseudoinverse is inside the bounds and no singular value is
    below 1/g, and rises to 1/(4 g²) as that ends. The rates are then continuous in configuration, twist and bounds, and
    change by at most g per unit of twist where κ does not move.

    Choose task rows that the arm can serve: one that it never can (the height of a planar arm) is a singular value of
    0, and keeps the damping on.

    Args:
        max_gain: g, joint rate over twist in weighted units; the default 10 means 10 rad/s per 1 m/s. A tool speed of
            v [m/s] then asks for at most 10 v [rad/s]. None: the bare optimum.
    """

    max_gain: float | None = 10.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.max_gain is not None:
            object.__setattr__(self, "max_gain", _door.positive("max_gain", self.max_gain))

    def core(self) -> _core.Law:
        """The settings as the compiled core reads them."""
        gain = 0.0 if self.max_gain is None else self.max_gain
        return _core.Law(LEAST_ERROR, rank_tolerance=self.rank_tolerance, max_gain=gain)
