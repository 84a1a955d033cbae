"""Who computes the chunks of a survey: this process, a child with another instruction set, or a Dask cluster."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

from stillreach import _core
from stillreach._door import FloatArray
from stillreach.errors import InputError
from stillreach.simulation.progress import Progress
from stillreach.tolerance.surveys.arrays import Arrays
from stillreach.tolerance.surveys.measure import measured
from stillreach.tolerance.surveys.plan import Plan
from stillreach.tolerance.surveys.store import Build, Store

VARIABLE = "STILLREACH_INSTRUCTIONS"
BASELINE = "baseline"
AHEAD = 3
"""Chunks that are under way for each thread of a cluster."""


def expected_build(baseline: bool) -> Build:
    """The build whose bits a survey has."""
    own = Build.here()
    return own._replace(instructions=BASELINE) if baseline else own


def finish(plan: Plan, store: Store, build: Build, client: Any, threads: int | None, progress: bool | None) -> None:
    """Computes the chunks that are missing, and stores each as soon as it is there."""
    done = store.done
    left = [index for index in range(plan.chunks) if not done[index]]
    if not left:
        return
    if client is None and Build.here() != build:
        _in_child(plan, store, threads, progress)
        return
    count = sum(plan.size(index) for index in range(plan.chunks) if done[index])
    results = _here(plan, left, threads) if client is None else _on_cluster(plan, left, build, client)
    with Progress(f"survey of {plan.arm.name}", plan.count, progress) as bar:
        for index, arrays in results:
            store.write(plan, index, arrays)
            count += plan.size(index)
            bar.update(count)


def _here(plan: Plan, left: list[int], threads: int | None) -> Iterator[tuple[int, Arrays]]:
    for index in left:
        yield index, measured(plan, index, plan.own(index), threads)


def _in_child(plan: Plan, store: Store, threads: int | None, progress: bool | None) -> None:
    """The same in a new process, because this one has chosen its instruction set already."""
    code = "from stillreach.tolerance.surveys.run import child; child()"
    work = pickle.dumps((plan, str(store.folder), threads, progress))
    variables = {**os.environ, VARIABLE: BASELINE}
    done = subprocess.run([sys.executable, "-c", code], input=work, env=variables, stdout=subprocess.PIPE, check=False)
    if done.returncode:
        raise pickle.loads(done.stdout) if done.stdout else KeyboardInterrupt


def child() -> None:
    """Finishes the survey that comes on standard input; an error goes to standard output."""
    try:
        plan, folder, threads, progress = pickle.load(sys.stdin.buffer)
        finish(plan, Store(Path(folder)), Build.here(), None, threads, progress)
    except KeyboardInterrupt:
        sys.exit(1)
    except Exception as error:
        sys.stdout.buffer.write(pickle.dumps(error))
        sys.exit(1)


def facts(baseline: bool) -> Build:
    """The build of a worker, after choosing its instruction set where that is still open."""
    if baseline:
        os.environ[VARIABLE] = BASELINE
    return Build.here()


def chunk(baseline: bool, work: bytes, index: int, given: FloatArray | None) -> tuple[Build, Arrays | None]:
    """A chunk, computed by a worker on one thread: its build, and the arrays if the instruction set is the right one.

    The plan comes as bytes: an arm chooses the instruction set as soon as it is made.
    """
    build = facts(baseline)
    if baseline and _core.instruction_set() != BASELINE:
        return build, None
    plan: Plan = pickle.loads(work)
    return build, measured(plan, index, given, 1)


def _on_cluster(plan: Plan, left: list[int], build: Build, client: Any) -> Iterator[tuple[int, Arrays]]:
    """Chunks as the workers of a Dask cluster finish them; a chunk whose worker dies begins anew on another."""
    import distributed

    as_completed: Any = distributed.as_completed
    baseline = build.instructions == BASELINE
    for worker, own in client.run(facts, baseline).items():
        _check(worker, own, build)
    work, waiting = pickle.dumps(plan.alone()), iter(left)
    places: dict[Any, int] = {}

    def submit(count: int) -> list[Any]:
        futures = []
        for index in islice(waiting, count):
            future = client.submit(chunk, baseline, work, index, plan.own(index), pure=False)
            places[future] = index
            futures.append(future)
        return futures

    threads = sum(client.nthreads().values())
    running = as_completed(submit(max(AHEAD * threads, 2)))
    for future in running:
        own, arrays = future.result()
        _check("a worker", own, build)
        assert arrays is not None
        yield places.pop(future), arrays
        running.update(submit(1))


def _check(worker: str, own: Build, build: Build) -> None:
    if own != build:
        advice = (
            f"start the workers with {VARIABLE}={BASELINE}"
            if build.instructions == BASELINE
            else f"baseline=True makes instruction sets alike, {VARIABLE} names one"
        )
        raise InputError("client", f"{worker}, which has {own}", f"{build}; {advice}")
