"""KeepDirection: the largest fraction of the twist that the bounds allow, in exactly its direction.

Weak duality judges every case, a linear program (HiGHS) a sample and the cases that duality leaves open, the same in
rational arithmetic those where HiGHS says otherwise; STILLREACH_FULL=1 shows the linear program all of them.
"""

import os

import numpy as np
import pytest
from scipy import optimize

import stillreach as sr
from oracles import box, exact
from oracles.kinematics import planar_arm

SAMPLE = 20_000 if os.environ.get("STILLREACH_FULL") else 500


def out_of_reach(case):
    """Length of the part of the twist that the working joints cannot serve, relative to the twist."""
    problem = case.decomposed
    u = problem.u[:, : problem.rank]
    return np.linalg.norm(problem.x - u @ (u.T @ problem.x)) / (np.linalg.norm(problem.x) or 1.0)


@pytest.mark.timeout(600)
def test_no_larger_fraction_is_feasible(bound_cases, ask, tally):
    for i, case in enumerate(bound_cases):
        out, problem = ask(sr.KeepDirection, case), case.boxed
        tally.keeps_bounds(case, out.rates)
        tally.holds(0.0 <= out.scale <= 1.0, case, out.scale)
        if case.decomposed.kind != "regular" or case.decomposed.condition > 1e6:
            tally["only bounds: " + case.decomposed.kind.replace("regular", "nearly singular")] += 1
            continue
        if 1e-14 < out_of_reach(case) < 1e-4:
            tally["only bounds: direction at the edge of reach"] += 1
            continue
        rates = out.rates / problem.unit
        if out.scale > 0:
            off = problem.j @ rates - out.scale * problem.x
            size = 1.0 + np.linalg.norm(problem.j) * np.linalg.norm(rates)
            tally.holds(np.linalg.norm(off) <= 1e-10 * size, case, np.linalg.norm(off) / size)
        bound = box.scale_bound(problem.j, problem.x, problem.lower, problem.upper, rates)
        proved = out.scale >= 1.0 or (out.scale > 0 and bound <= out.scale + 1e-9)
        tally["proved by duality" if proved else "left to the linear program"] += 1
        if not proved or i < SAMPLE:
            best, off = box.largest_scale(problem.j, problem.x, problem.lower, problem.upper)
            tally["linear programs"] += 1
            if off > 1e-13 * (1.0 + np.linalg.norm(rates)):
                tally["the linear program leaves the direction"] += 1
                continue
            if not abs(out.scale - (best or 0.0)) <= 1e-9:
                tally["settled by exact arithmetic"] += 1
                best = exact.largest_scale(problem.j, problem.x, problem.lower, problem.upper)
            tally.holds(abs(out.scale - (best or 0.0)) <= 1e-9, case, out.scale, best or 0.0, case.decomposed.condition)
    tally.settle()


def test_then_the_nearest_to_the_reference(bound_cases, ask, tally):
    rng = np.random.default_rng(31)
    for case in bound_cases[:5000]:
        problem = case.boxed
        if case.decomposed.kind != "regular" or case.decomposed.condition > 1e3:
            continue
        reference = np.where(case.failed, 0.0, rng.normal(size=case.j.shape[1]) * problem.unit * rng.choice([0.0, 1.0]))
        out = ask(sr.KeepDirection, case, reference=reference)
        rates, target = out.rates / problem.unit, reference / problem.unit
        if out.scale == 0:
            continue
        nearest = box.nearest_same_motion(problem.j, rates, problem.lower, problem.upper, target, problem.weight)
        if nearest is None:
            tally["the solver gave up"] += 1
            continue
        tally["compared"] += 1
        ours, theirs = (np.sqrt((r - target) @ problem.weight @ (r - target)) for r in (rates, nearest))
        tally.holds(ours <= theirs * (1 + 1e-6) + 1e-9, case, ours, theirs)
    tally.settle()
    assert tally["compared"] > 500


def test_ordinary_rows_never_meet_the_bound_on_the_steps(capsys):
    """1.7 % once did: beside the largest fraction the first search cannot tell its last bounds from rounding."""
    arm, rng, count = sr.arms.nasa_modular(), np.random.default_rng(33), 10_000
    q = rng.uniform(-2.0, 2.0, (count, arm.n))
    twist = rng.normal(size=(count, 6)) * 10.0 ** rng.uniform(-1.5, 0.5, (count, 1))
    for failed in ((), (1, 3, 6)):
        out = sr.solve_batch(arm, sr.KeepDirection(), q, twist, sr.Bounds.symmetric(0.9, n=arm.n).lock(failed))
        scaled, stopped = (
            np.count_nonzero(out.status & int(flag)) for flag in (sr.Status.SCALED, sr.Status.ITERATION_LIMIT)
        )
        with capsys.disabled():
            print(
                f"\n  {len(failed)} failed: ITERATION_LIMIT in {stopped} of {count} rows, {scaled} of them scaled",
                end="",
            )
        assert scaled > count // 4
        assert stopped == 0


def test_the_worked_planar_arm():
    _, j = planar_arm(np.deg2rad([20, 50, -30, 40]))
    twist, limits = np.array([1.8, 2.4]), np.array([0.5, 0.5, 1.0, 1.0])
    out = sr.KeepDirection().solve(j, twist, sr.Bounds(-limits, limits), row_kinds="vv")
    assert out.scale == pytest.approx(0.2227372, abs=5e-8)
    assert out.status & sr.Status.SCALED
    np.testing.assert_allclose(j @ out.rates, out.scale * twist, atol=1e-12)
    assert out.scale > np.min(limits / np.abs(np.linalg.pinv(j) @ twist))  # scaling the pseudoinverse gives less


def test_a_feasible_twist_is_done_in_full_with_the_least_motion():
    j, twist = np.random.default_rng(32).normal(size=(6, 9)), np.full(6, 0.1)
    out = sr.KeepDirection().solve(j, twist, sr.Bounds.symmetric(10.0, n=9))
    assert out.scale == 1.0
    assert not out.status & sr.Status.SCALED
    np.testing.assert_allclose(out.rates, np.linalg.pinv(j) @ twist, atol=1e-10)


def test_a_runaway_that_cannot_be_compensated_leaves_the_best_standstill():
    # One row, two joints; the runaway does -3, the other can make up for 0.5: LeastError's answer for twist 0.
    bounds = sr.Bounds([-3.0, -0.5], [-3.0, 0.5])
    out = sr.KeepDirection().solve([[1.0, 1.0]], [4.0], bounds, row_kinds="v")
    assert out.scale == 0.0
    np.testing.assert_allclose(out.rates, (-3.0, 0.5))


def test_a_direction_out_of_reach_is_not_started():
    out = sr.KeepDirection().solve([[1.0], [0.0]], [1.0, 1.0], sr.Bounds.symmetric(1.0, n=1), row_kinds="vv")
    assert out.scale == 0.0
    np.testing.assert_allclose(out.rates, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("twist", "rates", "scale"),
    [
        ([1.0, 0.0], [0.0, 0.0], 0.0),  # said 1 once, as if the twist were done
        ([0.0, 0.0], [0.0, 0.0], 1.0),
        ([0.0, 0.0], [0.2, 0.0], 0.0),  # not at rest
        ([1.0, 0.0], [0.25, 0.0], 0.25),  # the runaway does a quarter of it
        ([1.0, 0.0], [3.0, 0.0], 0.0),  # and more than all of it is no fraction
        ([1.0, 0.0], [-0.25, 0.0], 0.0),
        ([1.0, 1.0], [0.25, 0.0], 0.0),
        ([1e300, 0.0], [0.5e300, 0.0], 0.5),
        ([1e-300, 1e-300], [1e-300, 1e-300], 1.0),
    ],
)
def test_without_a_working_joint_the_scale_is_what_the_fixed_joints_do(twist, rates, scale):
    out = sr.KeepDirection().solve(np.eye(2), twist, sr.Bounds(rates, rates), row_kinds="vv")
    assert out.scale == scale
    assert bool(out.status & sr.Status.SCALED) == (scale < 1.0)
    assert out.status & sr.Status.NO_WORKING_JOINT


def nearly_singular(rng, smallest):
    """J (6, n) with a singular value near `smallest`, whose last joint runs away; part of the twist can be done."""
    n = int(rng.integers(8, 12))
    u, v = np.linalg.qr(rng.normal(size=(6, 6)))[0], np.linalg.qr(rng.normal(size=(n, 6)))[0]
    j = u * np.array([*rng.uniform(0.5, 1.5, 5), smallest * rng.uniform(0.5, 1.5)]) @ v.T
    lower, upper = -rng.uniform(0.2, 1.0, n), rng.uniform(0.2, 1.0, n)
    lower[-1] = upper[-1] = rng.uniform(-0.5, 0.5)
    inside = lower + (upper - lower) * rng.uniform(size=n)
    return j, j @ inside / rng.uniform(0.1, 1.0), lower, upper


@pytest.mark.parametrize("smallest", [1e-9, 1e-8, 1e-7, 1e-5])
def test_a_runaway_beside_a_small_singular_value_leaves_the_fraction_that_it_leaves(smallest):
    """Rounded planes said 0 in 7 of 1,500 of these, where up to 0.87 of the twist can be done."""
    rng, compared = np.random.default_rng([41, round(-np.log10(smallest))]), 0
    for _ in range(12):
        j, twist, lower, upper = nearly_singular(rng, smallest)
        out = sr.KeepDirection().solve(j, twist, sr.Bounds(lower, upper))
        best = exact.largest_scale(j, twist, lower, upper)
        if best is None:
            continue
        rounding = 1e-15 / smallest  # a change of the numbers by their rounding changes the fraction by about so much
        assert out.scale == pytest.approx(best, abs=1e-9 + rounding)
        assert np.linalg.norm(j @ out.rates - out.scale * twist) <= 1e-10
        compared += out.scale < 1.0
    assert compared > 5


def test_twist_and_bounds_times_s_leave_the_scale(bound_cases):
    for case in bound_cases[:300]:
        if case.decomposed.kind != "regular" or case.decomposed.condition > 1e3:
            continue
        law = sr.KeepDirection()
        one = law.solve(case.j, case.twist, sr.Bounds(case.lower, case.upper), row_kinds=case.rows)
        other = law.solve(case.j, 8 * case.twist, sr.Bounds(8 * case.lower, 8 * case.upper), row_kinds=case.rows)
        assert other.scale == pytest.approx(one.scale, abs=1e-9), case.label


@pytest.mark.timeout(900)
def test_windows_that_leave_no_rest():
    """As acceleration limits make them: twists that some fractions of can be done, none of it at rest."""
    rng = np.random.default_rng(17)
    arm, compared, without_rest = sr.arms.nasa_modular(), 0, 0
    for _ in range(max(SAMPLE, 300)):
        q = rng.choice(
            [rng.uniform(-1, 1, 11), rng.uniform(-1, 1) * np.eye(11)[rng.integers(11)] + 1e-3 * rng.normal(size=11)]
        )
        j, size = arm.jacobian(q), rng.choice([0.03, 0.2])
        lower = rng.uniform(-0.8, 0.8 - size, 11)
        upper = lower + size * rng.choice([1.0, 0.5, 0.0], 11, p=[0.6, 0.3, 0.1])
        inside = lower + (upper - lower) * rng.uniform(size=11)
        twist = j @ inside / rng.uniform(0.3, 1.0)  # so that this fraction can be done
        best, off = box.largest_scale(j, twist, lower, upper)
        rest = np.linalg.norm(j @ optimize.lsq_linear(j, np.zeros(6), (lower, upper + 1e-15)).x)
        if best is None or off > 1e-13:  # HiGHS is content with less than such rows ask for
            best = exact.largest_scale(j, twist, lower, upper)
        if best is None:  # the rounding of the twist leaves no fraction
            continue
        out = sr.KeepDirection().solve(j, twist, sr.Bounds(lower, upper))
        assert np.all(out.rates >= lower)
        assert np.all(out.rates <= upper)
        direction = np.linalg.norm(j @ out.rates - out.scale * twist) / (1.0 + np.linalg.norm(twist))
        assert direction <= 1e-10
        if out.status & sr.Status.SINGULAR:  # the twist that counts is less than the whole
            continue
        # a direction that is rounded may allow so much more or less
        allowed = 1e-9 + 1e-10 * np.linalg.cond(j[:, lower < upper])
        if not abs(out.scale - best) <= allowed:
            best = exact.largest_scale(j, twist, lower, upper)
        assert best is not None
        assert abs(out.scale - best) <= allowed, (q, out.scale, best)
        compared, without_rest = compared + 1, without_rest + (rest > 1e-6)
    assert compared > 200
    assert without_rest > 100
