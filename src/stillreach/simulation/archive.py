"""Runs as NumPy archives (.npz): the same arrays and labels as in a netCDF file, without an extra."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach._files import new_file
from stillreach.errors import InputError
from stillreach.simulation.document import scenario_text
from stillreach.simulation.record import FIELDS, Stored

if TYPE_CHECKING:
    from stillreach.simulation.run import Run

SUFFIX = ".npz"
SIGNATURE = b"PK\x03\x04"
LARGEST = 2**33
"""[bytes] of all arrays; as much as a run may have."""


def is_archive(path: str | os.PathLike[str]) -> bool:
    """Whether a path has the suffix of an archive, or is a file that begins like one."""
    if Path(path).suffix == SUFFIX:
        return True
    if not Path(path).is_file():
        return False
    with Path(path).open("rb") as file:
        return file.read(len(SIGNATURE)) == SIGNATURE


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a run; a file of that name is replaced whole or not at all."""
    stored: dict[str, Any] = {"joint": run.joint_names, "joint_unit": run.joint_units, "interrupted": run.interrupted}
    stored |= {"scenario": scenario_text(run.scenario), **run.arrays()}
    with new_file(path) as file:
        np.savez_compressed(file, **stored)


def read(path: str | os.PathLike[str]) -> Stored:
    """What an archive holds.

    Raises:
        InputError: the file is not a run.
        FileNotFoundError: there is no such file.
    """
    expected = "a file that run.save() wrote"
    if not Path(path).is_file():
        raise FileNotFoundError(f"path: got {os.fspath(path)!r}, expected {expected}; there is none")
    try:
        with zipfile.ZipFile(path) as parts:
            size = sum(part.file_size for part in parts.infolist())
        if size > LARGEST:
            raise InputError(
                "path", f"{os.fspath(path)!r} with {size} bytes of arrays", f"{expected}, at most {LARGEST}"
            )
        with np.load(path, allow_pickle=False) as stored:
            arrays = {entry.name: stored[entry.name] for entry in FIELDS}
            names, units = (tuple(map(str, np.atleast_1d(stored[name]))) for name in ("joint", "joint_unit"))
            found = Stored(arrays, names, units, str(stored["scenario"]), bool(stored["interrupted"]))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("path", repr(os.fspath(path)), f"{expected} ({error})") from error
    other = [name for name, array in arrays.items() if array.dtype.kind not in "iuf"]
    if other:
        raise InputError("path", f"{os.fspath(path)!r} with other things than numbers in {', '.join(other)}", expected)
    return found
