"""Runs as xarray Datasets and netCDF files.

The packages for it are an extra; they are imported here, inside the functions, and nowhere else.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach.errors import InputError, MissingExtraError
from stillreach.simulate.fields import FIELDS, HEALTH, RATE_UNITS, TWIST_COMPONENTS, Field
from stillreach.status import Status

if TYPE_CHECKING:
    import xarray

    from stillreach.simulate.run import Run


def to_dataset(run: Run) -> xarray.Dataset:
    """The run as a Dataset with dimensions time, joint, row, column and component."""
    xarray = _xarray("run.to_xarray()")
    variables = {
        entry.name: (("time", *entry.axes), getattr(run, entry.name), _attributes(entry, run.joint_units))
        for entry in FIELDS
    }
    coordinates = {
        "joint": ("joint", np.array(run.joint_names, dtype=object), {"long_name": "joint"}),
        "joint_unit": ("joint", np.array(run.joint_units, dtype=object), {"long_name": "unit of the joint's value"}),
        "component": ("component", np.array(TWIST_COMPONENTS, dtype=object), {"long_name": "component of a twist"}),
        "time": variables.pop("time"),
    }
    return xarray.Dataset(variables, coordinates, attrs=dict(run.attrs))


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a run beside its final place, then move it there, so that whoever stops this leaves the old file whole."""
    dataset = _to_file(to_dataset(run))
    target = Path(path)
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".part", dir=target.parent)
    os.close(handle)
    part = Path(name)
    try:
        dataset.to_netcdf(part, engine="h5netcdf")
        _as_new_file(part)
        part.replace(target)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The arguments of the Run that a file holds."""
    xarray = _xarray("Run.load()")
    if not Path(path).is_file():
        raise FileNotFoundError(f"path: got {os.fspath(path)!r}, expected a netCDF file that run.save() wrote; there is none")
    try:
        dataset = xarray.load_dataset(path, engine="h5netcdf")
    except (OSError, ValueError, KeyError) as error:
        raise InputError("path", repr(os.fspath(path)), f"a netCDF file that run.save() wrote ({error})") from error
    missing = [name for name in (*(entry.name for entry in FIELDS), "joint", "joint_unit") if name not in dataset.variables]
    if missing:
        raise InputError("path", f"{os.fspath(path)!r} without {', '.join(missing)}", "a file that run.save() wrote")
    values: dict[str, Any] = {entry.name: dataset[entry.name].values for entry in FIELDS}
    values["joint_names"] = tuple(map(str, dataset["joint"].values))
    values["joint_units"] = tuple(map(str, dataset["joint_unit"].values))
    values["attrs"] = {str(name): _plain(value) for name, value in dataset.attrs.items()}
    return values


def _attributes(entry: Field, joint_units: tuple[str, ...]) -> dict[str, Any]:
    """Units, long name and the meaning of codes, as the CF conventions write them."""
    units = {"joint": joint_units, "joint/s": tuple(RATE_UNITS[unit] for unit in joint_units)}.get(entry.units)
    text = entry.units if units is None else ", ".join(dict.fromkeys(units))
    attributes: dict[str, Any] = {"long_name": entry.long_name, "units": text}
    if entry.name == "status":
        flags = [flag for flag in Status if flag]
        attributes["flag_masks"] = np.array([flag.value for flag in flags], dtype=np.int32)
        attributes["flag_meanings"] = " ".join(str(flag.name) for flag in flags)
    if entry.name == "health":
        attributes["flag_values"] = np.arange(len(HEALTH), dtype=np.int8)
        attributes["flag_meanings"] = " ".join(HEALTH)
    return attributes


def _to_file(dataset: xarray.Dataset) -> xarray.Dataset:
    """The dataset as it goes to a file: no fill values (infinite bounds are data), time as plain seconds."""
    for name in dataset.variables:
        dataset[name].encoding["_FillValue"] = None
    return dataset


def _as_new_file(part: Path) -> None:
    """On the disk before it is moved, and with the rights of an ordinary new file: mkstemp makes private ones."""
    with part.open("rb") as file:
        os.fsync(file.fileno())
    mask = os.umask(0)
    os.umask(mask)
    part.chmod(0o666 & ~mask)


def _plain(value: Any) -> Any:
    """An attribute as the Python number or text that was saved."""
    return value.item() if isinstance(value, np.generic) else value


def _xarray(purpose: str) -> Any:
    """The xarray module, if all that a netCDF file needs is there."""
    try:
        import h5netcdf  # noqa: F401
        import h5py  # noqa: F401
        import xarray
    except ImportError as error:
        raise MissingExtraError("netcdf", purpose) from error
    return xarray
