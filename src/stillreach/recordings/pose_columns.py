"""Poses in tables of text: a place a row, and perhaps an attitude."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stillreach._door import FloatArray
from stillreach._messages import one_of
from stillreach._rotations import exp, from_quaternions, from_rpy
from stillreach._units import ANGLES, LENGTHS
from stillreach.errors import InputError
from stillreach.recordings.samples import unit_of
from stillreach.simulation.pose_table import ATTITUDES, POSITION
from stillreach.simulation.table import read_table

COLUMNS = "x, y, z, and none or all of qw, qx, qy, qz or roll, pitch, yaw or rx, ry, rz"


def read_poses(
    path: Path, *, length: str | None = None, angle: str | None = None
) -> tuple[FloatArray, bool, list[int]]:
    """Poses of a table with column names in the first line; further columns, such as a time, are not read.

    Args:
        path: the file, as for ``PoseTable.from_csv``.
        length: unit of columns that do not say theirs, as ``x [mm]`` does; None: m.
        angle: the same of angles; None: the file has to say it.

    Returns:
        (N, 4, 4) [m], whether the file has attitudes (where it has none, they are the identity), and the line of each.

    Raises:
        InputError: if the file is missing or not such a table; the message names the line and the column.
    """
    lines: list[int] = []
    columns, rows = read_table(path, _wanted, COLUMNS, others=True, lines=lines)
    place = {unit_of(column)[0]: k for k, column in enumerate(columns)}
    attitude = _attitude(columns)
    poses = np.tile(np.eye(4), (len(rows), 1, 1))
    for k, name in enumerate(POSITION):
        poses[:, k, 3] = rows[:, place[name]] * _scale(path, columns[place[name]], length or "m", LENGTHS)
    if attitude == "quaternion":
        entries = rows[:, [place[name] for name in ATTITUDES[attitude]]]
        for line, entry in zip(lines, entries, strict=True):
            if not entry.any():
                raise InputError(f"{path}:{line}", "0 in the columns qw, qx, qy, qz", "a quaternion, not all 0")
        poses[:, :3, :3] = from_quaternions(str(path), entries)
    elif attitude:
        turns = np.column_stack(
            [rows[:, k] * _scale(path, columns[k], angle, ANGLES) for k in (place[n] for n in ATTITUDES[attitude])]
        )
        poses[:, :3, :3] = {"rpy": from_rpy, "vector": exp}[attitude](turns)
    return poses, attitude is not None, lines


def _attitude(columns: list[str]) -> str | None:
    names = {unit_of(column)[0] for column in columns}
    return next((kind for kind, wanted in ATTITUDES.items() if wanted[0] in names), None)


def _wanted(columns: list[str]) -> set[str]:
    """The columns that are read, with their units; a missing one by its name alone, which no file has then."""
    bare = {unit_of(column)[0]: column for column in columns}
    attitude = _attitude(columns)
    return {bare.get(name, name) for name in (*POSITION, *(ATTITUDES[attitude] if attitude else ()))}


def _scale(path: Path, column: str, unit: str | None, units: dict[str, float]) -> float:
    """The size of a column's unit, which its heading or the caller names."""
    own = unit_of(column)[1] or unit
    if own is None:
        raise InputError("--angle", f"none, and {path.name} does not say the unit of {column}", one_of(units))
    if own not in units:
        raise InputError(f"{path}:1", f"the unit {own!r} in column {column}", one_of(units))
    return units[own]
