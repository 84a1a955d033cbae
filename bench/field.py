"""The peers side by side: one process each, timed in turns on one core. One that fails leaves the others alone."""

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from statistics import fmean, median
from typing import Any

import numpy as np

from bench.judge import Verdict, judge
from bench.peers import Entry
from bench.problem import Problem
from bench.robot_files import chain, mjcf, urdf
from bench.workload import arm

ROOT = Path(__file__).parents[1]
READY, ANSWER = 300.0, 120.0
"""[s] how long a peer may take to get ready, and how much longer than its turn to answer."""
ONE_THREAD = {
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS"), "1"),
    "JAX_PLATFORMS": "cpu",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
}


class PeerFailedError(Exception):
    """Why a peer takes no further part."""


@dataclass
class Peer:
    """One entry, its process, and what it has shown so far."""

    entry: Entry
    folder: Path
    process: subprocess.Popen[str] | None = None
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

    def start(self, problem: Problem) -> None:
        """Starts it, waits until it is ready, and judges its answers. Keeps the reason if that fails."""
        with self._or_reason():
            command = [sys.executable, "-m", "bench.worker", self.entry.key, str(self.folder)]
            with (self.folder / f"{self.entry.key}.log").open("w") as log:
                pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": log}
                settings = {"cwd": ROOT, "env": {**os.environ, **ONE_THREAD}, "text": True, "start_new_session": True}
                self.process = subprocess.Popen(command, **pipes, **settings)
            said = self._read(READY)
            self.versions = said["versions"]
            self.verdict = judge(problem, np.load(self.folder / f"{self.entry.key}.npy"))

    def turn(self, seconds: float) -> None:
        """Lets it run for about this long and keeps its times."""
        if self.reason is not None or self.process is None or self.process.stdin is None:
            return
        with self._or_reason():
            try:
                print(seconds, file=self.process.stdin, flush=True)
            except BrokenPipeError:
                raise PeerFailedError(self._end()) from None
            passes = self._read(seconds + ANSWER)["passes"]
            self.times = self.times or [[] for _ in passes[0]]
            for part, times in enumerate(self.times):
                times.extend(one[part] for one in passes)

    def stop(self) -> None:
        """Ends its process."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None

    @contextlib.contextmanager
    def _or_reason(self) -> Any:
        try:
            yield
        except PeerFailedError as failure:
            self.reason = str(failure)
            self.stop()

    def _read(self, seconds: float) -> dict[str, Any]:
        assert self.process is not None
        assert self.process.stdout is not None
        if not select.select([self.process.stdout], [], [], seconds)[0]:
            raise PeerFailedError(f"no answer for {seconds:g} s")
        line = self.process.stdout.readline()
        if not line:
            raise PeerFailedError(self._end())
        said: dict[str, Any] = json.loads(line)
        if said["event"] == "failed":
            raise PeerFailedError(said["reason"])
        return said

    def _end(self) -> str:
        assert self.process is not None
        code = self.process.wait()
        how = f"killed by {signal.Signals(-code).name}" if code < 0 else f"ended with {code}"
        last = (self.folder / f"{self.entry.key}.log").read_text(errors="replace").strip().splitlines()[-1:]
        return ": ".join([how, *last])


def prepare(folder: Path, ticks: Problem) -> None:
    """Writes the robot files that the peers read."""
    robot, limit = arm(), float(ticks.limit)
    frozen = {int(joint): float(ticks.q[0, joint]) for joint in ticks.locked}
    (folder / "working.urdf").write_text(urdf(robot, limit, frozen))
    (folder / "working.xml").write_text(mjcf(robot, frozen))
    placements, axes, tool = chain(robot, frozen)
    np.savez(folder / "chain.npz", placements=placements, axes=axes, tool=tool)


def interleave(peers: list[Peer], seconds: float, turn: float, after: Any) -> None:
    """Gives all peers a turn, again and again, for about this long and at least three times; after(round) each time."""
    end, turns = time.monotonic() + seconds, 0
    while turns < 3 or time.monotonic() < end:
        for peer in peers:
            peer.turn(turn)
        turns += 1
        after(turns)
