"""Runs as netCDF files and as xarray Datasets.

The packages for it are an extra; they are imported here, inside the functions, and nowhere else. Files are written
and read with h5netcdf alone, which starts in a tenth of the time that xarray takes; xarray opens them like any other
netCDF file.
"""

from __future__ import annotations

import os
import signal
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach.errors import InputError, MissingExtraError
from stillreach.simulate.fields import AXES, CODES, FIELDS, RATE_UNITS, TWIST_COMPONENTS, Field
from stillreach.status import Status

if TYPE_CHECKING:
    import xarray

    from stillreach.simulate.run import Run

LABELS = {
    "joint": ("joint", "joint"),
    "joint_unit": ("joint", "unit of the joint's value"),
    "component": ("component", "component of a twist"),
}
"""Axis and long name of each variable that holds texts."""


def to_dataset(run: Run) -> xarray.Dataset:
    """The run as a Dataset with dimensions time, joint, row, column and component."""
    try:
        import xarray
    except ImportError as error:
        raise MissingExtraError("netcdf", "run.to_xarray()") from error
    variables = {
        entry.name: (("time", *entry.axes), getattr(run, entry.name), _attributes(entry, run.joint_units))
        for entry in FIELDS
        if entry.name != "time"
    }
    coordinates = {
        name: (axis, np.array(texts, dtype=object), {"long_name": LABELS[name][1]})
        for (name, texts), (axis, _) in zip(_texts(run).items(), LABELS.values(), strict=True)
    }
    time = ("time", run.time, _attributes(FIELDS[0], run.joint_units))
    return xarray.Dataset(variables, {"time": time, **coordinates}, attrs=dict(run.attrs))


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a run; a file of that name is replaced whole or not at all."""
    h5netcdf = _h5netcdf("run.save()")
    with replacing(path) as part, h5netcdf.File(part, "w") as file:
        _fill(file, run)


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A file to write beside its final place, moved there at the end: whoever stops this leaves the old file whole."""
    target = Path(path)
    with _interrupts_wait():
        try:
            handle, name = tempfile.mkstemp(prefix=f".{target.name}.", suffix=".part", dir=target.parent)
        except OSError as error:
            error.filename = str(target)  # what the caller knows
            raise
        os.close(handle)
        part = Path(name)
        try:
            yield part
            _as_new_file(part)
            part.replace(target)
        except BaseException:
            part.unlink(missing_ok=True)
            raise


@contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Ctrl-C counts once the file stands: HDF5 complains of a file that is broken off half written."""
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or handler is None:
        yield  # signals are the main thread's; a handler that is not Python's cannot be put back
        return
    came = []
    signal.signal(signal.SIGINT, lambda *_: came.append(True))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
    if came:
        signal.raise_signal(signal.SIGINT)


def read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The arguments of the Run that a file holds."""
    h5netcdf = _h5netcdf("Run.load()")
    expected = "a netCDF file that run.save() wrote"
    if not Path(path).is_file():
        raise FileNotFoundError(f"path: got {os.fspath(path)!r}, expected {expected}; there is none")
    try:
        with h5netcdf.File(path, "r") as file:
            arrays = {name: np.asarray(variable[...]) for name, variable in file.variables.items()}
            attrs = {str(name): _plain(value) for name, value in file.attrs.items()}
    except (OSError, ValueError, KeyError) as error:
        raise InputError("path", repr(os.fspath(path)), f"{expected} ({error})") from error
    missing = [name for name in (*(entry.name for entry in FIELDS), "joint", "joint_unit") if name not in arrays]
    if missing:
        raise InputError("path", f"{os.fspath(path)!r} without {', '.join(missing)}", expected)
    values: dict[str, Any] = {entry.name: arrays[entry.name] for entry in FIELDS}
    values["joint_names"] = tuple(_text(name) for name in arrays["joint"])
    values["joint_units"] = tuple(_text(unit) for unit in arrays["joint_unit"])
    return {**values, "attrs": attrs}


def _fill(file: Any, run: Run) -> None:
    """Write dimensions, variables and attributes into an open, empty file."""
    import h5py

    sizes = {axis: size or len(run.joint_names) for axis, size in AXES.items()}
    file.dimensions = {"time": len(run) or None, **sizes}  # a dimension of length 0 can only grow: None
    for name, texts in _texts(run).items():
        axis, long_name = LABELS[name]
        text = file.create_variable(name, (axis,), h5py.string_dtype())
        text[...] = np.array(texts, dtype=object)
        text.attrs["long_name"] = long_name
    for entry in FIELDS:
        variable = file.create_variable(entry.name, ("time", *entry.axes), entry.dtype, data=getattr(run, entry.name))
        variable.attrs.update(_attributes(entry, run.joint_units))
    file.attrs.update(run.attrs)


def _texts(run: Run) -> dict[str, tuple[str, ...]]:
    return {"joint": run.joint_names, "joint_unit": run.joint_units, "component": TWIST_COMPONENTS}


def _attributes(entry: Field, joint_units: tuple[str, ...]) -> dict[str, Any]:
    """Units, long name and the meaning of codes, as the CF conventions write them."""
    units = {"joint": joint_units, "joint/s": tuple(RATE_UNITS[unit] for unit in joint_units)}.get(entry.units)
    text = entry.units if units is None else ", ".join(dict.fromkeys(units))
    attributes: dict[str, Any] = {"long_name": entry.long_name, "units": text}
    if entry.name == "status":
        flags = [flag for flag in Status if flag]
        attributes["flag_masks"] = np.array([flag.value for flag in flags], dtype=np.int32)
        attributes["flag_meanings"] = " ".join(str(flag.name) for flag in flags)
    if codes := CODES.get(entry.name):
        attributes["flag_values"] = np.array(sorted(codes), dtype=np.int8)
        attributes["flag_meanings"] = " ".join(codes[code] for code in sorted(codes))
    return attributes


def _as_new_file(part: Path) -> None:
    """On the disk before it is moved, and with the rights of an ordinary new file: mkstemp makes private ones."""
    with part.open("rb") as file:
        os.fsync(file.fileno())
    mask = os.umask(0)
    os.umask(mask)
    part.chmod(0o666 & ~mask)


def _plain(value: Any) -> Any:
    """An attribute as the Python number or text that was saved."""
    return value.item() if isinstance(value, np.generic | np.ndarray) and value.size == 1 else value


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)


def _h5netcdf(purpose: str) -> Any:
    """The h5netcdf module, if it and what it stands on are there."""
    try:
        import h5netcdf
        import h5py  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("netcdf", purpose) from error
    return h5netcdf
