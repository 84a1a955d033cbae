"""The peers side by side: one process each, timed in turns on one core. One that fails leaves the others alone."""

import contextlib
import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from statistics import fmean, median
from typing import Any

import numpy as np

from bench.judge import Verdict, judge
from bench.peers import Entry
from bench.problem import Problem
from bench.worker import serve

READY, ANSWER = 300.0, 120.0
"""[s] how long a peer may take to get ready, and how much longer than its turn to answer."""
ONE_THREAD = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"), "1"),
    "JAX_PLATFORMS": "cpu",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
}
PROCESSES = multiprocessing.get_context("spawn")


@dataclass
class Peer:
    """One entry, its process, and what it has shown so far."""

    entry: Entry
    process: Any = None
    pipe: Connection | None = None
    times: list[list[float]] = field(default_factory=list)
    """For each part of the work, the times of all its passes [µs a row]."""
    versions: dict[str, str] = field(default_factory=dict)
    verdict: Verdict | None = None
    reason: str | None = None
    """Why it failed, if it did."""

    @property
    def best(self) -> float:
        """[µs] a row: the mean over the parts of each part's minimum, as short pieces fit between other load."""
        return fmean(map(min, self.times))

    @property
    def median(self) -> float:
        """[µs] a row: the mean over the parts of each part's median."""
        return fmean(map(median, self.times))

    def start(self, problem: Problem, rows: tuple[np.ndarray, np.ndarray] | None = None) -> None:
        """Starts it, waits until it is ready, and judges its answers. Keeps the reason if that fails."""
        os.environ.update(ONE_THREAD)
        self.pipe, child = PROCESSES.Pipe()
        self.process = PROCESSES.Process(target=serve, args=(self.entry.key, problem, rows, child), daemon=True)
        self.process.start()
        child.close()
        if said := self._read(READY):
            answers, self.versions = said
            self.verdict = judge(problem, answers)

    def turn(self, seconds: float) -> None:
        """Lets it run for about this long and keeps its times."""
        if self.pipe is None:
            return
        with contextlib.suppress(OSError):  # it is dead, which reading shows
            self.pipe.send(seconds)
        for times in self._read(seconds + ANSWER) or ():
            self.times = self.times or [[] for _ in times]
            for part, one in zip(self.times, times, strict=True):
                part.append(one)

    def stop(self) -> None:
        """Ends its process."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
        self.process = self.pipe = None

    def _read(self, seconds: float) -> Any:
        """What it says; None, and the reason, if that is nothing."""
        assert self.pipe is not None
        try:
            said = self.pipe.recv() if self.pipe.poll(seconds) else f"no answer for {seconds:g} s"
        except (EOFError, OSError):
            self.process.join()
            code = self.process.exitcode
            said = f"killed by {signal.Signals(-code).name}" if code < 0 else f"ended with {code}"
        if not isinstance(said, str):
            return said
        self.reason = said
        self.stop()
        return None


def interleave(peers: list[Peer], seconds: float, turn: float, after: Callable[[int], None]) -> None:
    """Gives all peers a turn, again and again, for about this long and at least three times; after(round) each time."""
    end, turns = time.monotonic() + seconds, 0
    while turns < 3 or time.monotonic() < end:
        for peer in peers:
            peer.turn(turn)
        turns += 1
        after(turns)
