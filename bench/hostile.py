"""The slowest of many hostile ticks under every law: what a control loop has to leave room for.

Singular and nearly singular poses, faults that come and go, bounds that leave no rest, tiny and huge twists, as
``tests/conformance/attack.py`` makes them; the laws are those of ``tests/conformance/registry.py``. Each controller's
ticks are driven several times, and the shortest time of each tick counts, so that what else the machine does does not.
"""

import gc
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

import stillreach as sr
from tests.adversarial import BLOCK, change_faults
from tests.conformance.attack import SEGMENT, Attack, attack
from tests.conformance.registry import LAWS

TICKS, REPEATS = 100_000, 7
BUDGET = 20.0
"""[µs] for the slowest tick of any law, on a quiet core."""


@dataclass(frozen=True)
class Hostile:
    """[µs] of a bound tick from Python: the median and the slowest."""

    law: str
    median: float
    slowest: float


def hostile_ticks(ticks: int = TICKS, repeats: int = REPEATS, seed: int = 0) -> Iterator[Hostile]:
    """The figures of every law, over about so many ticks."""
    attacks = [attack([seed, block], BLOCK) for block in range(-(-ticks // BLOCK))]
    for name, contract in LAWS.items():
        least = np.concatenate([shortest_times(contract.make(), told, repeats) for told in attacks])
        yield Hostile(name, 1e-3 * float(np.median(least)), 1e-3 * float(np.max(least)))


def shortest_times(law: sr.Law, told: Attack, repeats: int) -> np.ndarray:
    """(K,) [ns] the shortest time of each tick of one controller."""
    gc.disable()
    try:
        return np.min([_times(law, told) for _ in range(repeats)], axis=0)
    finally:
        gc.enable()


def _times(law: sr.Law, told: Attack) -> np.ndarray:
    """(K,) [ns] each tick of a new controller."""
    controller, clock = told.controller(law), time.perf_counter_ns
    q, twist = np.zeros(told.arm.n), np.zeros(6)
    tick = controller.bind(q=q, twist=twist, rates=np.zeros(told.arm.n))
    times = np.zeros(len(told.q), dtype=np.int64)
    for k in range(len(times)):
        if k % SEGMENT == 0:
            change_faults(controller, told, k)
        q[:], twist[:] = told.q[k], told.twist[k]
        began = clock()
        tick()
        times[k] = clock() - began
    return times


def print_hostile(ticks: int) -> None:
    """Markdown; times in µs a call, law by law as they are measured."""
    slowest = f"slowest of {ticks:,} hostile ticks (minimum of {REPEATS} repeats) [µs]"
    print(f"\n| law | median [µs] | {slowest} | budget [µs] |")
    print("|---|---:|---:|---:|")
    for row in hostile_ticks(ticks):
        over = "" if row.slowest <= BUDGET else " (over)"
        print(f"| {row.law} | {row.median:.2f} | {row.slowest:.1f} | {BUDGET:g}{over} |", flush=True)
