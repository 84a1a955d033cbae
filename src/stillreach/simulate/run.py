"""The record of a simulation: arrays by name, one row for each tick."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach.errors import InputError
from stillreach.simulate.fields import FIELDS
from stillreach.simulate.labels import Attribute

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
        pose: (T, 4, 4) pose of the tool in the base frame [m].
        command: (T, 6) twist [v; w] asked of the law, feedback included [m/s, rad/s].
        residual: (T, 6) that twist minus the one that the rates make [m/s, rad/s].
        task_error: (T,) weighted norm of the residual.
        damping: (T,) damping factor, in units of the weighted J Jᵀ.
        scale: (T,) fraction of the commanded twist that was asked for.
        status: (T,) bits of Status.
        lower, upper: (T, n) bounds of the rates [rad/s] or [m/s].
        health: (T, n) 0 healthy, 1 locked, 2 derated, 3 runaway.
        joint_names: (n,) names.
        joint_units: (n,) unit of each joint's value, ``"rad"`` or ``"m"``.
        attrs: labels (law, period, integrator, ...), read-only.

    Raises:
        InputError: an array has another shape than the others imply.
    """

    time: FloatArray
    path_time: FloatArray
    q: FloatArray
    rates: FloatArray
    pose: FloatArray
    command: FloatArray
    residual: FloatArray
    task_error: FloatArray
    damping: FloatArray
    scale: FloatArray
    status: npt.NDArray[np.int32]
    lower: FloatArray
    upper: FloatArray
    health: npt.NDArray[np.int8]
    joint_names: tuple[str, ...]
    joint_units: tuple[str, ...]
    attrs: Mapping[str, Attribute] = field(default_factory=dict)

    def __post_init__(self) -> None:
        n, ticks = len(self.joint_names), len(self.time)
        if len(self.joint_units) != n:
            raise InputError("joint_units", f"{len(self.joint_units)} units", f"one for each of {n} joints")
        for entry in FIELDS:
            array = np.array(getattr(self, entry.name), dtype=entry.dtype, order="C")
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
        from stillreach.simulate.netcdf import to_dataset

        return to_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the run to a netCDF file (extra ``netcdf``). A file of that name is replaced whole or not at all.

        Args:
            path: the file, e.g. ``"run.nc"``; its folder must exist.

        Raises:
            MissingExtraError: xarray, h5netcdf or h5py is not installed.
            OSError: the file cannot be written.
        """
        from stillreach.simulate.netcdf import write

        write(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Run:
        """Read a run from a netCDF file that ``save`` wrote (extra ``netcdf``).

        Args:
            path: the file.

        Raises:
            MissingExtraError: xarray, h5netcdf or h5py is not installed.
            InputError: the file is not a run.
            FileNotFoundError: there is none.
        """
        from stillreach.simulate.netcdf import read

        return cls(**read(path))

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


def _rebuild(values: dict[str, Any]) -> Run:
    """Unpickle through the constructor: pickled arrays forget that they are read-only."""
    return Run(**values)
