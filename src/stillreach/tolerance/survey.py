"""A survey: what an arm can afford to lose, over many configurations, stored as labelled arrays."""

from __future__ import annotations

import os
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._files import file_name
from stillreach._words import aligned
from stillreach.arm import Arm
from stillreach.errors import InputError, MissingExtraError
from stillreach.simulation.document import arm_of
from stillreach.task import Task
from stillreach.tolerance.losses import all_sets
from stillreach.tolerance.surveys import account
from stillreach.tolerance.surveys.arrays import EDGES, REDUCED, SPEED_EDGES, quantile
from stillreach.tolerance.surveys.plan import plan_of
from stillreach.tolerance.surveys.positions import Region, region_of
from stillreach.tolerance.surveys.run import expected_build, finish
from stillreach.tolerance.surveys.store import EXPECTED, Store, opened, zarr_or_error

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

AT_ONCE = 64
"""Chunks that are added up at once."""


class Survey:
    """What an arm can afford to lose, over many configurations; ``str()`` returns a table and a verdict.

    A survey is a folder in Zarr format, which xarray, Dask and other tools read; ``Survey.load`` opens it again.

    Args:
        store: its folder.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self.arm = arm_of(store.robot)
        self._totals: dict[str, npt.NDArray[Any]] = {}

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Survey:
        """A survey that was written before, perhaps only in part.

        Raises:
            InputError: if the folder is not a survey.
            FileNotFoundError: if there is no such folder.
        """
        folder = Path(file_name("path", path))
        if not folder.is_dir():
            raise FileNotFoundError(f"path: got {str(folder)!r}, expected {EXPECTED}; no such folder")
        return cls(Store(folder))

    @property
    def path(self) -> Path:
        """Its folder."""
        return self._store.folder

    @property
    def dataset(self) -> xarray.Dataset:
        """The labelled arrays, read when used.

        Raises:
            MissingExtraError: if xarray is not installed.
        """
        try:
            import xarray
        except ImportError as error:
            raise MissingExtraError("survey", "survey.dataset") from error
        opened_again: xarray.Dataset = xarray.open_zarr(str(self.path), chunks=None)
        return opened_again

    @cached_property
    def done(self) -> npt.NDArray[np.bool_]:
        """(chunks,) which chunks are finished."""
        return self._store.done

    @property
    def complete(self) -> bool:
        """Whether all chunks are finished."""
        return bool(self.done.all())

    @property
    def starts(self) -> int:
        """The most searches for a pose."""
        return int(self._store.document["starts"])

    @property
    def metrics(self) -> tuple[str, ...]:
        """Words of the metrics."""
        return tuple(self._store.document["metrics"])

    def total(self, name: str) -> npt.NDArray[Any]:
        """An array of all finished chunks together: sums of counts, extremes of weakest and strongest.

        Args:
            name: of a reduced array, e.g. ``"relative"``.

        Raises:
            InputError: if the survey has no such array.
        """
        names = [known for known in REDUCED if known in self._store.group]
        _door.choice("name", name, names)
        if name not in self._totals:
            kind = name.partition("_")[0]
            if kind in ("weakest", "strongest"):
                self._totals |= self._extreme(kind)
            else:
                self._totals[name] = self._added(name)
        return self._totals[name]

    def _added(self, name: str) -> npt.NDArray[Any]:
        array, places = self._store.group[name], np.flatnonzero(self.done)
        found = np.full(array.shape[1:], REDUCED[name].empty, dtype=array.dtype)
        for first in range(0, len(self.done), AT_ONCE):
            own = places[(places >= first) & (places < first + AT_ONCE)]
            for values in array[first : first + AT_ONCE][own - first]:  # in order: sums do not depend on pieces
                found = np.maximum(found, values) if REDUCED[name].largest else found + values
        return found

    def _extreme(self, kind: str) -> dict[str, npt.NDArray[Any]]:
        group, places = self._store.group, np.flatnonzero(self.done)
        values = group[kind][:][places]
        if not len(places):
            shapes = {name: group[name].shape[1:] for name in (kind, f"{kind}_set", f"{kind}_q")}
            return {name: np.full(shape, REDUCED[name].empty) for name, shape in shapes.items()}
        at = (np.argmin if kind == "weakest" else np.argmax)(values, axis=0)
        sizes = np.arange(values.shape[1])
        chosen = {name: group[name][:][places][at, sizes] for name in (f"{kind}_set", f"{kind}_q")}
        return {kind: values[at, sizes], **chosen}

    @cached_property
    def task(self) -> Task:
        """Its rows, frame and point."""
        given = self._store.document["task"]
        rows = given["rows"] if isinstance(given["rows"], str) else tuple(given["rows"])
        return Task(rows=rows, frame=given["frame"], tool=given["tool"])

    @property
    def configurations(self) -> int:
        """How many configurations count so far."""
        return int(self.total("configurations"))

    @cached_property
    def sets(self) -> tuple[tuple[str, ...], ...]:
        """The sets of joints that fail, by name."""
        given, names = self._store.document["failures"], self.arm.joint_names
        if isinstance(given, list):
            return tuple(tuple(joints) for joints in given)
        return tuple(tuple(names[joint] for joint in joints) for joints in all_sets(self.arm.n, given["k"]))

    def remaining(self, part: float = 0.5) -> FloatArray:
        """(n,) the relative manipulability below which a part of the configurations is without each joint.

        Args:
            part: 0.5 is the median.
        """
        part = _door.scalar("part", part)
        return _door.frozen([quantile(row, EDGES, part) for row in self.total("relative")])

    def remaining_worst(self, part: float = 0.5) -> FloatArray:
        """(k,) the same without the worst set of each size."""
        part = _door.scalar("part", part)
        return _door.frozen([quantile(row, EDGES, part) for row in self.total("worst")])

    @property
    def reached(self) -> FloatArray:
        """(sets,) the share of poses that is reached without each set of joints."""
        return _door.frozen(self.total("reach_after") / max(self.configurations, 1))

    @property
    def unreached(self) -> npt.NDArray[np.intp]:
        """Indices of the given poses that no start reached, of the finished chunks; they do not count."""
        if "counts" not in self._store.group:
            return np.zeros(0, dtype=np.intp)
        counts = np.asarray(self._store.group["counts"][:], dtype=bool)
        finished = np.repeat(self.done, self._store.document["chunk"])[: len(counts)]
        return np.flatnonzero(finished & ~counts)

    @cached_property
    def region(self) -> Region:
        """Where the survey looked for positions.

        Raises:
            InputError: if it has no positions.
        """
        if "positions" not in self.metrics:
            raise InputError("metrics", ", ".join(self.metrics), "a survey with positions")
        return region_of(self.arm, self.task)

    @property
    def positions(self) -> FloatArray:
        """(n,) the share of the positions that all joints reach which is reached without each joint, in any attitude.

        Of positions in space, or in the plane of a task in one, each with joints locked where some configuration has
        them; NaN where none was tried, or the joint does not fail alone.

        Raises:
            InputError: if the survey has no positions.
        """
        name = "slice" if self.region.cloud is None else "cloud"
        tried = int(self.total(f"{name}_tried").sum())
        after = self.total(f"{name}_after").reshape(self.arm.n, -1).sum(axis=1) / max(tried, 1)
        after[[joint for joint in range(self.arm.n) if not tried or joint not in self.singles]] = np.nan
        return _door.frozen(after)

    @cached_property
    def singles(self) -> tuple[int, ...]:
        """The joints that fail alone, by index."""
        return tuple(self.arm.joint_index(joints[0]) for joints in self.sets if len(joints) == 1)

    @property
    def ranking(self) -> tuple[int, ...]:
        """Joints, by index, that whose loss costs most first."""
        if "relative" in self.metrics:
            cost = self.remaining()
        elif "speed" in self.metrics:
            cost = np.array([quantile(row, SPEED_EDGES, 0.5) for row in self.total("speed_joint")])
        elif "reach" in self.metrics:
            by_set = dict(zip(self.sets, self.reached, strict=True))
            cost = np.array([by_set.get((name,), np.inf) for name in self.arm.joint_names])
        elif "positions" in self.metrics:
            cost = np.nan_to_num(self.positions, nan=np.inf)
        else:
            cost = np.zeros(self.arm.n)
        return tuple(int(joint) for joint in np.argsort(cost, kind="stable"))

    def _configuration(self, kind: str, size: int) -> tuple[tuple[str, ...], float, FloatArray]:
        count = _door.count("size", size)
        values = self.total(kind)
        if count > len(values) or not np.isfinite(values[count - 1]):
            raise InputError("size", f"{count}", f"the size of a set that the survey has, at most {len(values)}")
        names = self.sets[int(self.total(f"{kind}_set")[count - 1])]
        return names, float(values[count - 1]), _door.frozen(self.total(f"{kind}_q")[count - 1])

    def weakest(self, size: int = 1) -> tuple[tuple[str, ...], float, FloatArray]:
        """The configuration whose worst set of so many joints leaves least: that set, its relative one, q (n,)."""
        return self._configuration("weakest", size)

    def strongest(self, size: int = 1) -> tuple[tuple[str, ...], float, FloatArray]:
        """The configuration whose worst set of so many joints leaves most: as for ``weakest``."""
        return self._configuration("strongest", size)

    @property
    def verdict(self) -> str:
        """The main findings in words."""
        return account.verdict(self)

    @property
    def head(self) -> tuple[str, ...]:
        """Titles of the columns of ``table``: those of the metrics that the survey has."""
        return account.head(self)

    def table(self) -> list[tuple[str, ...]]:
        """Cells below ``head``: each joint, that whose loss costs most first."""
        return account.table(self)

    def facts(self) -> dict[str, Any]:
        """The main numbers, for JSON."""
        return account.facts(self)

    def plot(self, what: str = "overview") -> Figure:
        """A figure.

        Args:
            what: "overview": where the arm can afford losses, its joints by rank, how many it can lose, what it
                reaches; "slice": positions of a plane through the first joint that are reached before and after each
                loss; "cloud": the same in space, for the losses that cost most.

        Raises:
            InputError: if there is no such figure, or the survey has no positions for it.
            MissingExtraError: if matplotlib is not installed (extra ``plot``).
        """
        from stillreach.show.positions import cloud_figure, slice_figure
        from stillreach.show.survey import survey_figure

        figures = {"overview": survey_figure, "slice": slice_figure, "cloud": cloud_figure}
        return figures[_door.choice("what", what, tuple(figures))](self)

    def __str__(self) -> str:
        return "\n".join([aligned([self.head, *self.table()]), "", self.verdict])

    def __repr__(self) -> str:
        part = "" if self.complete else f", {int(self.done.sum())} of {len(self.done)} chunks"
        return f"<Survey of {self.arm.name}: {self.configurations:,} configurations{part}>"


def survey(
    arm: Arm,
    out: str | os.PathLike[str],
    *,
    samples: int | None = None,
    grid: int | Iterable[int] | None = None,
    poses: npt.ArrayLike | None = None,
    q: npt.ArrayLike | None = None,
    k: int | None = None,
    failures: Iterable[Any] | None = None,
    metrics: str | Iterable[str] | None = None,
    task: Task | None = None,
    seed: int = 1994,
    chunk: int | None = None,
    keep: str = "reduced",
    starts: int = 30,
    client: Any = None,
    baseline: bool = False,
    resume: bool = True,
    threads: int | None = None,
    progress: bool | None = None,
) -> Survey:
    """What an arm can afford to lose, over many configurations, in this process or on a Dask cluster.

    Each chunk has a seed of its own, and is stored as soon as it is done. A call with the same arguments after a kill
    goes on where it ended, and the result is the same to the last bit.

    Args:
        arm: the arm.
        out: the folder to write, in Zarr format.
        samples: random configurations within the limits; 100,000 if nothing else is given.
        grid: steps over the range of each joint, or of all.
        poses: (N, 4, 4) poses [m], whose configurations ``arm.inverse`` finds; those not reached are ``unreached`` and
            do not count.
        q: (N, n) the configurations themselves [rad, m].
        k: the largest number of joints that fail together; None: 2.
        failures: sets of joints in place of all up to k, e.g. ``["j1", ("j2", "j4")]``.
        metrics: some of relative, speed, depth, reach, positions; None: the first three, of arms with more than 31
            joints the first. ``reach`` takes a search for each configuration and set: its joints are locked where they
            stand, and the goals are poses of other random configurations. ``positions`` takes two for each
            configuration and joint: one position of a plane and one in space.
        task: rows, frame and point; None: the full pose. Its weights set the units of speeds.
        seed: of all random numbers.
        chunk: configurations computed and stored together; None: 250,000, or 2,000 where each takes longer.
        keep: "reduced": histograms, worst cases and maps of each chunk; "all": also every value of every configuration
            and set of joints. A note on standard error says first how much that is.
        starts: the most searches for a pose.
        client: a ``distributed.Client``, whose workers compute the chunks; None: this process.
        baseline: compute with the baseline instruction set, so that different processors give the same bits.
        resume: go on with a folder in which this survey was begun; False: refuse it.
        threads: how many of this process; None: as for ``solve_batch``. A worker's task has one.
        progress: show a bar; None: on a terminal, after one second.

    Raises:
        InputError: if an argument is invalid, the folder is that of something else, or a worker has another version or
            instruction set.
        UnknownJointError: if the arm has no such joint.
        MissingExtraError: if Zarr is not installed (extra ``survey``).
    """
    zarr_or_error()
    plan = plan_of(
        arm,
        samples=samples,
        grid=grid,
        poses=poses,
        q=q,
        k=k,
        failures=failures,
        metrics=metrics,
        task=task,
        seed=seed,
        chunk=chunk,
        keep=keep,
        starts=starts,
    )
    if threads is not None:
        threads = _door.count("threads", threads)
    if client is not None and not hasattr(client, "submit"):
        raise InputError("client", _door.describe(client), "a distributed.Client")
    build = expected_build(bool(baseline))
    store = opened(out, plan, build, bool(resume))
    if plan.keep == "all" and not store.done.any():
        account.say_size(plan, store.folder)
    finish(plan, store, build, client, threads, progress)
    return Survey(store)
