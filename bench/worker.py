"""One peer in a process of its own: what clashes with other peers, or crashes, does so alone."""

import gc
import os
import tempfile
import time
from collections.abc import Callable
from importlib import metadata
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from bench.peers import ENTRIES
from bench.problem import PATH, Problem
from bench.workload import robot

Run = Callable[[slice], object]
PIECE = 1e-4
"""[s] that a timed piece of the work takes at most, if it is more than one tick."""
SAME_ARM = 1e-9
"""Largest difference between a peer's Jacobian and ours for them to be the same arm."""


def serve(key: str, problem: Problem, rows: tuple[np.ndarray, np.ndarray] | None, parent: Connection) -> None:
    """Sends the answers to the problem and the versions, or why there are none; then times for each number of seconds.

    Args:
        key: of the peer.
        problem: what it has to answer.
        rows: q (N, n) and twist (N, 6) of the batch that is timed; None times the problem, tick by tick.
        parent: the other end asks and listens.
    """
    os.dup2(2, 1)  # solvers print, from C
    try:
        rows = rows and (own(rows[0]), own(rows[1]))
        run, parts, answers, versions = set_up(key, Problem(*map(own, vars(problem).values())), rows)
    except Exception as error:
        parent.send(f"{type(error).__name__}: {error}")
        raise
    parent.send((answers, versions))
    gc.disable()
    while True:
        gc.collect()
        parent.send(timed(run, parts, parent.recv()))


def own(array: np.ndarray) -> np.ndarray:
    """A copy with NumPy's own data type: an array that came through a pipe has another, equal one, and is slow."""
    return array.astype(array.dtype.type)


def set_up(
    key: str, problem: Problem, rows: tuple[np.ndarray, np.ndarray] | None
) -> tuple[Run, list[slice], np.ndarray, dict[str, str]]:
    """Makes the peer and lets it answer everything once.

    Raises:
        ValueError: its arm is another one.
    """
    make = ENTRIES[key].load()
    with tempfile.TemporaryDirectory() as folder:
        peer = make(robot(Path(folder)))
    ticks = np.linspace(0, len(problem) - 1, 8).astype(int)
    found = [np.asarray(peer.jacobian(problem.q[t])) - problem.jacobian[t][:, problem.working] for t in ticks]
    error, allowed = float(np.max(np.abs(found))), getattr(peer, "same_arm", SAME_ARM)
    if not error <= allowed:
        raise ValueError(f"its Jacobian differs from ours by {error:.1e}, more than {allowed:.0e}")
    versions = {name: metadata.version(name) for name in make.packages}
    if rows is not None:
        run: Run = lambda part: peer.solve(*rows)  # noqa: E731
        return run, [slice(0, len(rows[0]))], peer.solve(problem.q, problem.twist), versions
    answers = np.array([peer.tick(q, twist).copy() for q, twist in zip(problem.q, problem.twist, strict=True)])
    run = tick_run(peer, problem)
    return run, pieces(run, len(problem)), answers, versions


def tick_run(peer: Any, problem: Problem) -> Run:
    """Calls of a slice of the ticks."""
    if hasattr(peer, "prepare"):
        return peer.prepare(problem.q, problem.twist)
    ticks, tick = list(zip(problem.q, problem.twist, strict=True)), peer.tick

    def run(part: slice) -> None:
        for q, twist in ticks[part]:
            tick(q, twist)

    return run


def pieces(run: Run, ticks: int) -> list[slice]:
    """The ticks in pieces of about equal time for fast and slow peers: what else the machine does hits all alike."""
    run(slice(0, PATH))
    began = time.perf_counter()
    run(slice(0, PATH))
    taken, length = time.perf_counter() - began, PATH
    while length > 1 and taken * length / PATH > PIECE:
        length //= 2
    return [slice(start, start + length) for start in range(0, ticks, length)]


def timed(run: Run, parts: list[slice], seconds: float) -> list[list[float]]:
    """[µs] of one row in each part, of as many passes as fit, one at least, after one part to warm up."""
    passes: list[list[float]] = []
    run(parts[0])
    end = time.perf_counter() + seconds
    while not passes or time.perf_counter() < end:
        times = []
        for part in parts:
            began = time.perf_counter_ns()
            run(part)
            times.append((time.perf_counter_ns() - began) / (1e3 * (part.stop - part.start)))
        passes.append(times)
    return passes
