"""The paper's closed-form damping, eq. (12) to (16): its value where the formula has one, its promise everywhere."""

import numpy as np
import pytest

import stillreach as sr
from oracles import equations
from oracles.damping import rate_norm
from oracles.kinematics import INCH, paper_arm

ORDER = {"inf": np.inf, "2": 2}


def distinct(s):
    """Smallest distance between neighbouring singular values, relative to the largest: V is only as certain as that."""
    return np.min(-np.diff(s), initial=s[0]) / s[0]


@pytest.mark.parametrize("norm", ["inf", "2"])
def test_is_eq_16_where_the_pseudoinverse_exceeds_the_limit(norm, paper_cases, ask, tally, tolerance):
    for case in paper_cases:
        out, problem = ask(sr.SingularityRobust, case, damping="closed-form", norm=norm), case.decomposed
        limit = np.max(case.upper[problem.working], initial=0.0)
        tally.keeps_bounds(case, out.rates)
        if problem.kind in ("near the rank tolerance", "no working joint") or problem.rank == 0:
            continue
        if np.any(problem.start[problem.working] != 0):
            tally["a runaway shifts the least motion"] += 1
            continue
        over = rate_norm(problem.rates()[problem.working], norm) / limit
        noise = 1e-9 + 100 * np.finfo(float).eps * problem.condition**2
        if over < 1 - noise:
            tally.holds(out.damping == 0.0, case)
            continue
        v = problem.back @ problem.vt[: problem.rank].T
        beta = problem.u[:, : problem.rank].T @ problem.x
        expected = (np.linalg.norm(v, ORDER[norm]) * np.linalg.norm(beta, ORDER[norm]) / (2 * limit)) ** 2
        if over < 1 + noise:
            tally["at the limit"] += 1
        elif distinct(problem.s[: problem.rank]) > 1e-3:
            tally["compared"] += 1
            off = abs(out.damping / expected - 1)
            outside = np.linalg.norm(problem.x) / np.linalg.norm(beta)  # a twist almost out of reach leaves few digits
            tally.holds(off <= 2 * tolerance(case) * outside, case, off, problem.condition, outside)
        else:
            tally["equal singular values"] += 1
            tally.holds(out.damping > 0, case)
        tally.holds(rate_norm(out.rates[problem.working] / limit, norm) <= 1 + 1e-12, case)
        tally.holds(sr.Status.CLIPPED not in out.status, case)
    tally.settle()


@pytest.mark.parametrize("norm", ["inf", "2"])
@pytest.mark.parametrize("failed", [[], [1, 3, 6]])
def test_eq_16_on_the_papers_arm_in_inches_and_degrees(norm, failed):
    *_, j = paper_arm(np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 10, 20]))
    twist = np.array([0.0, 2.0, 0.0, 0.0, 0.1, 0.0])
    law = sr.SingularityRobust(damping="closed-form", norm=norm, weights=sr.Weights(length=INCH, angle=np.deg2rad(1)))
    out = law.solve(j, twist, sr.Bounds.symmetric(np.deg2rad(20), n=11).lock(failed))
    rows = np.repeat([INCH, np.deg2rad(1)], 3)
    a = equations.failed_rows(np.isin(np.arange(11), failed))
    kappa = equations.eq16(j / rows[:, None] * np.deg2rad(1), twist / rows, a, 20.0, norm)
    assert out.damping == pytest.approx(kappa, rel=1e-9)


def test_never_below_the_exact_damping_and_never_less_error(paper_cases, ask):
    compared = 0
    for case in paper_cases[:3000]:
        shifted = np.any(case.decomposed.start[case.decomposed.working] != 0)
        if case.decomposed.kind != "regular" or case.decomposed.condition > 1e4 or shifted:
            continue
        closed, exact = (ask(sr.SingularityRobust, case, damping=damping) for damping in ("closed-form", "exact"))
        if exact.damping > 0:
            compared += 1
            assert closed.damping >= exact.damping * (1 - 1e-9), case.label
            assert closed.task_error >= exact.task_error * (1 - 1e-9), case.label
    assert compared > 300


def test_jumps_when_it_switches_on():
    # One joint, J = 2, limit 1/2: at twist 1 the pseudoinverse just meets the limit; eq. (16) then asks for (1 / 1)^2.
    law, bounds = sr.SingularityRobust(damping="closed-form"), sr.Bounds.symmetric(0.5, n=1)
    assert law.solve([[2.0]], [1.0 - 1e-9], bounds, row_kinds="v").damping == 0.0
    out = law.solve([[2.0]], [1.0 + 1e-9], bounds, row_kinds="v")
    assert out.damping == pytest.approx(1.0)
    assert out.rates[0] == pytest.approx(0.4)  # 2 / (4 + 1)
