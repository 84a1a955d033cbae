"""Files of runs: netCDF files and NumPy archives with the same contents; tables and rosbags for other tools."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from stillreach._files import file_name
from stillreach.errors import InputError
from stillreach.simulation import archive, columns, netcdf, rosbag
from stillreach.simulation.document import scenario_of
from stillreach.simulation.run import Run

FORMATS: dict[str, Callable[[Run, str | os.PathLike[str]], None]] = {
    ".nc": netcdf.write,
    ".npz": archive.write,
    ".csv": columns.write_csv,
    ".parquet": columns.write_parquet,
    ".rosbag2": rosbag.write,
}
"""Writers by suffix; files of the first two are read as runs again."""


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a run, in the format given by the file's suffix; without one it is netCDF.

    Raises:
        InputError: if no format has that suffix.
    """
    name = Path(file_name("path", path))
    suffix = name.suffix.lower() or ".nc"
    if suffix not in FORMATS:
        raise InputError("path", repr(name.name), f"a name that ends with one of {', '.join(FORMATS)}")
    FORMATS[suffix](run, path)


def read(path: str | os.PathLike[str]) -> Run:
    """Read a run from a file of any name.

    Raises:
        InputError: if the file is not a run.
        FileNotFoundError: if the file is missing.
    """
    name = file_name("path", path)
    stored = (archive if archive.is_archive(path) else netcdf).read(path)
    try:
        run = Run(**stored.arrays, scenario=scenario_of(stored.scenario), interrupted=stored.interrupted)
        for label, own in (("joint", run.joint_names), ("joint_unit", run.joint_units)):
            if getattr(stored, label) != own:
                raise InputError(label, f"{', '.join(getattr(stored, label))}", f"{', '.join(own)}, as in the scenario")
    except InputError as error:
        raise InputError("path", f"{name!r} with {error.argument}: {error.got}", netcdf.EXPECTED) from None
    return run
