"""How fast a rehearsal is: ticks a second and core, beside the bare batch of rollouts, and two tasks of 20 s.

    python -m bench.rehearse

The bare batch has no feedback on a pose, no controller's limits and no record; a rehearsal has them all.
"""

import argparse
import os
import time

import numpy as np

import stillreach as sr
from bench.timing import machine_note

PERIOD, SECONDS = 0.01, 20.0


def task(arm: sr.Arm, start: np.ndarray) -> sr.Scenario:
    """A circle of 20 s, in closed loop."""
    motion = sr.Circle(centre=[0.0, 0.05, 0.0], axis=[1, 0, 0], duration=SECONDS, relative=True)
    return sr.Scenario(arm=arm, start=start, motion=motion, loop="closed", period=PERIOD)


def batch_rate(arm: sr.Arm, start: np.ndarray, rows: int = 256, steps: int = 200) -> float:
    """Ticks a second of a batch of rollouts on one thread, the best of five."""
    twists = np.tile([0.0, 0.01, 0.005, 0.0, 0.0, 0.0], (rows, 1))
    bounds = sr.Bounds.symmetric(1.0, n=arm.n).lock([2])
    best = np.inf
    for _ in range(5):
        began = time.perf_counter()
        sr.rollout_batch(
            arm, sr.LeastError(), np.tile(start, (rows, 1)), twists, bounds, period=PERIOD, steps=steps, threads=1
        )
        best = min(best, time.perf_counter() - began)
    return rows * steps / best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    panda = sr.arms.panda(), np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
    nasa = sr.arms.nasa_modular(), np.deg2rad([0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0])
    print(machine_note(len(os.sched_getaffinity(0))), "\n")
    print(f"{'rehearsal':<42}{'failures':>9}{'ticks':>8}{'threads':>8}{'median':>9}{'best':>8}{'M ticks/s':>11}")
    for name, (arm, start), kinds, onsets, threads in (
        ("11 joints, locked, 100 moments", nasa, ("locked",), 100, 1),
        ("11 joints, locked, 100 moments", nasa, ("locked",), 100, 2),
        ("Panda, 3 kinds, 1000 moments", panda, ("locked", "derated", "confined"), 1000, 1),
        ("Panda, 3 kinds, 1000 moments", panda, ("locked", "derated", "confined"), 1000, 2),
    ):
        scenario, seconds = task(arm, start), []
        for _ in range(arguments.repeats):
            began = time.perf_counter()
            found = sr.tolerance.rehearse(scenario, kinds=kinds, onsets=onsets, threads=threads, known_after=0.04)
            seconds.append(time.perf_counter() - began)
        ticks, best = found.ticks / 1e6, min(seconds)
        row = f"{name:<42}{found.cause.size:>9}{ticks:>7.1f}M{threads:>8}"
        print(f"{row}{np.median(seconds):>8.2f}s{best:>7.2f}s{ticks / best:>11.2f}", flush=True)
    for name, (arm, start) in (("Panda", panda), ("11 joints", nasa)):
        print(f"bare batch of rollouts, {name}, one thread: {batch_rate(arm, start) / 1e6:.2f} M ticks/s")


if __name__ == "__main__":
    main()
