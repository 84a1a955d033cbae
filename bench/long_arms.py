"""What a tick costs as an arm grows: n from 4 to 500 joints, bound buffers, every law; minima over short paths.

The last column but one is the cost at n = 500 over the straight line through the cost at n = 50 and the origin: 1 is
linear growth, less is better.
"""

import argparse
import gc
import time
from collections.abc import Callable, Iterator

import numpy as np

import stillreach as sr
from bench.timing import machine_note, pin_to_one_core
from stillreach import _core

SIZES = (4, 6, 8, 11, 16, 25, 50, 100, 200, 350, 500)
Tick = Callable[[], object]
LIMIT = np.deg2rad(50.0)
FROM, ALLOWED = 50, 1.3
"""Costs grow from this n on by no more than this times what a straight line would."""
OVER = 1.5
"""How far the pseudoinverse's largest rate is over the limit."""
PATHS, STEPS = 8, 32
TOGETHER = 500
"""Ticks that are timed in one piece, times joints: short enough to fit between what else the machine does."""
LAWS: dict[str, sr.Law] = {
    "`Pseudoinverse`": sr.Pseudoinverse(),
    "`SingularityRobust`, κ given": sr.SingularityRobust(damping=0.01),
    "`SingularityRobust`, closed form": sr.SingularityRobust(damping="closed-form"),
    "`SingularityRobust`, exact": sr.SingularityRobust(damping="exact"),
    "`LeastError()`": sr.LeastError(),
    "`LeastError(price=None)`": sr.LeastError(price=None),
}
COLD = ("`LeastError()`", "`LeastError(price=None)`")
"""Also printed as what the first tick costs, which knows nothing of the last one's active bounds."""


def work(n: int, seed: int = 7) -> tuple[sr.Arm, np.ndarray, np.ndarray]:
    """An arm that bends both ways, q (paths, steps, n) along short paths, twist (paths, 6) over the limits."""
    arm, random = sr.arms.snake(n), np.random.default_rng([seed, n])
    spread = min(1.0, 4.0 / np.sqrt(n))  # a long arm that turns at random curls up; this keeps it stretched
    start = random.uniform(-spread, spread, (PATHS, 1, n))
    along = random.uniform(-1e-3, 1e-3, (PATHS, 1, n))
    q = start + np.arange(STEPS)[:, None] * along
    twist = random.normal(size=(PATHS, 6))
    for path, J in enumerate(arm.jacobian(q[:, 0])):
        twist[path] *= OVER * LIMIT / np.max(np.abs(np.linalg.pinv(J) @ twist[path]))
    return arm, q, twist


def runs(
    law: sr.Law, arm: sr.Arm, q: np.ndarray, twist: np.ndarray, *, cold: bool
) -> Iterator[Callable[[], list[float]]]:
    """For each path a function that goes along it and returns what a tick took [µs], piece by piece."""
    ctl, rates = sr.Controller(arm, law=law, velocity_limits=LIMIT), np.zeros(arm.n)
    for path, direction in zip(q, twist, strict=True):
        ticks = [ctl.bind(q=row, twist=direction, rates=rates) for row in path]
        yield (lambda ticks=ticks: first_ticks(ctl, ticks)) if cold else (lambda ticks=ticks: warm_ticks(ticks, arm.n))


def warm_ticks(ticks: list[Tick], n: int) -> list[float]:
    """The first tick is not counted: it finds the active bounds of its path. Long arms' ticks fill a piece each."""
    ticks[0]()
    times, together = [], max(1, min(len(ticks) - 1, TOGETHER // n))
    for first in range(1, len(ticks), together):
        piece = ticks[first : first + together]
        began = time.perf_counter_ns()
        for tick in piece:
            tick()
        times.append((time.perf_counter_ns() - began) / (1e3 * len(piece)))
    return times


def first_ticks(ctl: sr.Controller, ticks: list[Tick]) -> list[float]:
    """Everything is forgotten before each tick; that is not counted."""
    times = []
    for tick in ticks[:: len(ticks) // 4]:
        ctl.reset()
        began = time.perf_counter_ns()
        tick()
        times.append((time.perf_counter_ns() - began) / 1e3)
    return times


def measured(law: sr.Law, sizes: list[int], repeats: int, *, cold: bool = False) -> dict[int, float]:
    """[µs] a tick by size: the mean over the pieces of all paths of the minimum over the repeats.

    Each repeat goes through all sizes, so that a slow minute of the machine is one for all of them.
    """
    paths = {n: list(runs(law, *work(n), cold=cold)) for n in sizes}
    times: dict[int, list[list[list[float]]]] = {n: [] for n in sizes}
    for _ in range(1 + repeats):
        for n in sizes:
            times[n].append([run() for run in paths[n]])
    return {n: float(np.mean(np.min(rounds[1:], axis=0))) for n, rounds in times.items()}


def line(name: str, costs: dict[int, float], allowed: float | None) -> str:
    """A row of the table."""
    growth = "-"
    if FROM in costs and max(costs) > FROM:
        ratio = costs[max(costs)] / (costs[FROM] * max(costs) / FROM)
        growth = f"{ratio:.2f}" if allowed is None else f"{ratio:.2f} ({'met' if ratio <= allowed else 'MISSED'})"
    return f"| {name} | " + " | ".join(f"{value:.3g}" for value in costs.values()) + f" | {growth} |"


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m bench.long_arms", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=30, help="of each path (default %(default)s)")
    parser.add_argument("--sizes", default=",".join(map(str, SIZES)), help="numbers of joints (default %(default)s)")
    asked = parser.parse_args()
    sizes = [int(n) for n in asked.sizes.split(",")]
    cores = pin_to_one_core()
    gc.disable()
    print(f"| a tick, bound buffers [µs]; n = | {' | '.join(map(str, sizes))} | over linear from {FROM} |")
    print("|---" + "|---:" * (len(sizes) + 1) + "|")
    for name, law in LAWS.items():
        print(line(name, measured(law, sizes, asked.repeats), ALLOWED), flush=True)
    for name in COLD:
        print(line(f"{name}, cold", measured(LAWS[name], sizes, asked.repeats, cold=True), None), flush=True)
    note = f"Kernel for {_core.instruction_set()}. {machine_note(cores)}"
    print(f"\nAllowed for all but the cold ones: {ALLOWED:g}. {note}")


if __name__ == "__main__":
    main()
