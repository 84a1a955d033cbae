"""Exact damping, eq. (9) and (10): the smallest damping factor that meets the limit."""

import numpy as np
import pytest

import stillreach as sr
from oracles.cases import law_cases
from oracles.damping import rate_norm, rates_at, smallest_damping

EPS = np.finfo(float).eps
LAW = sr.SingularityRobust(damping="exact")


def noise(problem, limit, kappa):
    """What rounding in J and the twist makes of the relative rates at `kappa`."""
    s = problem.s[: problem.rank]
    twist = np.linalg.norm(problem.x) * problem.back_size * np.max(s / (s**2 + kappa), initial=0.0)
    return 100 * EPS * (problem.condition + twist / limit)


@pytest.mark.parametrize("norm", ["inf", "2"])
def test_is_the_smallest_that_meets_the_limit(norm, paper_cases, ask, tally, distance, tolerance):
    for case in paper_cases:
        out, problem = ask(sr.SingularityRobust, case, damping="exact", norm=norm), case.decomposed
        damped = bool(out.status & sr.Status.DAMPED)
        tally[problem.kind + (", damped" if damped else "")] += 1
        tally.keeps_bounds(case, out.rates)
        tally.holds(damped == (out.damping > 0), case)
        tally.holds(sr.Status.ITERATION_LIMIT not in out.status, case)
        if problem.kind in ("near the rank tolerance", "no working joint"):
            continue
        limit = np.max(case.upper[problem.working])
        offset = problem.start[problem.working] / limit
        if rate_norm(offset, norm) >= 1:
            tally["a runaway and a weight leave no room"] += 1
            continue
        rounding = noise(problem, limit, out.damping)
        slack = 2e-9 + rounding
        used = rate_norm(out.rates[problem.working] / limit, norm)
        tally.holds(used <= 1 + 1e-12, case, used)
        c, s2 = problem.coefficients
        if damped:
            tally.holds(used >= 1 - 1e-9, case, used, problem.condition)
            below = smallest_damping(c / limit, s2, norm, 1 - slack, offset, up_to=out.damping)
            tally.holds(below is None, case, below or 0.0, out.damping)
        else:
            undamped = rate_norm(rates_at(c / limit, s2, 0.0, offset), norm)
            tally.holds(undamped <= 1 + slack, case, undamped)
        if rounding < 1e-10:
            off = distance(case, out.rates, problem.rates(out.damping))
            tally.holds(off <= 1e-9 + tolerance(case), case, off)
    tally.settle()


def test_agrees_with_the_scan_of_the_whole_axis(ask, tally):
    for case in law_cases(1500, 8, scaled=0.3):
        problem, limit = case.decomposed, np.max(case.upper)
        if problem.kind != "regular" or problem.condition > 1e4:
            continue
        c, s2 = problem.coefficients
        for norm in ("inf", "2"):
            kappa = ask(sr.SingularityRobust, case, damping="exact", norm=norm).damping
            least, most = (smallest_damping(c / limit, s2, norm, 1 + d) for d in (1e-10, -2e-9))
            assert least * (1 - 1e-9) <= kappa <= most * (1 + 1e-9), case.label
            tally["compared"] += 1


def worked_example():
    """J = diag(1, 0.01) R(22.5 deg)': along kappa its largest rate rises from 1 to 1.197 before it falls."""
    c, s = np.cos(np.pi / 8), np.sin(np.pi / 8)
    j = np.diag([1.0, 0.01]) @ np.array([[c, s], [-s, c]])
    return j, j @ np.ones(2)


def test_the_damping_jumps_in_the_worked_example():
    j, twist = worked_example()
    below = LAW.solve(j, twist, sr.Bounds.symmetric(1.0 + 1e-9, n=2), row_kinds="vv")
    above = LAW.solve(j, twist, sr.Bounds.symmetric(1.0 - 1e-9, n=2), row_kinds="vv")
    assert below.damping == 0.0
    np.testing.assert_allclose(below.rates, 1.0, rtol=1e-9)
    assert above.damping == pytest.approx(0.207, abs=5e-4)
    np.testing.assert_allclose(np.max(np.abs(above.rates)), 1.0, rtol=1e-8)
    grid = np.linspace(0.0, above.damping, 5001)[:-1]
    largest = [np.max(np.abs(j.T @ np.linalg.solve(j @ j.T + k * np.eye(2), twist))) for k in grid]
    assert min(largest) > 1.0 - 1e-9
    assert max(largest) == pytest.approx(1.197, abs=5e-4)


def test_the_jump_is_in_the_twist_too():
    j, twist = worked_example()
    bounds = sr.Bounds.symmetric(1.0, n=2)
    dampings = [LAW.solve(j, s * twist, bounds, row_kinds="vv").damping for s in (1 - 1e-6, 1 + 1e-6)]
    assert dampings[0] == 0.0
    assert dampings[1] > 0.2


def test_one_joint_by_hand():
    # 2 x / (4 + kappa) = limit at kappa = 2 x / limit - 4.
    out = LAW.solve([[2.0]], [3.0], sr.Bounds.symmetric(0.5, n=1), row_kinds="v")
    assert out.damping == pytest.approx(8.0, rel=1e-8)
    assert out.rates[0] == pytest.approx(0.5, rel=1e-9)
    assert out.rates[0] <= 0.5


def test_all_joints_failed():
    j, twist = worked_example()
    for damping in ("exact", "closed-form", 0.1):
        law = sr.SingularityRobust(damping=damping)
        out = law.solve(j, twist, sr.Bounds.symmetric(1.0, n=2).lock([0, 1]), row_kinds="vv")
        np.testing.assert_array_equal(out.rates, (0.0, 0.0))
        assert out.status & sr.Status.NO_WORKING_JOINT
        np.testing.assert_array_equal(out.residual, twist)


def test_per_joint_limits_by_hand():
    # J = (1, 1), limits 1 and 3: J D = (1, 3), so u goes like (1, 3) and dq = D u like (1, 9); u_2 is the first at 1.
    out = LAW.solve([[1.0, 1.0]], [8.0], sr.Bounds([-1.0, -3.0], [1.0, 3.0]), row_kinds="v")
    assert out.rates[1] == pytest.approx(9 * out.rates[0], rel=1e-9)
    assert out.rates[1] == pytest.approx(3.0, rel=1e-9)


def test_a_joint_pushed_against_a_zero_bound_is_held_and_the_rest_solved_again():
    # Alone, the pseudoinverse would share the twist; joint 1 may only move backwards, so joint 2 does it all.
    out = LAW.solve([[1.0, 1.0]], [1.0], sr.Bounds([-1.0, -2.0], [0.0, 2.0]), row_kinds="v")
    np.testing.assert_allclose(out.rates, (0.0, 1.0), atol=1e-12)
    assert out.damping == 0.0
