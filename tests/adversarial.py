"""Drives controllers with ticks that they should not meet, and counts what they answered and which promises broke.

python tests/adversarial.py [--ticks 1000000] [--law NAME] [--seed 0]
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from stillreach import Confined, Derated, FreeSwinging, Locked, OneWay, Runaway, Status
from tests.conformance.attack import HALF_RANGE, SEGMENT, attack, violations
from tests.conformance.registry import LAWS

BLOCK = 10 * SEGMENT
"""Ticks against one controller."""
STEPPED = 10
"""One tick in so many goes through step, the others through the bound tick of a loop."""
KINDS = (
    None,
    lambda value: Locked(),
    Derated,
    Runaway,
    lambda value: Confined(value - HALF_RANGE, value + HALF_RANGE),
    OneWay,
    lambda value: FreeSwinging(),
)


def drive(controller, attack):
    """Rates (K, n) and statuses (K,) of all ticks, and the exceptions that came out of them."""
    ticks, n = attack.q.shape
    rates, status, raised = np.zeros((ticks, n)), np.zeros(ticks, int), Counter()
    q, twist, out = np.zeros(n), np.zeros(6), np.zeros(n)
    tick = controller.bind(q=q, twist=twist, rates=out)
    numbers = np.isfinite(attack.q).all(axis=1) & np.isfinite(attack.twist).all(axis=1)
    for k in range(ticks):
        if k % SEGMENT == 0:
            change_faults(controller, attack, k)
        q[:], twist[:] = attack.q[k], attack.twist[k]
        try:
            if k % STEPPED == 0 and numbers[k]:
                status[k] = controller.step(q, twist, out=out).status
            else:
                status[k] = tick()
        except Exception as error:
            raised[f"raised {type(error).__name__}"] += 1
        rates[k] = out
    return rates, status, raised


def change_faults(controller, attack, k):
    """Fails and restores joints as it is from tick k on."""
    for joint in range(attack.arm.n):
        now = attack.health[k, joint], attack.value[k, joint]
        if k > 0 and now == (attack.health[k - 1, joint], attack.value[k - 1, joint]):
            continue
        if now[0]:
            controller.fail(joint, KINDS[now[0]](*now[1:]))
        else:
            controller.restore(joint)


def campaign(law_name, ticks, seed):
    """Counts of statuses and of broken promises, by name, over at least `ticks` ticks."""
    law, statuses, broken = LAWS[law_name], Counter(), Counter()
    for block in range(-(-ticks // BLOCK)):
        told = attack([seed, block], BLOCK)
        rates, status, raised = drive(told.controller(law.make()), told)
        broken += raised
        broken += Counter(violations(told, rates, status, bounded=law.bounded))
        for flag in Status:
            statuses[flag.name] += int(np.count_nonzero(status & flag))
        statuses["OK"] += int(np.count_nonzero(status == 0))
    return statuses, broken


def report(law_name, ticks, seconds, statuses, broken):
    """A few lines of counts."""
    print(f"{law_name}: {ticks} ticks in {seconds:.1f} s")
    print("    answered " + ", ".join(f"{name} {count}" for name, count in statuses.items() if count))
    print("    broken   " + (", ".join(f"{name} {count}" for name, count in broken.items()) or "none"), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ticks", type=int, default=1_000_000, help="per law")
    parser.add_argument("--law", choices=LAWS, help="only this one")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    failed = False
    for name in [given.law] if given.law else LAWS:
        start = time.perf_counter()
        statuses, broken = campaign(name, given.ticks, given.seed)
        report(name, -(-given.ticks // BLOCK) * BLOCK, time.perf_counter() - start, statuses, broken)
        failed |= broken.total() > 0
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
