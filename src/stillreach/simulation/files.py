"""Files of runs: netCDF files and NumPy archives hold the same."""

from __future__ import annotations

import os

from stillreach._files import file_name
from stillreach.errors import InputError
from stillreach.simulation import archive, netcdf
from stillreach.simulation.document import scenario_of
from stillreach.simulation.run import Run


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a run, in the format of the file's name."""
    (archive if file_name("path", path).endswith(archive.SUFFIX) else netcdf).write(run, path)


def read(path: str | os.PathLike[str]) -> Run:
    """The run that a file holds, whatever its name.

    Raises:
        InputError: the file is not a run.
        FileNotFoundError: there is no such file.
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
