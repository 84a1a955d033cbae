"""How many poses inverse kinematics reaches, and how long it takes: python -m bench.reach [ROBOT ...] [--poses N]."""

from __future__ import annotations

import argparse
import time

import numpy as np

import stillreach as sr
from stillreach.arm.limits import sampling_range

ROBOTS = ("panda", "iiwa14", "gen3", "xarm7", "canadarm2", "sawyer", "rizon4", "talos", "nasa_modular", "snake30")
STARTS = (1, 10, 30, 100, 300)


def measured(arm: sr.Arm, locked: tuple[int, ...], count: int) -> str:
    """Solved shares by number of starts, steps, and times of a pose on one core, as a line."""
    random = np.random.default_rng(5)
    span = sampling_range(arm.kinds, *arm.position_limits.T)
    goal, start = random.uniform(*span, (2, count, arm.n))
    start[:, locked] = goal[:, locked]
    poses = arm.forward(goal)
    began = time.perf_counter()
    result = arm.inverse(poses, start, locked=locked, starts=STARTS[-1], threads=1)
    each = (time.perf_counter() - began) / count * 1e6
    assert np.abs(arm.forward(result.q) - poses)[result.reached].max(initial=0.0) < 1e-8
    shares = "  ".join(f"{np.mean(result.reached & (result.starts <= most)):9.3%}" for most in STARTS)
    hardest = result.steps.max() * each / result.steps.mean()
    name = " ".join(arm.joint_names[i] for i in locked) or "-"
    return f"{name:>18}  {shares}  {result.steps.mean():6.1f}  {each:8.1f}  {hardest:9.0f}"


def main() -> None:
    """Print a table for each robot."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", nargs="*", default=ROBOTS)
    parser.add_argument("--poses", type=int, default=10_000)
    given = parser.parse_args()
    print(f"{given.poses} poses of random configurations within limits, to 1e-9 m and rad, one core")
    for name in given.robots:
        arm = sr.arms.by_name(name)
        heads = "  ".join(f"{f'{most} starts':>9}" for most in STARTS)
        print(f"\n{name}\n{'locked':>18}  {heads}   steps   µs, mean  µs, worst")
        for locked in ((), *((i,) for i in range(arm.n))):
            print(measured(arm, locked, given.poses), flush=True)


if __name__ == "__main__":
    main()
