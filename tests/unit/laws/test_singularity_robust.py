"""The singularity-robust law with a given damping factor, eq. (4) to (8)."""

import numpy as np
import pytest

import stillreach as sr
from oracles import equations
from oracles.kinematics import paper_arm

RNG = np.random.default_rng(4)
FREE = sr.Bounds.unbounded


def wide_system(m, n):
    return RNG.normal(size=(m, n)), RNG.normal(size=m)


def spd(n):
    a = RNG.normal(size=(n, n))
    return a @ a.T + np.eye(n)


def test_is_the_damped_svd_solution(paper_cases, ask, tally, distance, tolerance):
    rng = np.random.default_rng(5)
    for case in paper_cases:
        problem = case.decomposed
        largest = problem.s[0] if problem.s.size and problem.s[0] > 0 else 1.0
        kappa = float(10.0 ** rng.uniform(-6, 1) * largest**2)
        out = ask(sr.SingularityRobust, case, damping=kappa)
        expected = problem.damped_rates(kappa)
        clipped = np.where(case.failed, expected, np.clip(expected, case.lower, case.upper))
        over = bool(np.any(np.abs(clipped - expected) > 1e-6 * np.abs(expected)))
        tally[problem.kind + (", clipped" if over else "")] += 1
        tally.keeps_bounds(case, out.rates)
        if problem.kind == "near the rank tolerance":
            continue
        off = distance(case, out.rates, clipped)
        tally.holds(off <= tolerance(case), case, off, problem.condition)
        tally.holds(not over or sr.Status.CLIPPED in out.status, case)
        # a damped factorisation never fails, and once hid that the rank is short
        tally.holds((sr.Status.SINGULAR in out.status) == (problem.kind == "rank deficient"), case, problem.condition)
        if problem.kind != "no working joint":
            tally.holds(sr.Status.DAMPED in out.status and out.damping == kappa, case, out.damping, kappa)
    tally.settle()


@pytest.mark.parametrize("shape", [(2, 7), (6, 11), (6, 6), (6, 4), (3, 1)])
@pytest.mark.parametrize("kappa", [1e-3, 0.5, 30.0])
def test_eq_5_and_eq_6_are_the_same_law(shape, kappa):
    j, twist = wide_system(*shape)
    rates = sr.SingularityRobust(damping=kappa).solve(j, twist, FREE(shape[1]), row_kinds="v" * shape[0]).rates
    np.testing.assert_allclose(rates, equations.eq5(j, twist, kappa), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(rates, equations.eq6(j, twist, kappa), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("failed", [[], [4], [1, 3, 6], [0, 1, 2, 3, 4, 5, 6, 7]])
@pytest.mark.parametrize("kappa", [1e-2, 1.0])
def test_eq_8_with_full_weights_is_the_law_on_the_remaining_joints(failed, kappa):
    j, twist = wide_system(6, 11)
    w1, w2 = spd(6), spd(11)
    law = sr.SingularityRobust(damping=kappa, weights=sr.Weights(task=w1, joints=w2))
    rates = law.solve(j, twist, FREE(11).lock(failed)).rates
    a = equations.failed_rows(np.isin(np.arange(11), failed))
    np.testing.assert_allclose(rates, equations.eq8(j, twist, a, w1, kappa * w2), rtol=1e-7, atol=1e-9)
    kept = np.setdiff1d(np.arange(11), failed)
    law = sr.SingularityRobust(damping=kappa, weights=sr.Weights(task=w1, joints=w2[np.ix_(kept, kept)]))
    np.testing.assert_allclose(rates[kept], law.solve(j[:, kept], twist, FREE(len(kept))).rates, rtol=1e-9, atol=1e-11)


def test_eq_8_with_a_limit_that_does_not_bite():
    j, twist = wide_system(6, 11)
    w1, w2 = spd(6), np.diag(RNG.uniform(0.2, 5.0, 11))
    expected = equations.eq8(j, twist, np.zeros((0, 11)), w1, 0.3 * w2)
    for joints in (w2, np.diag(w2)):
        law = sr.SingularityRobust(damping=0.3, weights=sr.Weights(task=w1, joints=joints))
        rates = law.solve(j, twist, sr.Bounds.symmetric(100.0, n=11)).rates
        np.testing.assert_allclose(rates, expected, rtol=1e-9, atol=1e-12)


def test_without_damping_it_is_the_pseudoinverse():
    *_, j = paper_arm(np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 10, 20]))
    twist = RNG.normal(size=6)
    wanted = sr.Pseudoinverse().solve(j, twist, FREE(11)).rates
    for kappa in (0.0, 1e-14, 1e-12):
        rates = sr.SingularityRobust(damping=kappa).solve(j, twist, FREE(11)).rates
        np.testing.assert_allclose(rates, wanted, rtol=1e-8)
    for damping in ("exact", "closed-form"):
        out = sr.SingularityRobust(damping=damping).solve(j, twist, FREE(11))
        np.testing.assert_allclose(out.rates, wanted, rtol=1e-9)
        assert out.damping == 0.0
        assert not out.status & sr.Status.DAMPED


def test_more_damping_means_more_error_and_less_motion():
    j, twist = wide_system(6, 9)
    answers = [sr.SingularityRobust(damping=k).solve(j, twist, FREE(9)) for k in np.geomspace(1e-6, 1e3, 40)]
    assert np.all(np.diff([out.task_error for out in answers]) > 0)
    assert np.all(np.diff([np.linalg.norm(out.rates) for out in answers]) < 0)


def test_stays_finite_through_a_singularity():
    # Planar two-link arm stretching out: the pseudoinverse rates grow without bound, the damped ones do not.
    for bend in (0.3, 1e-3, 1e-6, 1e-12, 0.0):
        q2 = bend
        j = np.array([[-np.sin(q2), -np.sin(q2)], [1 + np.cos(q2), np.cos(q2)]])
        out = sr.SingularityRobust(damping=0.01).solve(j, [-1.0, 0.0], FREE(2), row_kinds="vv")
        assert np.max(np.abs(out.rates)) <= 1 / (2 * np.sqrt(0.01)) + 1e-12  # s / (s^2 + kappa) is at most that
