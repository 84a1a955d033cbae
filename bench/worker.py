"""One peer in a process of its own: what clashes with other peers, or crashes, does so alone.

    python -m bench.worker KEY FOLDER

Messages are lines of JSON. It says `ready` once its answers lie in FOLDER/KEY.npy, then waits: each line that comes in
is a number of seconds to be timed for, and is answered with the times.
"""

import gc
import json
import os
import sys
import time
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from bench.peers import BATCHES, ENTRIES
from bench.peers.base import Robot
from bench.problem import PATH, Problem

Run = Callable[[slice], object]
PIECE = 1e-4
"""[s] that a timed piece of the work takes at most, if it is more than one tick."""
SAME_ARM = 1e-9
"""Largest difference between a peer's Jacobian and ours for them to be the same arm."""


def private_output() -> TextIO:
    """Where messages go; whatever else prints (solvers do, from C) is kept out of them."""
    messages = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    return messages


def load_robot(folder: Path, problem: Problem) -> Robot:
    """The arm as `bench.field.prepare` wrote it."""
    with np.load(folder / "chain.npz") as chain:
        parts = chain["placements"], chain["axes"], chain["tool"]
    return Robot(folder, problem.q.shape[1], problem.working, problem.locked, float(problem.limit), *parts)


def model_error(peer: Any, problem: Problem) -> float:
    """Largest difference of the peer's Jacobian from ours, at a few ticks."""
    ticks = np.linspace(0, len(problem) - 1, 8).astype(int)
    found = [np.asarray(peer.jacobian(problem.q[t])) - problem.jacobian[t][:, problem.working] for t in ticks]
    return float(np.max(np.abs(found)))


def check_model(peer: Any, problem: Problem) -> float:
    """The same, if it is small enough for the arm to be the same.

    Raises:
        ValueError: it is not.
    """
    error, allowed = model_error(peer, problem), getattr(peer, "same_arm", SAME_ARM)
    if not error <= allowed:
        raise ValueError(f"its Jacobian differs from ours by {error:.1e}, more than {allowed:.0e}")
    return error


def tick_run(peer: Any, problem: Problem) -> Run:
    """Calls of a slice of the ticks."""
    if hasattr(peer, "prepare"):
        return peer.prepare(problem.q, problem.twist)
    rows, tick = list(zip(problem.q, problem.twist, strict=True)), peer.tick

    def run(part: slice) -> None:
        for q, twist in rows[part]:
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


def set_up(key: str, folder: Path) -> tuple[Run, list[slice], dict[str, Any]]:
    """Makes the peer, lets it answer everything once; what is to be timed, and what to say of it."""
    entry, batch = ENTRIES[key], ENTRIES[key] in BATCHES
    problem = Problem.load(folder / ("batch.npz" if batch else "ticks.npz"))
    peer = entry.load()(load_robot(folder, problem))
    error = check_model(peer, problem)
    if batch:
        with np.load(folder / "rows.npz") as rows:
            q, twist = rows["q"], rows["twist"]
        answers, parts = peer.solve(problem.q, problem.twist), [slice(0, len(q))]
        run: Run = lambda part: peer.solve(q, twist)  # noqa: E731
    else:
        answers = np.array([peer.tick(q, twist).copy() for q, twist in zip(problem.q, problem.twist, strict=True)])
        run = tick_run(peer, problem)
        parts = pieces(run, len(problem))
    np.save(folder / f"{key}.npy", answers)
    versions = {name: metadata.version(name) for name in entry.load().packages}
    return run, parts, {"event": "ready", "model_error": error, "versions": versions}


def main() -> None:
    key, folder = sys.argv[1], Path(sys.argv[2])
    messages = private_output()
    try:
        run, parts, said = set_up(key, folder)
    except Exception as error:
        print(json.dumps({"event": "failed", "reason": f"{type(error).__name__}: {error}"}), file=messages)
        raise
    print(json.dumps(said), file=messages)
    gc.collect()
    gc.disable()
    for line in sys.stdin:
        print(json.dumps({"event": "times", "passes": timed(run, parts, float(line))}), file=messages)
        gc.collect()


if __name__ == "__main__":
    main()
