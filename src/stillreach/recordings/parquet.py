"""Recordings in Parquet files: columns by joint name, or a LeRobot dataset's ``observation.state``."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.errors import InputError, MissingExtraError
from stillreach.recordings.columns import time_column
from stillreach.recordings.samples import Samples, column_unit, places

STATE, EPISODE = "observation.state", "episode_index"
INFO = Path("meta") / "info.json"
"""Where a LeRobot dataset names the entries of its state."""


def read(file: Path, joints: Sequence[str], named: Mapping[str, str], episode: int | None) -> Samples:
    """Read a Parquet file.

    Raises:
        InputError: if it is not one, or a joint is missing.
        MissingExtraError: if pyarrow is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise MissingExtraError("recordings", f"reading {file.name}") from error
    try:
        table = parquet.read_table(file)
    except (pyarrow.ArrowInvalid, OSError) as error:
        raise InputError("path", f"{file.name!r}, {str(error).splitlines()[0][:100]}", "a Parquet file") from None
    columns = list(table.column_names)
    table = _of_episode(table, columns, episode)
    place, scale = time_column(file.name, columns)
    time = _times(table.column(place), scale)
    if STATE in columns:
        rows = np.array(table.column(STATE).to_pylist(), dtype=float)
        names = _state_names(file, rows.shape[1] if rows.ndim == 2 else 0)
        found = places(file.name, joints, names, named)
        return Samples(time, rows[:, found], tuple(column_unit(names[k]) for k in found))
    found = places(file.name, joints, columns, named)
    try:
        rows = np.stack([np.asarray(table.column(k).to_numpy(), dtype=float) for k in found], axis=1)
    except (TypeError, ValueError):
        raise InputError("path", f"{file.name!r} with columns that hold no numbers", "numbers for each joint") from None
    return Samples(time, rows, tuple(column_unit(columns[k]) for k in found))


def _of_episode(table: Any, columns: list[str], episode: int | None) -> Any:
    """The rows of one episode of a dataset."""
    if EPISODE not in columns:
        if episode is not None:
            raise InputError("episode", repr(episode), f"none: the file has no column {EPISODE}")
        return table
    numbers = table.column(EPISODE).to_numpy()
    known = np.unique(numbers)
    if episode is None and len(known) == 1:
        return table
    if episode is None or episode not in known:
        got = f"none of {len(known)} episodes" if episode is None else repr(episode)
        raise InputError("episode", got, f"one of {known[0]} … {known[-1]}" if len(known) > 1 else f"{known[0]}")
    return table.filter(numbers == episode)


def _times(column: Any, scale: float) -> FloatArray:
    """[s] from the first time; also of columns of dates."""
    values = column.to_numpy()
    if np.issubdtype(values.dtype, np.datetime64):
        return np.asarray((values - values[0]) / np.timedelta64(1, "ns"), dtype=float) * 1e-9
    try:
        return np.asarray((values - values[0]) * scale, dtype=float)
    except (TypeError, IndexError):
        raise InputError("time", f"a column of {values.dtype}", "numbers or dates, at least two") from None


def _state_names(file: Path, count: int) -> list[str]:
    """Names of the entries of the state, from the dataset's own file."""
    info = next((folder / INFO for folder in file.absolute().parents if (folder / INFO).is_file()), None)
    expected = f"{count} names of features['{STATE}'] in {INFO} of the dataset"
    if info is None:
        raise InputError("path", f"{file.name!r} outside of a dataset", expected)
    try:
        names = json.loads(info.read_text(encoding="utf-8"))["features"][STATE]["names"]
    except (ValueError, KeyError, TypeError, OSError):
        raise InputError("path", f"{info.name} without such names", expected) from None
    if isinstance(names, dict):  # {"motors": [...]}
        names = [name for part in names.values() for name in part]
    if not isinstance(names, list) or len(names) != count or not all(isinstance(name, str) for name in names):
        raise InputError("path", f"{info.name} with other names", expected)
    return list(names)
