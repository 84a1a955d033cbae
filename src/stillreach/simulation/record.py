"""The arrays of a run: name, axes, type, unit and meaning of each of its arrays, in one table."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple, TypeAlias, get_type_hints

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach.errors import InputError
from stillreach.status import Health, Reason, Status

TWIST_COMPONENTS = _door.TWIST.names

AXES = {"joint": None, "row": 4, "column": 4, "component": len(TWIST_COMPONENTS)}
"""Length of each axis that a row of an array can have; None is the number of joints."""

RATE_UNITS = {"rad": "rad/s", "m": "m/s"}
"""Unit of a joint's rate by the unit of its value."""

HEALTHS = {int(code): code.name.lower() for code in Health}
BOUNDS = {
    side * int(reason): "free" if not reason else f"{reason.name.lower()}_{'upper' if side > 0 else 'lower'}"
    for side in (-1, 1)
    for reason in Reason
}


@dataclass(frozen=True)
class Field:
    """One array of a run, (T, ...) with T the number of ticks.

    Args:
        units: unit in UDUNITS notation; ``"joint"`` and ``"joint/s"`` are the units of each joint.
        long_name: description, for plots and files.
        axes: its axes after time.
        dtype: type of its entries.
        codes: smallest and largest code; None for measured quantities.
        meanings: meaning of each code, unless codes are sums of flags.
        name: attribute of the run and variable of the file.
    """

    units: str
    long_name: str
    axes: tuple[str, ...] = ()
    dtype: npt.DTypeLike = np.float64
    codes: tuple[int, int] | None = None
    meanings: dict[int, str] | None = None
    name: str = ""

    @property
    def kind(self) -> str:
        """NumPy's letter for the kind of its type."""
        return np.dtype(self.dtype).kind

    def shape(self, ticks: int, joints: int) -> tuple[int, ...]:
        """The array's shape for so many ticks and joints."""
        return (ticks, *(AXES[axis] or joints for axis in self.axes))

    def checked(self, value: Any, ticks: int, joints: int) -> npt.NDArray[Any]:
        """A read-only copy; raises InputError if shape or codes are invalid or the type would change numbers."""
        expected = f"numbers of type {np.dtype(self.dtype)}" + (
            "" if self.codes is None else f" from {self.codes[0]} to {self.codes[1]}"
        )
        try:
            given = np.asarray(value)
        except ValueError:
            raise InputError(self.name, _door.describe(value), expected) from None
        if not np.can_cast(given.dtype, self.dtype, "same_kind"):
            raise InputError(self.name, _door.describe(value), expected)
        if self.codes is not None and given.size and not self.codes[0] <= given.min() <= given.max() <= self.codes[1]:
            raise InputError(self.name, f"codes from {given.min()} to {given.max()}", expected)
        if given.shape != self.shape(ticks, joints):
            raise InputError(self.name, f"shape {given.shape}", f"shape {self.shape(ticks, joints)}")
        array = np.array(given, dtype=self.dtype, order="C")
        array.flags.writeable = False
        return array


JOINT, POSE, TWIST = ("joint",), ("row", "column"), ("component",)
RATE, POSE_UNIT, TWIST_UNIT = "joint/s", "m (last column), 1", "m/s, rad/s"
LAST_STATUS = 2 * max(Status) - 1
"""All flags."""
Floats: TypeAlias = npt.NDArray[np.float64]
Codes: TypeAlias = npt.NDArray[np.int8]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Record:
    """The record of a run by tick. All arrays are read-only; T is the number of ticks, n of joints.

    Attributes:
        time: (T,) [s].
        path_time: (T,) [s] time along the motion at which the tick's command was taken: ``time``, or less where the
            scenario's clock follows the arm.
        q: (T, n) true joint values at the tick [rad] or [m].
        measured: (T, n) what the encoders said of them: the controller's input.
        rates: (T, n) rates commanded at the tick [rad/s] or [m/s].
        pose: (T, 4, 4) true pose of the tool (with the task's tool) in the base frame [m].
        target: (T, 4, 4) commanded pose of the tool at the tick [m].
        command: (T, 6) twist [v; w] given to the law, including feedback [m/s, rad/s].
        residual: (T, 6) that twist minus the twist of the rates [m/s, rad/s].
        task_error: (T,) weighted norm of the residual.
        damping: (T,) damping factor, in units of the weighted J Jᵀ.
        scale: (T,) fraction of the commanded twist that was the law's goal.
        status: (T,) bits of Status.
        lower, upper: (T, n) bounds of the rates [rad/s] or [m/s].
        health: (T, n) true Health of each joint.
        known: (T, n) the Health that the controller knew of: later, where a fault has ``known_after``.
        active: (T, n) bound that each joint is at, as ``Solution.active``: 0 or a Reason, negative at the lower bound.
    """

    time: Annotated[Floats, Field("s", "time since the start")]
    path_time: Annotated[Floats, Field("s", "time along the motion of the tick's command")]
    q: Annotated[Floats, Field("joint", "joint values", JOINT)]
    measured: Annotated[Floats, Field("joint", "measured joint values", JOINT)]
    rates: Annotated[Floats, Field(RATE, "commanded joint rates", JOINT)]
    pose: Annotated[Floats, Field(POSE_UNIT, "pose of the tool in the base frame", POSE)]
    target: Annotated[Floats, Field(POSE_UNIT, "commanded pose of the tool, in the base frame", POSE)]
    command: Annotated[Floats, Field(TWIST_UNIT, "twist given to the law, including feedback", TWIST)]
    residual: Annotated[Floats, Field(TWIST_UNIT, "twist given to the law minus that of the rates", TWIST)]
    task_error: Annotated[Floats, Field("1", "weighted norm of the residual")]
    damping: Annotated[Floats, Field("1", "damping factor, in units of the weighted J J'")]
    scale: Annotated[Floats, Field("1", "fraction of the commanded twist that was the goal")]
    status: Annotated[
        npt.NDArray[np.int32], Field("1", "bits of stillreach.Status", dtype=np.int32, codes=(0, LAST_STATUS))
    ]
    lower: Annotated[Floats, Field(RATE, "lower bound of the joint rates", JOINT)]
    upper: Annotated[Floats, Field(RATE, "upper bound of the joint rates", JOINT)]
    health: Annotated[Codes, Field("1", "state of the joints", JOINT, np.int8, (min(HEALTHS), max(HEALTHS)), HEALTHS)]
    known: Annotated[
        Codes, Field("1", "known state of the joints", JOINT, np.int8, (min(HEALTHS), max(HEALTHS)), HEALTHS)
    ]
    active: Annotated[
        Codes,
        Field(
            "1",
            "bound that each joint is at, negative at the lower",
            JOINT,
            np.int8,
            (min(BOUNDS), max(BOUNDS)),
            BOUNDS,
        ),
    ]

    def __len__(self) -> int:
        return len(self.time)

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """The arrays by name."""
        return {entry.name: getattr(self, entry.name) for entry in FIELDS}


FIELDS = tuple(
    replace(hint.__metadata__[0], name=name) for name, hint in get_type_hints(Record, include_extras=True).items()
)


class Stored(NamedTuple):
    """The contents of a run's file: arrays, names and units of the joints, the scenario as text."""

    arrays: dict[str, npt.NDArray[Any]]
    joint: tuple[str, ...]
    joint_unit: tuple[str, ...]
    scenario: str
    interrupted: bool


def empty_record(ticks: int, joints: int) -> dict[str, npt.NDArray[Any]]:
    """Uninitialised arrays for a number of ticks, by name."""
    return {entry.name: np.empty(entry.shape(ticks, joints), dtype=entry.dtype) for entry in FIELDS}


def row_bytes(joints: int) -> int:
    """Memory for each tick [bytes]."""
    return sum(int(np.prod(entry.shape(1, joints))) * np.dtype(entry.dtype).itemsize for entry in FIELDS)
