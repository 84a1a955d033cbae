"""Minima and medians of interleaved repeats on one core."""

import gc
import os
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from bench.workload import POSES, STEPS


@dataclass
class Row:
    """One line of the table: run(part) does the calls of a slice of the workload, one path of it at a time.

    A figure is the mean over the paths of the minimum (median) of each path's repeats: short pieces fit between what
    else the machine does. The time of the row `less`, set-up between calls, is taken off.
    """

    name: str
    way: str
    run: Callable[[slice], object]
    budget: float | None = None
    less: "Row | None" = None
    times: list[list[float]] = field(default_factory=lambda: [[] for _ in range(POSES)])

    @property
    def best(self) -> float:
        """[µs] a call."""
        return statistics.fmean(map(min, self.times)) - (self.less.best if self.less else 0.0)

    @property
    def median(self) -> float:
        """[µs] a call."""
        return statistics.fmean(map(statistics.median, self.times)) - (self.less.median if self.less else 0.0)


def pin_to_one_core() -> int:
    """This process stays on one core, the last one it may use. Returns how many it might have used."""
    if not hasattr(os, "sched_setaffinity"):
        return os.cpu_count() or 1
    cores = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cores[-1]})
    return len(cores)


PATHS = [slice(STEPS * pose, STEPS * (pose + 1)) for pose in range(POSES)]


def measure(
    rows: list[Row],
    seconds: float,
    parts: Sequence[slice] = PATHS,
    *,
    least: int = 5,
) -> int:
    """Times all rows in turn, again and again, for about this long. Returns the number of repeats.

    Args:
        rows: what to time; each has as many lists of times as there are parts.
        seconds: how long, at least.
        parts: the slices of the workload that are timed one by one.
        least: repeats, at least.
    """
    gc.collect()
    gc.disable()
    repeats, end = 0, time.perf_counter() + seconds
    try:
        while repeats < least or time.perf_counter() < end:
            for row in rows:
                for part, times in zip(parts, row.times, strict=True):
                    began = time.perf_counter_ns()
                    row.run(part)
                    times.append((time.perf_counter_ns() - began) / (1e3 * (part.stop - part.start)))
            repeats += 1
    finally:
        gc.enable()
    return repeats


def machine_note(cores: int) -> str:
    """What else the machine is doing."""
    load = os.getloadavg()[0]
    if load <= 0.5 * cores:
        return f"Quiet machine: load average {load:.2f} on {cores} cores."
    return (
        f"BUSY machine: load average {load:.2f} on {cores} cores. Minima lie above a quiet core's, medians far above."
    )
