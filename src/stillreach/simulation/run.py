"""The record of a simulation: arrays by name, one row for each tick."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._files import file_name
from stillreach.errors import InputError
from stillreach.simulation.fields import FIELDS, RATE_UNITS, Field
from stillreach.simulation.labels import Attribute

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Run:
    """What happened in a simulation, tick by tick. Its arrays are read-only; T is the number of ticks, n of joints.

    Attributes:
        time: (T,) [s].
        path_time: (T,) [s] time along the motion at which the tick's command was taken: ``time``, or less where the
            scenario's clock follows the arm.
        q: (T, n) joint values at the tick [rad] or [m].
        rates: (T, n) rates commanded at the tick [rad/s] or [m/s].
        pose: (T, 4, 4) pose of the tool (with the task's tool) in the base frame [m].
        target: (T, 4, 4) pose that the motion has led to at the tick: where the tool should be [m].
        command: (T, 6) twist [v; w] asked of the law, feedback included [m/s, rad/s].
        residual: (T, 6) that twist minus the one that the rates make [m/s, rad/s].
        task_error: (T,) weighted norm of the residual.
        damping: (T,) damping factor, in units of the weighted J Jᵀ.
        scale: (T,) fraction of the commanded twist that was asked for.
        status: (T,) bits of Status.
        lower, upper: (T, n) bounds of the rates [rad/s] or [m/s].
        health: (T, n) Health of each joint.
        active: (T, n) bound that each joint is at, as ``Solution.active``: 0 or a Reason, negative at the lower bound.
        joint_names: (n,) names.
        joint_units: (n,) unit of each joint's value, ``"rad"`` or ``"m"``.
        attrs: labels, read-only: numbers and texts; ``law``, ``task``, ``faults`` and ``null_motion`` hold JSON.

    Raises:
        InputError: an array of another type, or of another shape than the others imply; a code without a meaning.
    """

    time: FloatArray
    path_time: FloatArray
    q: FloatArray
    rates: FloatArray
    pose: FloatArray
    target: FloatArray
    command: FloatArray
    residual: FloatArray
    task_error: FloatArray
    damping: FloatArray
    scale: FloatArray
    status: npt.NDArray[np.int32]
    lower: FloatArray
    upper: FloatArray
    health: npt.NDArray[np.int8]
    active: npt.NDArray[np.int8]
    joint_names: tuple[str, ...]
    joint_units: tuple[str, ...]
    attrs: Mapping[str, Attribute] = field(default_factory=dict)

    def __post_init__(self) -> None:
        n, ticks = len(self.joint_names), len(self.time)
        if len(self.joint_units) != n:
            raise InputError("joint_units", f"{len(self.joint_units)} units", f"one for each of {n} joints")
        for unit in self.joint_units:
            _door.choice("joint_units", unit, tuple(RATE_UNITS))
        for entry in FIELDS:
            array = _array(entry, getattr(self, entry.name))
            if array.shape != entry.shape(ticks, n):
                raise InputError(entry.name, f"shape {array.shape}", f"shape {entry.shape(ticks, n)}")
            array.flags.writeable = False
            object.__setattr__(self, entry.name, array)
        object.__setattr__(self, "joint_names", tuple(self.joint_names))
        object.__setattr__(self, "joint_units", tuple(self.joint_units))
        object.__setattr__(self, "attrs", MappingProxyType(dict(self.attrs)))

    def to_xarray(self) -> xarray.Dataset:
        """The run as an xarray Dataset with named axes, units and long names (extra ``netcdf``).

        Raises:
            MissingExtraError: xarray is not installed.
        """
        from stillreach.simulation.netcdf import to_dataset

        return to_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the run to a netCDF file (extra ``netcdf``), or to a NumPy archive where the name ends with ``.npz``.

        A file of that name is replaced whole or not at all, and keeps its permissions.

        Args:
            path: the file, e.g. ``"run.nc"``; its folder must exist.

        Raises:
            MissingExtraError: h5netcdf or h5py is not installed.
            InputError: the path is not a file's name, or a pipe, socket or device; a label that a file cannot hold.
            OSError: the file cannot be written.
        """
        from stillreach.simulation import archive, netcdf

        write = archive.write if file_name("path", path).endswith(archive.SUFFIX) else netcdf.write
        write(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Run:
        """Read a run from a file that ``save`` wrote: netCDF (extra ``netcdf``) or a NumPy archive.

        Args:
            path: the file.

        Raises:
            MissingExtraError: h5netcdf or h5py is not installed.
            InputError: the file is not a run.
            FileNotFoundError: there is none.
        """
        from stillreach.simulation import archive, netcdf

        file_name("path", path)
        values = archive.read(path) if archive.is_archive(path) else netcdf.read(path)
        try:
            return cls(**values)
        except InputError as error:
            raise InputError(
                "path", f"{os.fspath(path)!r} with {error.argument}: {error.got}", netcdf.EXPECTED
            ) from None

    def plot(self) -> Figure:
        """A figure of the run: angles, rates, tool, task error and damping over time (extra ``plot``).

        Raises:
            MissingExtraError: matplotlib is not installed.
        """
        from stillreach.show.plots import overview

        return overview(self)

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        span = f", {self.time[0]:g} to {self.time[-1]:g} s" if len(self) else ""
        return f"<Run {self.attrs.get('title', '')!r}: {len(self)} ticks{span}, {len(self.joint_names)} joints>"

    def __reduce__(self) -> tuple[Any, ...]:
        values = {entry.name: getattr(self, entry.name) for entry in FIELDS}
        values |= {"joint_names": self.joint_names, "joint_units": self.joint_units, "attrs": dict(self.attrs)}
        return _rebuild, (values,)


def _array(entry: Field, value: Any) -> npt.NDArray[Any]:
    """A copy of an array in its type; InputError where that would change its numbers, or for unknown codes."""
    expected = f"numbers of type {np.dtype(entry.dtype)}" + (
        "" if entry.codes is None else f" from {entry.codes[0]} to {entry.codes[1]}"
    )
    try:
        given = np.asarray(value)
    except ValueError:
        raise InputError(entry.name, _door.describe(value), expected) from None
    if not np.can_cast(given.dtype, entry.dtype, "same_kind"):
        raise InputError(entry.name, _door.describe(value), expected)
    if entry.codes is not None and given.size and not (entry.codes[0] <= given.min() and given.max() <= entry.codes[1]):
        raise InputError(entry.name, f"codes from {given.min()} to {given.max()}", expected)
    return np.array(given, dtype=entry.dtype, order="C")


def _rebuild(values: dict[str, Any]) -> Run:
    """Unpickle through the constructor: pickled arrays forget that they are read-only."""
    return Run(**values)
