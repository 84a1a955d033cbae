"""What a run records: name, axes, type, unit and meaning of each of its arrays, in one table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from stillreach.status import Health, Reason, Status

TWIST_COMPONENTS = ("vx", "vy", "vz", "wx", "wy", "wz")

AXES = {"joint": None, "row": 4, "column": 4, "component": len(TWIST_COMPONENTS)}
"""Length of each axis that a row of an array can have; None is the number of joints."""

RATE_UNITS = {"rad": "rad/s", "m": "m/s"}
"""Unit of a joint's rate by the unit of its value."""

STATUS_CODES = 2 * max(Status)
"""All sums of flags lie below it."""


@dataclass(frozen=True)
class Field:
    """One array of a run, (T, ...) with T the number of ticks.

    Args:
        name: attribute of the run and variable of the file.
        axes: its axes after time.
        units: unit in the words of UDUNITS; ``"joint"`` and ``"joint/s"`` stand for the joints' own.
        long_name: what it is, for axes of plots and readers of the file.
        dtype: type of its entries.
        codes: least and largest of its codes; None for measured quantities.
    """

    name: str
    axes: tuple[str, ...]
    units: str
    long_name: str
    dtype: npt.DTypeLike = np.float64
    codes: tuple[int, int] | None = None

    @property
    def kind(self) -> str:
        """NumPy's letter for the kind of its type."""
        return np.dtype(self.dtype).kind

    def shape(self, ticks: int, joints: int) -> tuple[int, ...]:
        """The array's shape for so many ticks and joints."""
        return (ticks, *(AXES[axis] or joints for axis in self.axes))

    def row_bytes(self, joints: int) -> int:
        """Memory of one tick's row."""
        return int(np.prod(self.shape(1, joints))) * np.dtype(self.dtype).itemsize


FIELDS = (
    Field("time", (), "s", "time since the start"),
    Field("path_time", (), "s", "time along the motion that the tick was told"),
    Field("q", ("joint",), "joint", "joint values"),
    Field("rates", ("joint",), "joint/s", "commanded joint rates"),
    Field("pose", ("row", "column"), "m (last column), 1", "pose of the tool in the base frame"),
    Field("target", ("row", "column"), "m (last column), 1", "pose that the motion has led to, in the base frame"),
    Field("command", ("component",), "m/s, rad/s", "twist asked of the law, feedback included"),
    Field("residual", ("component",), "m/s, rad/s", "twist asked of the law minus the twist that the rates make"),
    Field("task_error", (), "1", "weighted norm of the residual"),
    Field("damping", (), "1", "damping factor, in units of the weighted J J'"),
    Field("scale", (), "1", "fraction of the commanded twist that was asked for"),
    Field("status", (), "1", "what was true of the tick (bits of stillreach.Status)", np.int32, (0, STATUS_CODES - 1)),
    Field("lower", ("joint",), "joint/s", "lower bound of the joint rates"),
    Field("upper", ("joint",), "joint/s", "upper bound of the joint rates"),
    Field("health", ("joint",), "1", "state of the joints", np.int8, (0, max(Health))),
    Field(
        "active",
        ("joint",),
        "1",
        "bound that each joint is at (stillreach.Reason), negative at the lower",
        np.int8,
        (-max(Reason), max(Reason)),
    ),
)

CODES = {
    "health": {int(code): code.name.lower() for code in Health},
    "active": {
        side * int(reason): "free" if not reason else f"{reason.name.lower()}_{'upper' if side > 0 else 'lower'}"
        for side in (-1, 1)
        for reason in Reason
    },
}
"""Meaning of each code in the arrays that hold codes."""


def empty_record(ticks: int, joints: int) -> dict[str, np.ndarray]:
    """Arrays for so many ticks, by name, not yet filled."""
    return {field.name: np.empty(field.shape(ticks, joints), dtype=field.dtype) for field in FIELDS}
