"""What one joint's limit changes: a generous one, and an arm with one joint left."""

import numpy as np

import stillreach as sr
from bench.tracking.setting import Claim, Machine, Part, percent, table, twists

GENEROUS = 1e4
"""[rad/s]"""


def generous(machines: list[Machine], count: int = 500) -> Part:
    """Infeasible ticks, where a joint that is not at its limit gets a limit of 1e4 rad/s: nothing may change."""
    rows, claims = [], []
    for each in machines:
        ratio, moved = [], []
        law, x = sr.LeastError(), twists(count, 2.0 * each.arm.reach * each.typical / 10.0, 31)
        for J, twist in zip(each.arm.jacobian(each.poses(count, 30)), x, strict=True):
            usual = law.solve(J, twist, sr.Bounds(-each.limits, each.limits))
            if usual.damping == 0.0:
                continue
            inside = np.flatnonzero(np.abs(usual.rates) < each.limits)
            for joint in inside[:1]:
                limits = each.limits.copy()
                limits[joint] = GENEROUS
                other = law.solve(J, twist, sr.Bounds(-limits, limits))
                ratio.append(other.damping / usual.damping)
                moved.append(np.max(np.abs(other.rates - usual.rates) / each.limits))
        few = percent(np.array(ratio) < 0.04)
        rows.append((each.name, len(ratio), few, f"{np.min(ratio):.6f}", f"{np.max(moved):.1e}"))
        same = len(ratio) > 0 and float(np.max(moved)) <= 1e-6
        claims.append(Claim(f"{each.name}: one limit of 1e4 rad/s moves rates by {np.max(moved):.1e} of a limit", same))
    head = ("arm", "damped ticks", "% with under 4 % of the damping", "least ratio", "largest change of a rate / limit")
    return table(head, rows), claims


def one_joint(machines: list[Machine]) -> Part:
    """One joint works, and is asked for its own motion at half its limit, and for five times the limit."""
    rows, claims = [], []
    for each in machines:
        done, fast = [], []
        for q in each.poses(20, 32):
            for joint in range(each.arm.n):
                limits = np.where(np.arange(each.arm.n) == joint, each.limits, 0.0)
                column, bounds = each.arm.jacobian(q)[:, joint], sr.Bounds(-limits, limits)
                for share, shown in ((0.5, done), (5.0, fast)):
                    rates = sr.LeastError().solve(each.arm.jacobian(q), share * limits[joint] * column, bounds).rates
                    shown.append(rates[joint] / limits[joint])
        rows.append((each.name, f"{np.min(done):.6f}", f"{np.max(done):.6f}", f"{np.min(fast):.6f}"))
        moves = abs(np.min(done) - 0.5) < 1e-9 and abs(np.max(done) - 0.5) < 1e-9 and np.min(fast) == 1.0
        claims.append(Claim(f"{each.name}: an arm with one working joint moves", bool(moves)))
    head = ("arm", "asked for 0.5 of its limit: least", "most", "asked for 5: least")
    return table(head, rows), claims
