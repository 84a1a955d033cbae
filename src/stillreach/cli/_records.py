"""The files that a command writes, and what it says where an extra for them is missing."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stillreach._files import new_file
from stillreach.errors import MissingExtraError

if TYPE_CHECKING:
    from stillreach.simulate import Run


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

    Returns:
        The file.
    """
    from stillreach.cli._terminal import note

    path = folder / f"{stem}.nc"
    try:
        run.save(path)
    except MissingExtraError as missing:
        path = folder / f"{stem}.npz"
        note(f"stillreach: {missing} (for {stem}.nc; {stem}.npz holds the same arrays)")
        _write_arrays(run, path)
    return path


def write_summary(found: dict[str, Any], folder: Path, stem: str = "summary") -> Path:
    """Write what --json prints."""
    from stillreach.cli._terminal import plain

    path = folder / f"{stem}.json"
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

    if wanted is False:
        return []
    try:
        figure = draw()
    except MissingExtraError as missing:
        if wanted:
            raise
        note(f"stillreach: {missing} (for {path.name})")
        return []
    with new_file(path) as file:
        figure.savefig(file, format="png", dpi=130, pil_kwargs={"compress_level": 2})
    return [path]


def _write_arrays(run: Run, path: Path) -> None:
    import numpy as np

    from stillreach.simulate.fields import FIELDS

    arrays = {field.name: getattr(run, field.name) for field in FIELDS}
    with new_file(path) as file:
        np.savez_compressed(file, joint=run.joint_names, joint_unit=run.joint_units, **arrays)
