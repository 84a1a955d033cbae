"""Poses of a CSV file, as commands take them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach._door import FloatArray

RowsOption = Annotated[
    str | None,
    typer.Option(
        help="The task: pose, position, orientation, or components like vx,vy,wz. By default pose, or position for "
        "a file without attitudes."
    ),
]
LengthOption = Annotated[
    str | None, typer.Option(metavar="UNIT", help="m (default), cm, mm, in or ft: of a file that does not say it.")
]
AngleOption = Annotated[
    str | None, typer.Option(metavar="UNIT", help="rad or deg: of a file that does not say its unit.")
]


class Given(NamedTuple):
    """Poses of a file.

    Args:
        poses: (N, 4, 4) [m].
        attitudes: whether the file has them.
        lines: of each.
    """

    poses: FloatArray
    attitudes: bool
    lines: list[int]


def given_poses(path: Path | None, *, length: str | None, angle: str | None) -> Given | None:
    """The poses of a file; None without one.

    Raises:
        InputError: if the file or a unit is invalid.
    """
    from stillreach._messages import one_of
    from stillreach._units import ANGLES, LENGTHS
    from stillreach.recordings.pose_columns import read_poses

    for name, unit, units in (("--length", length, LENGTHS), ("--angle", angle, ANGLES)):
        if unit is not None and path is None:
            raise InputError(name, repr(unit), "a file of poses with it")
        if unit is not None and unit not in units:
            raise InputError(name, repr(unit), one_of(units, unit))
    return None if path is None else Given(*read_poses(path, length=length, angle=angle))


def rows_for(rows: str | None, given: Given | None) -> str:
    """The rows of the task: those that a command names, or those that the file has."""
    return rows or ("position" if given is not None and not given.attitudes else "pose")


def ranges(numbers: list[int]) -> str:
    """``2, 5-9, 12`` of rising numbers; ``-`` of none."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1][1:] = [number]
        else:
            runs.append([number])
    return ", ".join("-".join(map(str, run)) for run in runs) or "-"
