"""The files that a command writes, and what it says where an extra for them is missing."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stillreach._files import new_file
from stillreach.errors import MissingExtraError

RECORDS = (".nc", ".npz")
"""Suffixes of records; the second needs no extra."""

if TYPE_CHECKING:
    from stillreach.simulation import Run


def folder_for(out: Path | None, scenario: str) -> Path:
    """The folder that a command writes to, made where it is not there yet.

    Args:
        out: as asked for; None is out/NAME.
        scenario: file or name of the scenario.
    """
    folder = Path("out") / (re.sub(r"[^\w.-]+", "-", Path(scenario).stem) or "run") if out is None else out
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def write_record(run: Run, folder: Path, stem: str = "run") -> Path:
    """Write a run as netCDF, or as NumPy's archive where the extra for that is missing (and say so).

    A record of an earlier run in the other of these formats is removed.

    Returns:
        The file.
    """
    from stillreach.cli._terminal import note

    path, other = (folder / f"{stem}{suffix}" for suffix in RECORDS)
    try:
        run.save(path)
    except MissingExtraError as missing:
        path, other = other, path
        note(f"stillreach: {missing} (for {other.name}; {path.name} holds the same)")
        run.save(path)
    remove_older(other)
    return path


def remove_older(*paths: Path) -> None:
    """Remove files that an earlier run left, so that they do not stand beside files of this one."""
    for path in paths:
        if path.is_file():
            path.unlink()


def write_summary(found: dict[str, Any], folder: Path, name: str = "summary.json") -> Path:
    """Write what --json prints."""
    from stillreach.cli._terminal import plain

    path = folder / name
    text = json.dumps(plain(found), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    with new_file(path) as file:
        file.write(text.encode())
    return path


def picture(wanted: bool | None, path: Path, draw: Callable[[], Any]) -> list[Path]:
    """Draw and save a picture, as asked for.

    Args:
        wanted: True: without matplotlib that is an error; None: without it there is a note and no picture.
        path: the file.
        draw: makes the figure.

    Returns:
        The file, if there is one.

    Raises:
        MissingExtraError: a picture was asked for, and matplotlib is not installed.
    """
    from stillreach.cli._terminal import note
    from stillreach.show.style import matplotlib_or_error

    if wanted is False:
        return []
    try:
        matplotlib_or_error("a picture of a run").use("agg")  # opens no window
        figure = draw()
    except MissingExtraError as missing:
        if wanted:
            raise
        note(f"stillreach: {missing} (for {path.name})")
        return []
    with new_file(path) as file:
        figure.savefig(file, format="png", dpi=130, pil_kwargs={"compress_level": 2})
    return [path]
