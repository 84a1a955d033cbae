"""A run: a scenario and its record, by name and tick."""

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

    from stillreach.page import Page


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Run(Record):
    """The result of ``simulate``: a scenario and its record.

    Its arrays by tick are those of ``Record``: time, q, measured, rates, pose, target, command, residual, task_error,
    damping, scale, status, lower, upper, health, known, active and path_time.

    Attributes:
        scenario: the simulated scenario.
        interrupted: whether Ctrl-C ended it early.

    Raises:
        InputError: if an array has an invalid type, shape or code.
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
        """The main numbers of a run; ``str()`` of it says whether the tool arrived and, if not, why.

        Args:
            allowed_distance: [m] largest distance from the goal that counts as arrived; None: 1 % of the path, at
                least 1 mm.
            allowed_angle: [rad] the same for the angle; None: 1 % of the turn, at least 1 deg.

        Raises:
            InputError: if the run has no ticks.
        """
        if not len(self):
            raise InputError("run", "no ticks", "a run with at least one tick")
        return summary(self, allowed_distance=allowed_distance, allowed_angle=allowed_angle)

    def plot(self, found: Summary | None = None) -> Figure:
        """A figure: arm and path of the tool; deviation, rates and joints over time.

        Args:
            found: a summary of the run, for the title; None: computed.

        Raises:
            InputError: if the run has no ticks.
            MissingExtraError: if matplotlib is not installed (extra ``plot``).
        """
        from stillreach.show.outcome import outcome

        return outcome(self, found)

    def page(self, *others: Run) -> Page:
        """A page that replays this run in a browser, beside others of the same arm, and goes on live from any moment.

        Raises:
            InputError: if a run has no ticks, or the arms differ.
            PageNotBuiltError: if this installation has no program for it.
        """
        from stillreach.page import run_page

        return run_page(self, *others)

    def to_xarray(self) -> xarray.Dataset:
        """The run as an xarray Dataset with named axes, units and long names (extra ``netcdf``).

        Raises:
            MissingExtraError: if xarray is not installed.
        """
        from stillreach.simulation.netcdf import to_dataset

        return to_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the run to a file, in the format of the name's ending.

        ``.nc`` (or none): netCDF (extra ``netcdf``); ``.npz``: a NumPy archive. ``load`` reads both. For other tools:
        ``.csv``; ``.parquet`` and ``.rosbag2``, a rosbag2 folder with an MCAP file (extra ``recordings``).

        An existing file is replaced only when the new one is complete, and keeps its permissions. The file has only the
        name of a function in the scenario.

        Args:
            path: the file, e.g. ``"run.nc"``; its folder must exist.

        Raises:
            MissingExtraError: if a package of the format is not installed.
            InputError: if the path is not a file name, has another ending, or is a pipe, socket or device; or if a
                scenario that is stored with it has a law, motion or null motion of a class outside stillreach.
            OSError: if the file cannot be written.
        """
        from stillreach.simulation.files import write

        write(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Run:
        """Read a run from a file that ``save`` wrote: netCDF (extra ``netcdf``) or a NumPy archive.

        The run equals the saved one, including its scenario. If that had a function as motion or gradient, a new
        simulation raises InputError. Summary and figure are the same, but raise InputError for a function as motion
        with ``clock="arm"``.

        Args:
            path: the file.

        Raises:
            MissingExtraError: if h5netcdf or h5py is not installed.
            InputError: if the file is not a run.
            FileNotFoundError: if the file is missing.
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
    """Unpickle through the constructor: unpickled arrays are writable."""
    return Run(**values)
