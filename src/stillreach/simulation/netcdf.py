"""Runs as netCDF files and as xarray Datasets.

The packages for it are an extra; they are imported here, inside the functions, and nowhere else. Files are written
and read with h5netcdf alone, which starts in a tenth of the time that xarray takes; xarray opens them like any other
netCDF file.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from stillreach import _door
from stillreach._files import file_name, new_file
from stillreach.errors import InputError, MissingExtraError
from stillreach.simulation.fields import AXES, CODES, FIELDS, RATE_UNITS, TWIST_COMPONENTS, Field
from stillreach.status import Status

if TYPE_CHECKING:
    import xarray

    from stillreach.simulation.run import Run

LABELS = {
    "joint": ("joint", "joint"),
    "joint_unit": ("joint", "unit of the joint's value"),
    "component": ("component", "component of a twist"),
}
"""Axis and long name of each variable that holds texts."""

EXPECTED = "a netCDF file that run.save() wrote"

OF_NETCDF = ("_NC", "_nc3")
"""How the format's own attributes begin."""

MOST_COMPRESSED = 1100
"""Most bytes of an array for a byte in the file: no compression of HDF5 makes more; an array without data has more."""


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
    """Write a run to a new file that takes the old one's place only when it is complete."""
    h5netcdf = _h5netcdf("run.save()")
    _check_labels(run)
    with _interrupts_wait(), new_file(path) as target:
        sink = _Sink(target)
        with h5netcdf.File(sink, "w") as file:
            _fill(file, run)
        if sink.error is not None:
            raise sink.error


def _check_labels(run: Run) -> None:
    """InputError for a label that a file cannot hold."""
    for name in run.joint_names:
        _door.text("joint_names", name)
    for key, value in run.attrs.items():
        _door.text("attrs", key)
        if isinstance(value, str):
            _door.text(f"attrs[{key!r}]", value)
        elif not isinstance(value, float | np.number) and not (isinstance(value, int) and -(2**63) <= value < 2**63):
            raise InputError(f"attrs[{key!r}]", _door.describe(value), "a text or a number of at most 64 bits")


class _Sink:
    """The file that HDF5 writes to. It never fails: HDF5 cannot give up a file that has no room, and ends the process.

    Attributes:
        error: what went wrong first; nothing was written from then on.
    """

    def __init__(self, file: BinaryIO) -> None:
        self.error: BaseException | None = None
        self._file, self._place, self._size = file, 0, 0

    def write(self, data: memoryview) -> int:
        """Write at the current position."""
        self._try(lambda: (self._file.seek(self._place), self._file.write(data)))
        self._place += len(data)
        self._size = max(self._size, self._place)
        return len(data)

    def readinto(self, data: memoryview) -> int:
        """Read back what was written."""
        self._try(lambda: (self._file.seek(self._place), self._file.readinto(data)))  # type: ignore[attr-defined]
        self._place += len(data)
        return len(data)

    def read(self, size: int) -> bytes:
        """The same as bytes; h5py knows files by this method."""
        data = bytearray(size)
        self.readinto(memoryview(data))
        return bytes(data)

    def seek(self, place: int, origin: int = os.SEEK_SET) -> int:
        """Move the position; only what is written moves the file's own."""
        self._place = place + {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._size}[origin]
        return self._place

    def tell(self) -> int:
        """The position."""
        return self._place

    def truncate(self, size: int) -> int:
        """Cut or extend the file."""
        self._try(lambda: self._file.truncate(size))
        self._size = size
        return size

    def flush(self) -> None:
        """Nothing: the file is flushed when it is complete."""

    def _try(self, action: Callable[[], object]) -> None:
        if self.error is None:
            try:
                action()
            except BaseException as error:
                self.error = error


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
    """The arguments of the Run that a file holds; sizes and types are checked before anything is read."""
    _h5netcdf("Run.load()")
    import h5py

    name = file_name("path", path)
    if not Path(name).is_file():
        raise FileNotFoundError(f"path: got {name!r}, expected {EXPECTED}; there is none")
    try:
        with h5py.File(name, "r") as file:
            return _values(file)
    except _NotARun as error:
        raise InputError("path", f"{name!r} {error}", EXPECTED) from None
    except MemoryError:
        raise
    except Exception as error:  # HDF5 has no error of its own for files that it cannot read
        raise InputError("path", f"{name!r} ({type(error).__name__}: {error})", EXPECTED) from error


class _NotARun(Exception):
    """What is wrong with a file."""


def _values(file: Any) -> dict[str, Any]:
    """Arrays and labels of an open file."""
    missing = [name for name in (*(entry.name for entry in FIELDS), "joint", "joint_unit") if not _has(file, name)]
    if missing:
        raise _NotARun(f"without {', '.join(missing)}")
    names, units = (_checked(file, name, None, "O") for name in ("joint", "joint_unit"))
    time = _checked(file, "time", None, "f")
    ticks, joints = len(time), len(names)
    arrays = {entry.name: _checked(file, entry.name, entry.shape(ticks, joints), entry.kind) for entry in FIELDS}
    return {
        **{name: array[...] for name, array in arrays.items()},
        "joint_names": tuple(str(name) for name in names.asstr()[...]),
        "joint_units": tuple(str(unit) for unit in units.asstr()[...]),
        "attrs": {name: _attribute(file.attrs, name) for name in file.attrs if not name.startswith(OF_NETCDF)},
    }


def _has(file: Any, name: str) -> bool:
    """Whether the file has an array of that name itself, and not a link to one."""
    import h5py

    return isinstance(file.get(name, getlink=True), h5py.HardLink) and isinstance(file[name], h5py.Dataset)


def _checked(file: Any, name: str, shape: tuple[int, ...] | None, kind: str) -> Any:
    """One variable, not yet read: an array of this shape (None: any vector) and kind, whole and in this file."""
    import h5py

    array = file[name]
    if array.dtype.kind != kind or (kind == "O" and h5py.check_string_dtype(array.dtype) is None):
        raise _NotARun(f"with {name} of type {array.dtype}")
    if array.ndim != 1 if shape is None else array.shape != shape:
        raise _NotARun(f"with {name} of shape {array.shape}")
    if array.external or array.is_virtual:
        raise _NotARun(f"with {name} in another file")
    if array.nbytes > MOST_COMPRESSED * array.id.get_storage_size():
        raise _NotARun(f"with {array.nbytes} bytes of {name} in {array.id.get_storage_size()}")
    return array


def _attribute(attrs: Any, name: str) -> Any:
    """An attribute as the Python number or text that was saved."""
    if attrs.get_id(name).shape not in ((), (1,)):
        raise _NotARun(f"with a list as {name}")
    value = attrs[name]
    value = value.item() if isinstance(value, np.generic | np.ndarray) else value
    if not isinstance(value, str | int | float):
        raise _NotARun(f"with {name} of type {type(value).__name__}")
    return value


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


def _h5netcdf(purpose: str) -> Any:
    """The h5netcdf module, if it and what it stands on are there."""
    try:
        import h5netcdf
        import h5py  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("netcdf", purpose) from error
    return h5netcdf
