"""The files that a command writes, and notes about missing extras."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stillreach._files import new_file
from stillreach.errors import MissingExtraError

RECORDS = (".nc", ".npz")
"""Suffixes of records; the second works without an extra."""

if TYPE_CHECKING:
    from stillreach.simulation import Run


def folder_for(out: Path | None, scenario: str) -> Path:
    """The output folder of a command, created if missing.

    Args:
        out: the folder; None: out/NAME.
        scenario: file or name of the scenario.
    """
    folder = Path("out") / (re.sub(r"[^\w.-]+", "-", Path(scenario).stem) or "run") if out is None else out
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def write_record(run: Run, folder: Path, stem: str = "run") -> Path:
    """Write a run as netCDF, or as a NumPy archive, with a note, if the extra is missing.

    An earlier record in the other format is removed.

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
    """Remove files of an earlier run that this one does not replace."""
    for path in paths:
        if path.is_file():
            path.unlink()


def write_summary(found: dict[str, Any], folder: Path, name: str = "summary.json") -> Path:
    """Write the output of --json."""
    from stillreach.cli._terminal import plain

    path = folder / name
    text = json.dumps(plain(found), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    with new_file(path) as file:
        file.write(text.encode())
    return path


def write_page(wanted: bool | None, path: Path, made: Callable[[], str]) -> list[Path]:
    """Write a page, if wanted.

    Args:
        wanted: True: raise without its extra; None: print a note instead.
        path: the file.
        made: returns its text.

    Returns:
        The file, or none.

    Raises:
        MissingExtraError: if ``wanted`` is True and the extra is missing.
    """
    return _if_wanted(wanted, path, lambda: made().encode())


def picture(wanted: bool | None, path: Path, draw: Callable[[], Any]) -> list[Path]:
    """Draw and save a figure, if wanted.

    Args:
        wanted: True: raise without matplotlib; None: print a note instead.
        path: the file.
        draw: makes the figure.

    Returns:
        The file, or none.

    Raises:
        MissingExtraError: if ``wanted`` is True and matplotlib is not installed.
    """

    def drawn() -> bytes:
        from stillreach.show.style import matplotlib_or_error

        matplotlib_or_error("a picture of a run").use("agg")  # without a window
        file = BytesIO()
        draw().savefig(file, format="png", dpi=130, pil_kwargs={"compress_level": 2})
        return file.getvalue()

    return _if_wanted(wanted, path, drawn)


def _if_wanted(wanted: bool | None, path: Path, made: Callable[[], bytes]) -> list[Path]:
    """Writes a file whose making needs an extra; a note where that is missing and nobody asked for it."""
    from stillreach.cli._terminal import note

    if wanted is False:
        return []
    try:
        content = made()
    except MissingExtraError as missing:
        if wanted:
            raise
        note(f"stillreach: {missing} (for {path.name})")
        return []
    with new_file(path) as file:
        file.write(content)
    return [path]
