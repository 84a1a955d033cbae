"""The reference rate nu: what the task leaves free goes towards it, and the task does not notice."""

import numpy as np
import pytest

import stillreach as sr
from oracles import equations
from oracles.cases import BOUNDS, law_cases
from oracles.kinematics import paper_arm

RNG = np.random.default_rng(15)
*_, ARM = paper_arm(np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 10, 20]))
TWIST = np.array([0.05, -0.1, 0.02, 0.0, 0.1, -0.05])


def bounds(failed=(), limit=np.inf):
    return sr.Bounds.symmetric(limit, n=11).lock(list(failed))


LAWS = [sr.Pseudoinverse(), sr.SingularityRobust(), sr.SingularityRobust(damping="closed-form")]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("failed", [(), (1, 3, 6), (0, 2, 4, 5, 6)])
def test_the_projected_reference_is_added(law, failed):
    nu = RNG.normal(size=11)
    a = equations.failed_rows(np.isin(np.arange(11), failed))
    plain = law.solve(ARM, TWIST, bounds(failed)).rates
    moved = law.solve(ARM, TWIST, bounds(failed), reference=nu)
    np.testing.assert_allclose(moved.rates, plain + equations.null_projector(ARM, a) @ nu, atol=1e-9)
    np.testing.assert_allclose(moved.residual, 0, atol=1e-9)


def test_it_is_scaled_down_rather_than_break_a_bound():
    nu = np.full(11, 30.0)
    law = sr.SingularityRobust()
    plain = law.solve(ARM, TWIST, bounds(limit=1.0)).rates
    moved = law.solve(ARM, TWIST, bounds(limit=1.0), reference=nu)
    added = moved.rates - plain
    whole = equations.null_projector(ARM, np.zeros((0, 11))) @ nu
    part = added @ whole / (whole @ whole)
    np.testing.assert_allclose(added, part * whole, atol=1e-9)
    assert 0 < part < 1
    assert np.max(np.abs(moved.rates)) == pytest.approx(1.0, rel=1e-12)
    assert np.max(np.abs(moved.rates)) <= 1.0
    np.testing.assert_allclose(moved.residual, 0, atol=1e-9)


def test_it_disturbs_the_task_in_no_case(bound_cases, ask, tally):
    rng = np.random.default_rng(16)
    for case in bound_cases[:6000]:
        problem = case.decomposed
        nu = rng.normal(size=case.j.shape[1]) * (np.linalg.norm(problem.rates()) or 1.0)
        plain, moved = (ask(sr.SingularityRobust, case, reference=r) for r in (None, nu))
        tally[problem.kind] += 1
        tally.keeps_bounds(case, moved.rates)
        if problem.kind in ("regular", "no working joint") and not plain.status & sr.Status.CLIPPED:
            moves = np.linalg.norm(moved.rates) + np.linalg.norm(nu)
            size = np.linalg.norm(case.j) * moves + np.linalg.norm(case.twist)
            rounding = 1e-9 + 1e4 * np.finfo(float).eps * problem.condition  # limits that differ make J D worse than J
            disturbed = np.linalg.norm(moved.residual - plain.residual) / (size or 1.0)
            tally.holds(disturbed <= rounding, case, disturbed, problem.condition)
            tally.holds(moved.damping == plain.damping, case)
    tally.settle()


def test_with_joint_weights_it_is_the_nearest_in_those_weights(ask):
    rng = np.random.default_rng(17)
    compared = 0
    for case in law_cases(600, 18, bounds=("infinite",), weighted=1.0, runaways=0.3, scaled=0.0):
        problem = case.decomposed
        if problem.kind != "regular" or problem.condition > 1e3:
            continue
        nu = rng.normal(size=case.j.shape[1])
        rates = ask(sr.Pseudoinverse, case, reference=nu).rates
        expected = problem.rates() + problem.null_rates(nu)
        if case.joints is not None and np.ndim(case.joints) == 2 and np.any(case.lower[case.failed] != 0):
            continue  # a full weight that couples a runaway: covered below by its optimality
        compared += 1
        size = np.linalg.norm(expected) + np.linalg.norm(nu)
        np.testing.assert_allclose(rates / size, expected / size, atol=1e-9, err_msg=case.label)
    assert compared > 100


@pytest.mark.parametrize("kinds", [BOUNDS])
def test_a_reference_of_zero_is_no_reference(kinds, ask):
    for case in law_cases(300, 19, bounds=kinds, weighted=0.3):
        none, zero = (ask(sr.SingularityRobust, case, reference=r) for r in (None, np.zeros(case.j.shape[1])))
        np.testing.assert_array_equal(none.rates, zero.rates)
