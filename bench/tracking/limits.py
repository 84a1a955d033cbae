"""What one joint's limit changes: a generous one, and an arm with one joint left."""

import numpy as np

import stillreach as sr
from bench.tracking.setting import Claim, Machine, Part, percent, table, twists
from stillreach import _core

GENEROUS = 1e4
"""[rad/s]"""


def generous(machines: list[Machine], count: int = 500) -> Part:
    """Damped ticks where a joint inside its limit gets a limit of 1e4 rad/s: b stays, and so does the answer.

    Where no two joints share the largest limit, b rises to it if a slower joint gets more: the last column.
    """
    rows, claims = [], []
    for each in machines:
        ratio, moved = [1.0], [0.0]
        law, x = sr.LeastError(), twists(count, each.arm.reach * each.typical / 5.0, 31)
        allowed = [joint for joint in range(each.arm.n) if worth(each, joint) == each.typical]
        for J, twist in zip(each.arm.jacobian(each.poses(count, 30)), x, strict=True):
            usual = law.solve(J, twist, sr.Bounds(-each.limits, each.limits))
            inside = [joint for joint in allowed if abs(usual.rates[joint]) < each.limits[joint]]
            if usual.damping == 0.0 or not inside:
                continue
            limits = with_limit(each, inside[0])
            other = law.solve(J, twist, sr.Bounds(-limits, limits))
            ratio.append(other.damping / usual.damping)
            moved.append(float(np.max(np.abs(other.rates - usual.rates) / each.limits)))
        most = max(worth(each, joint) for joint in range(each.arm.n)) / each.typical
        few = percent(np.array(ratio) < 0.04)
        rows.append((each.name, len(ratio) - 1, few, f"{min(ratio):.9f}", f"{max(moved):.1e}", f"{most:.3f}"))
        text = f"{each.name}: one limit of 1e4 rad/s moves rates by {max(moved):.1e} of a limit"
        claims.append(Claim(text, len(ratio) > 1 and max(moved) <= 1e-9))
    head = ("arm", "damped ticks", "% with under 4 % of the damping", "least ratio", "largest change of a rate / limit")
    return table((*head, "b at most / b, any joint"), rows), claims


def with_limit(each: Machine, joint: int) -> np.ndarray:
    """The limits, one of them generous."""
    limits = each.limits.copy()
    limits[joint] = GENEROUS
    return limits


def worth(each: Machine, joint: int) -> float:
    """b where one joint's limit is generous."""
    return _core.typical_rate(each.metric, with_limit(each, joint))


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
