"""Runs as netCDF files and as xarray Datasets.

The packages are an extra, imported only here, inside the functions. Files are written and read with h5netcdf alone,
which starts ten times faster than xarray; xarray opens them like any other netCDF file.
"""

from __future__ import annotations

import io
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from stillreach._core import instruction_set
from stillreach._files import file_name, new_file
from stillreach.errors import InputError, MissingExtraError
from stillreach.simulation.document import scenario_text
from stillreach.simulation.record import AXES, FIELDS, RATE_UNITS, TWIST_COMPONENTS, Field, Stored
from stillreach.status import Status

if TYPE_CHECKING:
    import xarray

    from stillreach.simulation.run import Run

LABELS = {
    "joint": ("joint", "joint"),
    "joint_unit": ("joint", "unit of the joint's value"),
    "component": ("component", "component of a twist"),
}
"""Axis and long name of each text variable."""

SCENARIO = "scenario"
"""The variable with the scenario."""
ABOUT_SCENARIO = {"long_name": "what was run, as JSON", "_Encoding": "utf-8"}

EXPECTED = "a file that run.save() wrote"

MOST_COMPRESSED = 1100
"""Largest ratio of array size to stored size: HDF5 compression stays below it; an array without data exceeds it."""


def to_dataset(run: Run) -> xarray.Dataset:
    """The run as a Dataset, as read by xarray from a file."""
    h5netcdf = _h5netcdf("run.to_xarray()")
    try:
        import xarray
    except ImportError as error:
        raise MissingExtraError("netcdf", "run.to_xarray()") from error
    memory = io.BytesIO()
    with h5netcdf.File(memory, "w") as file:
        _fill(file, run, scenario_text(run.scenario))
    return xarray.load_dataset(memory, engine="h5netcdf", decode_times=False)


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a run to a new file, which replaces the old one only when complete."""
    h5netcdf = _h5netcdf("run.save()")
    scenario = scenario_text(run.scenario)
    with _interrupts_wait(), new_file(path) as target:
        sink = _Sink(target)
        with h5netcdf.File(sink, "w") as file:
            _fill(file, run, scenario)
        if sink.error is not None:
            raise sink.error


def _labels(run: Run) -> dict[str, str | int]:
    """The attributes of the file as a whole."""
    return {
        "title": run.scenario.title,
        "interrupted": int(run.interrupted),
        "source": f"stillreach {version('stillreach')}",
        "instruction_set": instruction_set(),
    }


class _Sink:
    """The file that HDF5 writes to. Writing never raises: HDF5 would end the process if the disk is full.

    Attributes:
        error: the first error; after it the file is in memory.
    """

    def __init__(self, file: BinaryIO) -> None:
        self.error: BaseException | None = None
        self._file: Any = file.raw  # type: ignore[attr-defined]  # unbuffered: no data remains after a failed write

    def write(self, data: memoryview) -> int:
        """Write at the current position."""
        left = memoryview(data)
        while left:
            left = left[self._done(lambda file: file.write(left)) :]  # noqa: B023 - called at once
        return len(data)

    def readinto(self, data: memoryview) -> int:
        """Read written data back."""
        return self._done(lambda file: file.readinto(data))

    def read(self, size: int) -> bytes:
        """The same as bytes; h5py knows files by this method."""
        data = bytearray(size)
        return bytes(data[: self.readinto(memoryview(data))])

    def seek(self, place: int, origin: int = os.SEEK_SET) -> int:
        """Move the position."""
        return self._done(lambda file: file.seek(place, origin))

    def tell(self) -> int:
        """The position."""
        return self._done(lambda file: file.tell())

    def truncate(self, size: int) -> int:
        """Cut or extend the file."""
        return self._done(lambda file: file.truncate(size))

    def flush(self) -> None:
        """Does nothing: the file is flushed when complete."""

    def _done(self, action: Callable[[Any], int]) -> int:
        place = self._file.tell()
        try:
            return action(self._file)
        except BaseException as error:
            self.error = self.error or error
            self._file.seek(0)
            self._file = io.BytesIO(self._file.read())
            self._file.seek(place)
            return action(self._file)


@contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Delays Ctrl-C until the file is complete: HDF5 reports errors for an incomplete file."""
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or handler is None:
        yield  # only the main thread handles signals; a handler outside Python cannot be restored
        return
    came = []
    signal.signal(signal.SIGINT, lambda *_: came.append(True))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
    if came:
        signal.raise_signal(signal.SIGINT)


def read(path: str | os.PathLike[str]) -> Stored:
    """Read the contents of a file; sizes and types are checked before data is read."""
    _h5netcdf("Run.load()")
    import h5py

    name = file_name("path", path)
    if not Path(name).is_file():
        raise FileNotFoundError(f"path: got {name!r}, expected {EXPECTED}; no such file")
    try:
        with h5py.File(name, "r") as file:
            return _values(file)
    except _NotARun as error:
        raise InputError("path", f"{name!r} {error}", EXPECTED) from None
    except MemoryError:
        raise
    except Exception as error:  # HDF5 has no special error for unreadable files
        raise InputError("path", f"{name!r} ({type(error).__name__}: {error})", EXPECTED) from error


class _NotARun(Exception):
    """An error in the contents of a file."""


def _values(file: Any) -> Stored:
    """Arrays and labels of an open file."""
    texts = ("joint", "joint_unit", SCENARIO)
    missing = [name for name in (*(entry.name for entry in FIELDS), *texts) if not _has(file, name)]
    if missing:
        raise _NotARun(f"without {', '.join(missing)}")
    names, units = (_checked(file, name, None, "O") for name in texts[:2])
    ticks, joints = len(_checked(file, "time", None, "f")), len(names)
    arrays = {entry.name: _checked(file, entry.name, entry.shape(ticks, joints), entry.kind) for entry in FIELDS}
    return Stored(
        {name: array[...] for name, array in arrays.items()},
        tuple(str(name) for name in names.asstr()[...]),
        tuple(str(unit) for unit in units.asstr()[...]),
        _checked(file, SCENARIO, None, "S")[...].tobytes().decode(),
        bool(_number(file.attrs, "interrupted")),
    )


def _has(file: Any, name: str) -> bool:
    """Whether the file contains the array itself, not a link to one."""
    import h5py

    return isinstance(file.get(name, getlink=True), h5py.HardLink) and isinstance(file[name], h5py.Dataset)


def _checked(file: Any, name: str, shape: tuple[int, ...] | None, kind: str) -> Any:
    """A variable, not yet read, after checks: this shape (None: any vector) and kind, complete and in this file."""
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


def _number(attrs: Any, name: str) -> int:
    """An attribute that is one integer."""
    if name not in attrs or attrs.get_id(name).shape not in ((), (1,)) or attrs.get_id(name).dtype.kind not in "iu":
        raise _NotARun(f"without a number as {name}")
    return int(np.ravel(attrs[name])[0])


def _fill(file: Any, run: Run, scenario: str) -> None:
    """Write dimensions, variables and attributes into an open, empty file."""
    import h5py

    sizes = {axis: size or len(run.joint_names) for axis, size in AXES.items()}
    file.dimensions = {"time": len(run) or None, **sizes}  # None: a dimension of length 0 must be unlimited
    texts = {"joint": run.joint_names, "joint_unit": run.joint_units, "component": TWIST_COMPONENTS}
    for name, (axis, long_name) in LABELS.items():
        text = file.create_variable(name, (axis,), h5py.string_dtype())
        text[...] = np.array(texts[name], dtype=object)
        text.attrs["long_name"] = long_name
    for entry in FIELDS:
        variable = file.create_variable(entry.name, ("time", *entry.axes), entry.dtype, data=getattr(run, entry.name))
        variable.attrs.update(_attributes(entry, run.joint_units))
    letters = np.frombuffer(scenario.encode(), dtype="S1")
    file.dimensions["letter"] = len(letters)
    variable = file.create_variable(SCENARIO, ("letter",), letters.dtype, data=letters)
    variable.attrs.update(ABOUT_SCENARIO)
    file.attrs.update(_labels(run))


def _attributes(entry: Field, joint_units: tuple[str, ...]) -> dict[str, Any]:
    """Units, long name and the meaning of codes, as the CF conventions write them."""
    units = {"joint": joint_units, "joint/s": tuple(RATE_UNITS[unit] for unit in joint_units)}.get(entry.units)
    text = entry.units if units is None else ", ".join(dict.fromkeys(units))
    attributes: dict[str, Any] = {"long_name": entry.long_name, "units": text}
    if entry.name == "status":
        flags = [flag for flag in Status if flag]
        attributes["flag_masks"] = np.array([flag.value for flag in flags], dtype=np.int32)
        attributes["flag_meanings"] = " ".join(str(flag.name) for flag in flags)
    if entry.meanings:
        attributes["flag_values"] = np.array(sorted(entry.meanings), dtype=entry.dtype)
        attributes["flag_meanings"] = " ".join(entry.meanings[code] for code in sorted(entry.meanings))
    return attributes


def _h5netcdf(purpose: str) -> Any:
    """The h5netcdf module, if it and its dependencies are installed."""
    try:
        import h5netcdf
        import h5py  # noqa: F401
    except ImportError as error:
        raise MissingExtraError("netcdf", purpose) from error
    return h5netcdf
