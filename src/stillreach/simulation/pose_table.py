"""A course from a table of poses, for example a file."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._forms import Text
from stillreach._kinds import Key
from stillreach._messages import short
from stillreach._packages import WHERE, file_at
from stillreach._reading import Reading
from stillreach._rotations import exp, from_quaternions, from_rpy, log
from stillreach.errors import InputError
from stillreach.simulation.course import RELATIVE_KEY, Course, Legs, turned_and_shifted
from stillreach.simulation.profile import RAMP
from stillreach.simulation.shapes import rising, set_fields
from stillreach.simulation.table import read_table

JUMP = 1e-3
"""[m, rad] how far a table's first pose may be from where the tool is at that time."""

POSITION = ("x", "y", "z")
ATTITUDES = {"quaternion": ("qw", "qx", "qy", "qz"), "rpy": ("roll", "pitch", "yaw"), "vector": ("rx", "ry", "rz")}
COLUMNS = "time, x, y, z, and none or all of qw, qx, qy, qz or roll, pitch, yaw or rx, ry, rz"


@dataclass(frozen=True, eq=False)
class PoseTable(Course):
    """Poses at given times; between them the point moves on straight lines, the attitude by the shortest turn.

    Args:
        times: (K,) [s] since the beginning, rising, the first at least 0. Where it is above 0 the course leads to the
            first pose from wherever the tool is; a table from 0 on begins where the tool is.
        points: (K, 3) [m] in the base frame.
        orientations: (K, 3, 3) rotation matrices; None keeps the attitude.
        relative: points are shifts and orientations are turns from the pose at the beginning, along base axes.

    Raises:
        InputError: if an argument is invalid.
    """

    word = "pose-table"

    times: FloatArray
    points: FloatArray
    orientations: FloatArray | None
    relative: bool
    duration: float

    def __init__(
        self,
        times: npt.ArrayLike,
        points: npt.ArrayLike,
        *,
        orientations: npt.ArrayLike | None = None,
        relative: bool = False,
    ) -> None:
        places = _door.matrix("points", points, (None, 3))
        moments = rising("times", times, len(places))
        if len(moments) == 0 or moments[0] < 0.0 or moments[-1] <= 0.0:
            span = f"{moments[0]:g} to {moments[-1]:g} s" if len(moments) else "no row"
            raise InputError("times", span, "times from 0 on that end above 0")
        turns = None if orientations is None else _rotations(orientations, len(places))
        set_fields(
            self, times=moments, points=places, orientations=turns, relative=relative, duration=float(moments[-1])
        )

    @classmethod
    def from_csv(
        cls, path: str | os.PathLike[str], *, relative: bool = False, length: float = 1.0, angle: float = 1.0
    ) -> Self:
        """Read a table whose first line names its columns: time [s], x, y, z, and an attitude or none.

        An attitude is a quaternion (qw, qx, qy, qz), roll, pitch, yaw as URDF has them, or a rotation vector
        (rx, ry, rz). The first line also defines the separator: commas, semicolons, tabs, bars or spaces.
        Numbers may have a decimal comma where commas do not separate them.

        Args:
            path: the file, UTF-8 or, with a byte order mark, UTF-16.
            relative: as for PoseTable.
            length: [m] unit of x, y, z in the file.
            angle: [rad] unit of its angles.

        Raises:
            InputError: the file is missing or not such a table; the message names the line.
        """
        columns, rows = read_table(Path(path), _wanted, COLUMNS)
        place = {name: k for k, name in enumerate(columns)}
        attitude = _attitude(columns)
        turns = None
        if attitude:
            entries = rows[:, [place[name] for name in ATTITUDES[attitude]]]
            turns = (
                from_quaternions(str(path), entries)
                if attitude == "quaternion"
                else {"rpy": from_rpy, "vector": exp}[attitude](entries * angle)
            )
        points = rows[:, [place[name] for name in POSITION]] * length
        return cls(rows[:, place["time"]], points, orientations=turns, relative=relative)

    @classmethod
    def keys(cls) -> dict[str, Key]:
        """Of a table in a file of its own."""
        relative = RELATIVE_KEY["key"]
        file = Key(Text(), f"A CSV file with columns {COLUMNS}, {WHERE}")
        return {"file": file, "relative": Key(relative.form, relative.text, False)}

    @classmethod
    def read(cls, values: dict[str, Any], reading: Reading) -> Self:
        """From that file."""
        try:
            path = file_at(values.pop("file"), reading.folder)
            return cls.from_csv(path, **values, length=reading.length, angle=reading.angle)
        except InputError as error:
            name = "" if error.argument == "package" else f"{short(Path(error.argument).name)}: "
            raise InputError("file", f"{name}{error.got}", error.expected) from None

    def plan(self, T_start: FloatArray) -> Legs:
        """The legs from a pose (4, 4) [m].

        Raises:
            InputError: the table begins at time 0 at another pose.
        """
        moves = np.tile(np.eye(4), (len(self.points), 1, 1))
        moves[:, :3, 3] = self.points
        if self.orientations is not None:
            moves[:, :3, :3] = self.orientations
        elif not self.relative:
            moves[:, :3, :3] = T_start[:3, :3]
        poses = turned_and_shifted(T_start, moves) if self.relative else moves
        if self.times[0] > 0.0:
            return Legs(np.concatenate([[0.0], self.times]), np.concatenate([T_start[None], poses]), "constant", RAMP)
        shift = float(np.linalg.norm(poses[0, :3, 3] - T_start[:3, 3]))
        turn = float(np.linalg.norm(log((poses[0, :3, :3] @ T_start[:3, :3].T)[None])))
        if max(shift, turn) > JUMP:
            raise InputError(
                "times",
                f"a first pose at time 0 that is {shift:.3g} m and {turn:.3g} rad from where the tool is",
                "the tool's pose, a later time to reach the first pose, or relative=True",
            )
        return Legs(self.times, poses, "constant", RAMP)


def _rotations(value: npt.ArrayLike, count: int) -> FloatArray:
    """(count, 3, 3) rotation matrices; InputError otherwise."""
    R = np.asarray(value)
    if R.shape != (count, 3, 3):
        raise InputError("orientations", _door.describe(value), f"rotation matrices ({count}, 3, 3)")
    turns = np.empty(R.shape)
    for k, matrix in enumerate(R):
        T = np.eye(4)
        T[:3, :3] = _door.matrix(f"orientations[{k}]", matrix, (3, 3))
        turns[k] = _door.pose(f"orientations[{k}]", T)[:3, :3]
    return _door.frozen(turns)


def _attitude(columns: list[str]) -> str | None:
    """The kind of attitude that columns give."""
    return next((kind for kind, names in ATTITUDES.items() if names[0] in columns), None)


def _wanted(columns: list[str]) -> set[str]:
    """The columns that a table with some of them must have."""
    attitude = _attitude(columns)
    return {"time", *POSITION, *(ATTITUDES[attitude] if attitude else ())}
