"""The pseudoinverse law, eq. (3): against an SVD on every kind of case, and what is true of it without one."""

import numpy as np
import pytest

import stillreach as sr
from oracles import equations
from oracles.kinematics import paper_arm

RNG = np.random.default_rng(3)


def test_is_the_svd_solution_over_the_working_joints(paper_cases, ask, tally, distance, tolerance):
    for case in paper_cases:
        out = ask(sr.Pseudoinverse, case)
        problem = case.decomposed
        tally[problem.kind] += 1
        tally.holds(np.all(np.isfinite(out.rates)), case)
        tally.holds(np.array_equal(out.rates[case.failed], case.lower[case.failed]), case)
        if problem.kind != "near the rank tolerance":
            off = distance(case, out.rates, problem.rates())
            tally.holds(off <= tolerance(case), case, off, problem.condition)
    tally.settle()


def test_the_task_is_met_as_well_as_rounding_allows(paper_cases, ask, tally):
    """A small error in the rates is not enough: near a singularity it may be a large one in the tool's motion."""
    for case in paper_cases:
        problem = case.decomposed
        tally[problem.kind] += 1
        if problem.kind in ("near the rank tolerance", "no working joint"):
            continue
        out = ask(sr.Pseudoinverse, case)
        u = problem.u[:, : problem.rank]
        least = np.linalg.norm(problem.x - u @ (u.T @ problem.x))
        moved = problem.s[0] * np.linalg.norm(
            np.linalg.solve(problem.back, (out.rates - problem.start)[problem.working])
        )
        size = np.linalg.norm(problem.x) + moved
        excess = (out.task_error - least) / (size or 1.0)
        tally.holds(excess <= 1e-12, case, excess, problem.condition)
    tally.settle()


def test_says_when_it_exceeds_a_bound_and_when_a_rank_is_missing(paper_cases, ask):
    for case in paper_cases[:4000]:
        out, problem = ask(sr.Pseudoinverse, case), case.decomposed
        if problem.kind == "near the rank tolerance":
            continue
        outside = np.any((out.rates < case.lower) | (out.rates > case.upper))
        assert bool(out.status & sr.Status.OVER_LIMIT) == outside, case.label
        assert bool(out.status & sr.Status.SINGULAR) == (problem.kind == "rank deficient"), case.label
        assert bool(out.status & sr.Status.NO_WORKING_JOINT) == (problem.kind == "no working joint"), case.label
        assert out.damping == 0.0


@pytest.mark.parametrize("failed", [[], [1, 3, 6], [0, 5, 6], [0, 2, 4, 8, 10]])
def test_eq_3_on_the_papers_arm(failed):
    *_, j = paper_arm(np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 10, 20]))
    twist = RNG.normal(size=6)
    mask = np.isin(np.arange(11), failed)
    out = sr.Pseudoinverse().solve(j, twist, sr.Bounds.symmetric(np.inf, n=11).lock(failed))
    np.testing.assert_allclose(out.rates, equations.eq3(j, twist, equations.failed_rows(mask)), atol=1e-9)
    np.testing.assert_allclose(j @ out.rates, twist, atol=1e-12)


def test_one_joint_by_hand():
    # Two rows, one joint, a twist that it can only half serve: dq = (3, 4) . (5, 0) / 25.
    out = sr.Pseudoinverse().solve([[3.0], [4.0]], [5.0, 0.0], sr.Bounds.unbounded(1), row_kinds="vv")
    assert out.rates[0] == pytest.approx(0.6, rel=1e-14)
    np.testing.assert_allclose(out.residual, (3.2, -2.4), rtol=1e-14)
    assert out.task_error == pytest.approx(4.0)


def test_more_freedom_never_makes_the_error_larger():
    j, twist = RNG.normal(size=(6, 9)), RNG.normal(size=6)
    errors = []
    for count in range(10):
        bounds = sr.Bounds.unbounded(9).lock(range(count))
        errors.append(sr.Pseudoinverse().solve(j, twist, bounds).task_error)
    assert np.all(np.diff(errors) >= -1e-12)
    assert errors[-1] == pytest.approx(np.linalg.norm(twist))


def test_a_zero_jacobian_moves_nothing():
    out = sr.Pseudoinverse().solve(np.zeros((6, 7)), np.ones(6), sr.Bounds.symmetric(1.0, n=7))
    np.testing.assert_array_equal(out.rates, np.zeros(7))
    assert out.status & sr.Status.SINGULAR


def test_scaling_the_jacobian_or_the_twist_scales_the_rates():
    j, twist = RNG.normal(size=(6, 8)), RNG.normal(size=6)
    bounds = sr.Bounds.unbounded(8)
    rates = sr.Pseudoinverse().solve(j, twist, bounds).rates
    for scale in (1e-150, 1e-9, 3.0, 1e9, 1e150):
        np.testing.assert_allclose(sr.Pseudoinverse().solve(j, scale * twist, bounds).rates, scale * rates, rtol=1e-11)
        np.testing.assert_allclose(sr.Pseudoinverse().solve(j / scale, twist, bounds).rates, scale * rates, rtol=1e-11)


def test_the_rank_tolerance_decides_which_direction_counts():
    j, twist = np.diag([1.0, 1e-6]), np.ones(2)
    bounds = sr.Bounds.unbounded(2)
    kept = sr.Pseudoinverse(rank_tolerance=1e-7).solve(j, twist, bounds, row_kinds="vv")
    dropped = sr.Pseudoinverse(rank_tolerance=1e-5).solve(j, twist, bounds, row_kinds="vv")
    np.testing.assert_allclose(kept.rates, (1.0, 1e6), rtol=1e-9)
    np.testing.assert_allclose(dropped.rates, (1.0, 0.0), atol=1e-12)
    assert not kept.status & sr.Status.SINGULAR
    assert dropped.status & sr.Status.SINGULAR
