"""Recordings in tables of text: a column of times and one of each joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stillreach._messages import listed
from stillreach.errors import InputError
from stillreach.recordings.samples import Samples, column_unit, places, unit_of
from stillreach.simulation.table import read_table

TIMES = {"time": 1.0, "t": 1.0, "timestamp": 1.0, "stamp": 1.0, "time_s": 1.0, "t_s": 1.0, "secs": 1.0, "seconds": 1.0}
TIMES |= {"time_ms": 1e-3, "t_ms": 1e-3, "timestamp_ms": 1e-3, "time_us": 1e-6, "timestamp_us": 1e-6}
TIMES |= {"time_ns": 1e-9, "t_ns": 1e-9, "timestamp_ns": 1e-9}
"""Names of the column of times, and its unit [s]."""
SECONDS = {"": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}


def time_column(source: str, columns: Sequence[str]) -> tuple[int, float]:
    """The place of the column of times, and its unit [s].

    Raises:
        InputError: if there is none.
    """
    for place, column in enumerate(columns):
        name, unit = unit_of(column)
        if name.lower() in TIMES:
            if unit not in SECONDS:
                raise InputError("time", f"the unit {unit!r} of {column!r}", "one of s, ms, us, ns")
            return place, SECONDS[unit] if unit else TIMES[name.lower()]
    raise InputError("time", f"no column of times in {source}, which has {listed(columns)}", "a column 'time' [s]")


def read(file: Path, joints: Sequence[str], named: Mapping[str, str], option: Any) -> Samples:
    """Read a table of text.

    Raises:
        InputError: if it is not one, or a joint is missing.
    """
    header: list[str] = []

    def wanted(columns: list[str]) -> set[str]:
        header[:] = columns
        time, _ = time_column(file.name, columns)
        return {columns[place] for place in [time, *places(file.name, joints, columns, named)]}

    kept, rows = read_table(file, wanted, "a column of times and one of each joint", others=True)
    time, scale = time_column(file.name, kept)
    found = places(file.name, joints, kept, named)
    units = tuple(column_unit(kept[place]) for place in found)
    return Samples((rows[:, time] - rows[:1, time]) * scale, rows[:, found], units, "row of numbers")
