"""How fast a survey is, alone and on a Dask cluster, and what that makes of 10^9 configurations.

    python -m bench.survey

Rates are configurations a second on one core. The time of a chunk beside its computation (to hand it out, to collect
and to store it) is measured on a cluster of two processes of this machine; it is serial, in the process that asks.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import stillreach as sr
from bench.timing import machine_note
from stillreach.arm.limits import sampling_range
from stillreach.tolerance.losses import all_sets, least_everywhere, relative

METRICS = ("relative", "speed", "depth")
WORKERS = (1, 16, 64, 256, 1024)
MANY = 10**9
REPEATS = 5
REQUIRED = 200_000
"""Configurations a second and core: relative manipulability of 1,023 sets of 11 joints."""


def best(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """The least time of some runs [s]."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return min(times)


def configurations(arm: sr.Arm, count: int) -> np.ndarray:
    low, high = sampling_range(arm.kinds, *arm.position_limits.T)
    return np.random.default_rng(0).uniform(low, high, (count, arm.n))


def kernels() -> None:
    """The compiled passes alone."""
    print(f"{'arm':<14}{'joints':>7}{'k':>3}{'sets':>7}{'relative /s':>14}{'of which sets /s':>18}{'speeds /s':>12}")
    for name, k in (("nasa_modular", 5), ("talos", 3), ("panda", 2), ("panda", 1)):
        arm = sr.arms.by_name(name)
        q, few = configurations(arm, 40_000), configurations(arm, 4_000)
        rate = len(q) / best(lambda arm=arm, q=q, k=k: relative(arm, q, k, threads=1))
        speeds = len(few) / best(lambda arm=arm, q=few, k=k: least_everywhere(arm, q, k, threads=1))
        sets = len(all_sets(arm.n, k))
        print(f"{name:<14}{arm.n:>7}{k:>3}{sets:>7}{rate:>14,.0f}{rate * sets:>18,.0f}{speeds:>12,.0f}", flush=True)
        if sets == 1023:
            print(f"{'':<14}required: {REQUIRED:,} /s: {'met' if rate >= REQUIRED else 'NOT met'}")


def whole(folder: Path) -> dict[str, tuple[float, int]]:
    """Surveys in this process on one thread, stored: configurations a second of processor time, and of a chunk.

    Cells of positions are searched once with all joints, before: that is no part of the rate.
    """
    print(f"\n{'a survey, stored':<44}{'configurations':>15}{'seconds':>9}{'a second':>11}")
    rates = {}
    for label, name, k, metrics, count, chunk in (
        ("11 joints, k = 5: relative", "nasa_modular", 5, "relative", 1_000_000, 250_000),
        ("11 joints, k = 5: relative, speed, depth", "nasa_modular", 5, METRICS, 100_000, 100_000),
        ("Panda, k = 2: relative, speed, depth", "panda", 2, METRICS, 500_000, 250_000),
        ("Panda, k = 1: reach", "panda", 1, "reach", 4_000, 4_000),
        ("Panda, k = 1: positions", "panda", 1, "positions", 4_000, 4_000),
    ):
        arm = sr.arms.by_name(name)
        settings = {"k": k, "metrics": metrics, "threads": 1, "progress": False}
        sr.tolerance.survey(arm, folder / f"{label} warm", samples=100, **settings)
        began = time.process_time()
        sr.tolerance.survey(arm, folder / label, samples=count, chunk=chunk, **settings)
        seconds = time.process_time() - began
        rates[label] = count / seconds, max(chunk, 20_000)
        print(f"{label:<44}{count:>15,}{seconds:>9.2f}{count / seconds:>11,.0f}", flush=True)
    return rates


def overhead(folder: Path) -> float:
    """[s] of the asking process for a chunk on a cluster: chunks of one configuration."""
    import distributed

    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as made,
        distributed.Client(made) as client,
    ):
        settings = {"k": 5, "client": client, "chunk": 1, "metrics": METRICS, "progress": False}
        arm = sr.arms.nasa_modular()
        sr.tolerance.survey(arm, folder / "warm", samples=8, **settings)
        began = time.perf_counter()
        sr.tolerance.survey(arm, folder / "chunks", samples=200, **settings)
        return (time.perf_counter() - began) / 200


def shown(seconds: float) -> str:
    for unit, size in (("d", 86_400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.0f} s"


def main() -> None:
    argparse.ArgumentParser(description=__doc__.split("\n")[0]).parse_args()
    print(machine_note(len(os.sched_getaffinity(0))), "\n")
    kernels()
    with tempfile.TemporaryDirectory() as name:
        rates = whole(Path(name))
        try:
            each = overhead(Path(name))
        except ImportError as error:
            print(f"\nno cluster: {error}")
            return
    print(f"\na chunk of one configuration on two workers: {1e3 * each:.1f} ms, to hand out, collect and store\n")
    heads = "".join(f"{f'{count} cores':>12}" for count in WORKERS)
    print(f"{f'extrapolated to {MANY:.0e} configurations':<44}{'a chunk':>9}{heads}")
    for label, (rate, chunk) in rates.items():
        times = [max(MANY / rate / count, MANY / chunk * each) for count in WORKERS]
        print(f"{label:<44}{chunk:>9,}{''.join(f'{shown(seconds):>12}' for seconds in times)}")
    print("the larger of computation by all cores and chunks by the asking process; larger chunks lower the second")


if __name__ == "__main__":
    main()
