"""One chunk of a survey: its configurations, and what each metric makes of them.

Only the compiled core and exact or elementwise operations of NumPy take part, so that a chunk is the same to the last
bit wherever the instruction set and the version are the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach.tolerance.losses import all_sets, least_everywhere, relative
from stillreach.tolerance.surveys.arrays import ALL, BINS, CELLS, PLANES, REDUCED, SPEEDS, Arrays, empty
from stillreach.tolerance.surveys.plan import BLOCK, Plan
from stillreach.tolerance.surveys.positions import Region, poses_at, reached_cells

TOLERANCE = 1e-6
"""[m, rad] largest error of a reached pose."""

Bools = npt.NDArray[np.bool_]


def measured(plan: Plan, index: int, given: FloatArray | None, threads: int | None) -> Arrays:
    """The arrays of a chunk, by name.

    Args:
        plan: the survey.
        index: of the chunk.
        given: poses (N, 4, 4) [m] or configurations (N, n) [rad, m] of the chunk, where the survey is of such.
        threads: how many; None: as for ``solve_batch``.
    """
    chunk = _Chunk(plan, index, threads)
    first = 0
    goals = plan.goals(index) if "reach" in plan.metrics else None
    for q, counts in _configurations(plan, index, given, threads):
        rows = np.arange(first, first + len(q))[counts]
        chunk.add(np.ascontiguousarray(q[counts]), rows, None if goals is None else next(goals)[counts])
        first += len(q)
    chunk.found["unreached"][...] = first - chunk.found["configurations"]
    return {**chunk.found, **chunk.kept}


def _configurations(
    plan: Plan, index: int, given: FloatArray | None, threads: int | None
) -> Iterator[tuple[FloatArray, Bools]]:
    """Configurations (B, n), and which of them count."""
    if plan.kind != "poses" or given is None:
        for q in plan.blocks(index) if given is None else _blocks(given):
            yield q, np.ones(len(q), dtype=bool)
        return
    for poses in _blocks(given):
        found = plan.arm.inverse(poses, **_search(plan, threads))
        yield found.q, found.reached


def _blocks(given: FloatArray) -> Iterator[FloatArray]:
    for first in range(0, len(given), BLOCK):
        yield given[first : first + BLOCK]


def _search(plan: Plan, threads: int | None) -> dict[str, Any]:
    return {
        "task": plan.task,
        "starts": plan.starts,
        "tolerance": TOLERANCE,
        "seed": plan.seed,
        "threads": threads,
    }


class _Chunk:
    """The arrays of a chunk, filled block by block."""

    def __init__(self, plan: Plan, index: int, threads: int | None) -> None:
        self.plan, self.threads = plan, threads
        self.found = empty(plan, REDUCED, None)
        self.kept = empty(plan, ALL, plan.size(index))
        self.sizes = np.array([len(joints) for joints in plan.sets])
        self.begin = np.searchsorted(self.sizes, np.arange(1, plan.k + 1))
        places = {} if plan.every else {joints: i for i, joints in enumerate(all_sets(plan.arm.n, plan.k))}
        self.columns = np.array([places[joints] for joints in plan.sets] if places else [], dtype=np.int64)
        self.all = plan.keep == "all"
        self.alone = self.all or not plan.every  # each set by itself
        self.first = index * plan.chunk
        tool = plan.task.tool
        self.arm = plan.arm if tool is None else plan.arm.with_tool(plan.arm.tool @ tool)

    def add(self, q: FloatArray, rows: npt.NDArray[np.int64], goals: FloatArray | None) -> None:
        """A block of configurations, which are these rows of the chunk."""
        if not len(q):
            return
        self.found["configurations"] += len(q)
        if "counts" in self.kept:
            self.kept["counts"][rows] = True
        if "q" in self.kept:
            self.kept["q"][rows] = q
        if "relative" in self.plan.metrics:
            self._relative(q, rows)
        if "speed" in self.plan.metrics:
            self._speed(q, rows)
        if "depth" in self.plan.metrics:
            self._depth(q, rows)
        if goals is not None:
            self._reach(q, goals, rows)
        if self.plan.region is not None:
            self._positions(q, rows, self.plan.region)

    def _relative(self, q: FloatArray, rows: npt.NDArray[np.int64]) -> None:
        plan, found = self.plan, self.found
        left = relative(plan.arm, q, plan.k, task=plan.task, every=self.alone, threads=self.threads or 0)
        worst, which = left.worst, left.which
        if self.alone:
            every = left.every if plan.every else left.every[:, self.columns]  # type: ignore[index]
            assert every is not None
            worst, which = self._worst(every)
            if self.all:
                self.kept["every_relative"][rows] = every
        regular = ~np.isnan(left.joint[:, 0])
        found["singular"] += len(q) - int(np.count_nonzero(regular))
        if not regular.all():
            q, worst, which = q[regular], worst[regular], which[regular]
        joint = left.joint[regular]
        if not len(q):
            return
        found["relative"] += _counted(_bins(joint), BINS)
        for size in range(plan.k):
            if not np.isfinite(worst[0, size]):
                continue  # no set of this size
            found["worst"][size] += _counted(_bins(worst[:, size : size + 1]), BINS)[0]
            places = self.begin[size] + which[:, size]
            found["worst_set"] += np.bincount(places, minlength=len(plan.sets))
            for name, at in (("weakest", np.argmin(worst[:, size])), ("strongest", np.argmax(worst[:, size]))):
                value, best = worst[at, size], found[name][size]
                if value < best if name == "weakest" else value > best:
                    found[name][size] = value
                    found[f"{name}_set"][size] = places[at]
                    found[f"{name}_q"][size] = q[at]
        self._map(q, np.min(joint, axis=1))

    def _worst(self, every: FloatArray) -> tuple[FloatArray, npt.NDArray[np.int32]]:
        """The least of each size (N, k), inf where there is no set, and its place among those of its size."""
        worst = np.full((len(every), self.plan.k), np.inf)
        which = np.zeros(worst.shape, dtype=np.int32)
        for size in range(1, self.plan.k + 1):
            own = every[:, self.sizes == size]
            if own.shape[1]:
                which[:, size - 1] = np.argmin(own, axis=1)
                worst[:, size - 1] = np.min(own, axis=1)
        return worst, which

    def _map(self, q: FloatArray, left: FloatArray) -> None:
        """Where the tool is, and what the worst joint leaves there."""
        points = self.arm.forward(q)[:, :3, 3]
        cells = np.clip((points / self.arm.reach + 1.0) * (0.5 * CELLS), 0, CELLS - 1).astype(np.int64)
        for plane, name in enumerate(PLANES):
            flat = cells[:, "xyz".index(name[2])] * CELLS + cells[:, "xyz".index(name[0])]
            shape = (CELLS, CELLS)
            self.found["map_count"][plane] += np.bincount(flat, minlength=CELLS**2).reshape(shape)
            self.found["map_sum"][plane] += np.bincount(flat, weights=left, minlength=CELLS**2).reshape(shape)
            np.maximum.at(self.found["map_best"][plane].reshape(-1), flat, left)

    def _speed(self, q: FloatArray, rows: npt.NDArray[np.int64]) -> None:
        plan = self.plan
        sets = plan.sets if self.alone else None
        left = least_everywhere(plan.arm, q, plan.k, task=plan.task, sets=sets, threads=self.threads or 0)
        worst = left.worst if left.every is None else self._worst(left.every)[0]
        self.found["speed"] += _counted(_speed_bins(left.whole[:, None]), len(SPEEDS) + 1)[0]
        self.found["speed_joint"] += _counted(_speed_bins(left.joint), len(SPEEDS) + 1)
        own = np.isfinite(worst[0])
        self.found["speed_worst"][own] += _counted(_speed_bins(worst[:, own]), len(SPEEDS) + 1)
        if self.all:
            self.kept["every_speed"][rows] = left.whole
            self.kept["every_speed_after"][rows] = left.every

    def _depth(self, q: FloatArray, rows: npt.NDArray[np.int64]) -> None:
        plan = self.plan
        left = least_everywhere(plan.arm, q, plan.k, task=plan.task, least=True, threads=self.threads or 0)
        deep = np.where(left.whole < 1.0, -1, np.cumprod(left.worst >= 1.0, axis=1).sum(axis=1))
        self.found["depth"] += np.bincount(deep + 1, minlength=plan.k + 2)
        if self.all:
            self.kept["every_depth"][rows] = deep

    def _reach(self, q: FloatArray, goals: FloatArray, rows: npt.NDArray[np.int64]) -> None:
        """Which poses of other configurations are reached, before and after joints lock where they stand."""
        plan, search = self.plan, _search(self.plan, self.threads)
        poses = self.arm.forward(goals)
        before = plan.arm.inverse(poses, **search).reached
        after = np.empty((len(q), len(plan.sets)), dtype=bool)
        for place, joints in enumerate(plan.sets):
            after[:, place] = plan.arm.inverse(poses, q, locked=joints, **search).reached
        self.found["reach_before"] += int(np.count_nonzero(before))
        self.found["reach_after"] += np.count_nonzero(after, axis=0)
        if self.all:
            self.kept["goal"][rows] = goals
            self.kept["every_reach_before"][rows] = before
            self.kept["every_reach_after"][rows] = after

    def _positions(self, q: FloatArray, rows: npt.NDArray[np.int64], region: Region) -> None:
        """Whether a position that all joints reach is reached after each joint locks where it stands.

        Each configuration looks at one cell of the plane and one of the space, in an order that comes to all of them.
        """
        plan = self.plan
        search = {**_search(plan, self.threads), "task": region.task}
        for name, cells in (("slice", region.slice), ("cloud", region.cloud)):
            if cells is None:
                continue
            reached = reached_cells(region, cells, search)
            self.found[f"{name}_before"].reshape(-1)[reached] = 1
            if not len(reached):
                continue
            chosen = cells.order(reached, plan.seed)[(self.first + rows) % len(reached)]
            poses, total = poses_at(cells.points()[chosen]), cells.count ** len(cells.axes)
            self.found[f"{name}_tried"] += np.bincount(chosen, minlength=total).reshape(cells.shape)
            for joint in plan.singles:
                still = region.arm.inverse(poses, q, locked=(joint,), **search).reached
                counts = np.bincount(chosen[still], minlength=total).reshape(cells.shape)
                self.found[f"{name}_after"][joint] += counts


def _bins(values: FloatArray) -> npt.NDArray[np.int64]:
    return np.minimum((np.sqrt(np.sqrt(values)) * BINS).astype(np.int64), BINS - 1)


def _speed_bins(values: FloatArray) -> npt.NDArray[np.int64]:
    return np.searchsorted(np.array(SPEEDS), values, side="right")


def _counted(bins: npt.NDArray[np.int64], count: int) -> npt.NDArray[np.int64]:
    """(C, count) how many of each column are in each bin; bins: (N, C)."""
    columns = bins.shape[1]
    return np.bincount((bins + count * np.arange(columns)).ravel(), minlength=columns * count).reshape(columns, count)
