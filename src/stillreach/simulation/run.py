"""A run: a scenario and the record of what happened in it, by name and tick."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stillreach.errors import InputError
from stillreach.simulation.record import FIELDS, Record
from stillreach.simulation.scenario import Scenario
from stillreach.simulation.summary import Summary, summary
from stillreach.task import Task

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Run(Record):
    """What ``simulate`` returns: a scenario, and what happened in it.

    Its arrays by tick are those of ``Record``: time, q, rates, pose, target, command, residual, task_error, damping,
    scale, status, lower, upper, health, active and path_time.

    Attributes:
        scenario: what was run.
        interrupted: Ctrl-C ended it early.

    Raises:
        InputError: an array of another type, or of another shape than the others imply; a code without a meaning.
    """

    scenario: Scenario
    interrupted: bool = False

    def __post_init__(self) -> None:
        ticks = len(self.time)
        if ticks > self.scenario.steps + 1:
            raise InputError("time", f"{ticks} ticks", f"at most the {self.scenario.steps + 1} of the scenario")
        for entry in FIELDS:
            array = entry.checked(getattr(self, entry.name), ticks, self.scenario.arm.n)
            object.__setattr__(self, entry.name, array)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """(n,) names of the joints."""
        return self.scenario.arm.joint_names

    @property
    def joint_units(self) -> tuple[str, ...]:
        """(n,) unit of each joint's value, ``"rad"`` or ``"m"``."""
        return self.scenario.arm.joint_units

    @property
    def task(self) -> Task:
        """The task of the scenario."""
        assert self.scenario.task is not None
        return self.scenario.task

    def summary(self, *, allowed_distance: float | None = None, allowed_angle: float | None = None) -> Summary:
        """The run in a few numbers, and ``str()`` of it in words: did the tool arrive, and if not, why.

        Args:
            allowed_distance: [m] distance from the goal at which the tool has arrived; None: 1 % of the way, at least
                1 mm.
            allowed_angle: [rad] likewise; None: 1 % of the turn, at least 1 deg.

        Raises:
            InputError: the run has no tick.
        """
        if not len(self):
            raise InputError("run", "no tick", "a run of at least one tick")
        return summary(self, allowed_distance=allowed_distance, allowed_angle=allowed_angle)

    def plot(self, found: Summary | None = None) -> Figure:
        """A picture: the arm and the path of its tool, and over time how far off it was and what its joints did.

        Args:
            found: a summary of the run, whose verdict is written on it; None makes one.

        Raises:
            InputError: the run has no tick.
            MissingExtraError: matplotlib is not installed (extra ``plot``).
        """
        from stillreach.show.outcome import outcome

        return outcome(self, found)

    def to_xarray(self) -> xarray.Dataset:
        """The run as an xarray Dataset with named axes, units and long names (extra ``netcdf``).

        Raises:
            MissingExtraError: xarray is not installed.
        """
        from stillreach.simulation.netcdf import to_dataset

        return to_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the run to a netCDF file (extra ``netcdf``), or to a NumPy archive where the name ends with ``.npz``.

        A file of that name is replaced whole or not at all, and keeps its permissions. Of a function in the scenario
        the file holds the name.

        Args:
            path: the file, e.g. ``"run.nc"``; its folder must exist.

        Raises:
            MissingExtraError: h5netcdf or h5py is not installed.
            InputError: the path is not a file's name, or a pipe, socket or device; the scenario has a law, motion or
                null motion of a class that is not one of stillreach's.
            OSError: the file cannot be written.
        """
        from stillreach.simulation.files import write

        write(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Run:
        """Read a run from a file that ``save`` wrote: netCDF (extra ``netcdf``) or a NumPy archive.

        The run is the one that was saved, with its scenario. Where that had a function, as its motion or as a gradient,
        simulating it again raises InputError; summary and picture are the same (for a function as motion with
        ``clock="arm"`` they raise InputError, too).

        Args:
            path: the file.

        Raises:
            MissingExtraError: h5netcdf or h5py is not installed.
            InputError: the file is not a run.
            FileNotFoundError: there is no such file.
        """
        from stillreach.simulation.files import read

        return read(path)

    def __repr__(self) -> str:
        of = self.scenario
        interrupted = ", interrupted" if self.interrupted else ""
        ticks = f"{len(self)} ticks of {1000 * of.period:g} ms"
        return f"<Run {of.title!r}: {ticks}, {of.arm.name}, {type(of.law).__name__}{interrupted}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, ({**self.arrays(), "scenario": self.scenario, "interrupted": self.interrupted},)


def _rebuilt(values: dict[str, Any]) -> Run:
    """Unpickle through the constructor: pickled arrays forget that they are read-only."""
    return Run(**values)
