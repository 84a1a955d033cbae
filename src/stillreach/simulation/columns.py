"""A run as columns with a name and a unit each, and CSV and Parquet files of them."""

from __future__ import annotations

import io
import os
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stillreach._door import TWIST
from stillreach._files import new_file
from stillreach._rotations import to_quaternions
from stillreach.errors import MissingExtraError
from stillreach.simulation.record import BOUNDS, FIELDS, HEALTHS, JOINT, POSE, RATE_UNITS, Field

if TYPE_CHECKING:
    from stillreach.simulation.run import Run

DIGITS = "%.17g"
"""Numbers come back to the last bit."""
QUATERNION = ("qw", "qx", "qy", "qz")


class Column(NamedTuple):
    """A column: its name, its unit (empty for none), and its values (T,)."""

    name: str
    unit: str
    values: np.ndarray

    @property
    def head(self) -> str:
        """``panda_joint1 [rad]``."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def columns(run: Run) -> list[Column]:
    """All arrays of a run. The true joint positions have the joints' own names, so that a table is a recording, too."""
    made = [Column("time", "s", run.time), *_of(run, next(entry for entry in FIELDS if entry.name == "q"))]
    for entry in FIELDS:
        if entry.name not in ("time", "q"):
            made += _of(run, entry)
    return made


def _of(run: Run, entry: Field) -> list[Column]:
    """The columns of an array."""
    values = getattr(run, entry.name)
    if entry.axes == JOINT:
        return [_of_joint(run, entry, joint) for joint in range(run.scenario.arm.n)]
    if entry.axes == POSE:
        places = [Column(f"{entry.name}.{axis}", "m", values[:, k, 3]) for k, axis in enumerate("xyz")]
        turns = to_quaternions(values[:, :3, :3])
        return places + [Column(f"{entry.name}.{name}", "", turns[:, k]) for k, name in enumerate(QUATERNION)]
    if entry.axes:
        units = ["m/s"] * 3 + ["rad/s"] * 3
        return [
            Column(f"{entry.name}.{name}", unit, values[:, k])
            for k, (name, unit) in enumerate(zip(TWIST.names, units, strict=True))
        ]
    return [Column(entry.name, "" if entry.units == "1" else entry.units, values)]


def _of_joint(run: Run, entry: Field, joint: int) -> Column:
    values, own = getattr(run, entry.name)[:, joint], run.joint_units[joint]
    name = run.joint_names[joint] + ("" if entry.name == "q" else f".{entry.name}")
    if entry.codes is not None:
        words = {"health": HEALTHS, "known": HEALTHS, "active": BOUNDS}[entry.name]
        return Column(name, "", np.array([words[int(code)] for code in values]))
    return Column(name, own if entry.units == "joint" else RATE_UNITS[own], values)


def write_csv(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a table with a line of names and units, and a line for each tick."""
    made = columns(run)
    text = io.StringIO()
    text.write(",".join(_quoted(column.head) for column in made) + "\n")
    cells = [
        column.values.tolist()
        if column.values.dtype.kind in "U"
        else [_number(value) for value in column.values.tolist()]
        for column in made
    ]
    for row in zip(*cells, strict=True):
        text.write(",".join(row) + "\n")
    with new_file(path) as file:
        file.write(text.getvalue().encode())


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else DIGITS % value


def _quoted(name: str) -> str:
    """A name as CSV has it."""
    return '"' + name.replace('"', '""') + '"' if any(mark in name for mark in ',"\n\r') else name


def write_parquet(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a Parquet file: a column each, with its unit in the name and in its metadata.

    Raises:
        MissingExtraError: if pyarrow is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise MissingExtraError("recordings", "run.save() to a Parquet file") from error
    made = columns(run)
    arrays: list[Any] = [pyarrow.array(column.values) for column in made]
    fields = [
        pyarrow.field(column.head, array.type, metadata={"unit": column.unit})
        for column, array in zip(made, arrays, strict=True)
    ]
    with new_file(path) as file:
        parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields)), file)
