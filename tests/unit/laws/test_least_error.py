"""LeastError: the least task error inside the bounds, then the rates nearest to the reference.

`price=None` is judged here, as the bare optimum: by SciPy's bounded-variable least squares, by a dual active-set
solver and by weak duality. Solvers see a sample; STILLREACH_FULL=1 shows them every case.
"""

import os

import numpy as np
import pytest

import stillreach as sr
from oracles import box
from oracles.cases import law_cases
from oracles.kinematics import planar_arm

SAMPLE = 20_000 if os.environ.get("STILLREACH_FULL") else 3_000
RANK_TOLERANCE = 1e-10


def between(problem, rates):
    """(n,) bool: the joints that `rates` leaves between their bounds, by more than rounding of their units."""
    slack = 1e-14 * np.abs(rates)
    return (rates > problem.lower + slack) & (rates < problem.upper - slack)


def allowance(case, theirs):
    """By how much a solver without a rank tolerance may do better: rounding, and directions below the tolerance."""
    lost = 10 * RANK_TOLERANCE if case.decomposed.kind == "rank deficient" else 0.0
    return 1e-9 + (100 * np.finfo(float).eps + lost) * np.linalg.norm(theirs)


@pytest.mark.timeout(600)
def test_no_solver_has_a_smaller_error(bound_cases, ask, tally):
    for case in bound_cases[:SAMPLE]:
        out, problem = ask(sr.LeastError, case, price=None), case.boxed
        tally.keeps_bounds(case, out.rates)
        tally[case.decomposed.kind] += 1
        if case.decomposed.kind == "near the rank tolerance":
            continue
        ours = out.rates / problem.unit
        error = box.error(problem.j, problem.x, ours)
        for solver in (box.least_error_bvls, box.least_error_daqp):
            theirs = solver(problem.j, problem.x, problem.lower, problem.upper)
            excess = error - box.error(problem.j, problem.x, theirs)
            if excess > 1e-9:
                tally["larger within what the rank tolerance leaves"] += 1
            least = excess <= allowance(case, theirs)
            tally.holds(least, case, excess, error, case.decomposed.condition)
    tally.settle()


@pytest.mark.parametrize("number", [406, 7003, 9987, 10991, 14948, 15876])
def test_near_a_singularity_rounding_does_not_choose_the_bounds(number, bound_case, ask):
    case = bound_case(number)  # the free joints are nearly dependent, 1e3 to 1e9
    out, problem = ask(sr.LeastError, case, price=None), case.boxed
    theirs = box.least_error_bvls(problem.j, problem.x, problem.lower, problem.upper)
    error = box.error(problem.j, problem.x, out.rates / problem.unit)
    assert error <= box.error(problem.j, problem.x, theirs) + allowance(case, theirs)


def test_duality_proves_the_error_least(bound_cases, ask, tally):
    for case in bound_cases:
        out, problem = ask(sr.LeastError, case, price=None), case.boxed
        tally.keeps_bounds(case, out.rates)
        rates = out.rates / problem.unit
        excess = box.excess_error_bound(problem.j, problem.x, problem.lower, problem.upper, rates)
        width = np.where(np.isfinite(problem.upper), problem.upper - problem.lower, 0.0)
        reach = 1.0 + np.max(np.abs(rates)) + np.max(width)
        if case.decomposed.kind == "near the rank tolerance":
            tally["near the rank tolerance"] += 1
        elif reach < 1e4:
            tally["proved"] += 1
            tally.holds(excess <= 1e-7 * reach, case, excess, case.decomposed.condition)
        else:
            tally["bounds too wide for the proof"] += 1
    tally.settle()


def test_among_equals_the_nearest_to_the_reference(bound_cases, ask, tally):
    rng, cases = np.random.default_rng(21), bound_cases[: 2 * SAMPLE]
    for case in cases:
        problem = case.boxed
        reference = np.where(case.failed, 0.0, rng.normal(size=case.j.shape[1]) * problem.unit * rng.choice([0.0, 1.0]))
        rates = ask(sr.LeastError, case, price=None, reference=reference).rates / problem.unit
        if case.decomposed.kind in ("near the rank tolerance", "no working joint"):
            continue
        target = reference / problem.unit
        nearest = box.nearest_same_motion(problem.j, rates, problem.lower, problem.upper, target, problem.weight)
        if nearest is None:
            tally["the solver gave up"] += 1
            continue
        moved = np.abs(rates - nearest) > 1e-9 * np.max(np.abs(rates))  # by more than the solver's rounding
        free = between(problem, rates) | moved
        s = np.linalg.svd(problem.j[:, free], compute_uv=False)
        lengths = np.linalg.norm(problem.j[:, free], axis=0)
        if np.any((s > 1e-15) & (s < 1e-4)) or np.any((lengths > 0) & (lengths < 1e-9)):
            tally["free joints nearly dependent"] += 1
            continue
        tally["compared"] += 1
        ours, theirs = (np.sqrt((r - target) @ problem.weight @ (r - target)) for r in (rates, nearest))
        tally.holds(ours <= theirs * (1 + 1e-6) + 1e-9, case, ours, theirs)
    tally.settle()
    assert tally["compared"] > 0.6 * len(cases)
    assert tally["the solver gave up"] < 0.05 * len(cases)


def test_the_worked_planar_arm():
    _, j = planar_arm(np.deg2rad([20, 50, -30, 40]))
    limits = np.array([0.5, 0.5, 1.0, 1.0])
    out = sr.LeastError(price=None).solve(j, [1.8, 2.4], sr.Bounds(-limits, limits), row_kinds="vv")
    assert out.task_error == pytest.approx(2.3150470, abs=5e-8)


def test_a_larger_box_never_has_a_larger_error(tally):  # near the rank tolerance a bound may decide what counts
    rng = np.random.default_rng(22)
    law = sr.LeastError(price=None)
    for case in law_cases(1500, 23, bounds=("symmetric", "per joint", "one-sided"), scaled=0.0):
        tally[case.decomposed.kind] += 1
        if case.decomposed.kind == "near the rank tolerance":
            continue
        errors, rounding = [], 1e-9 * np.linalg.norm(case.twist)
        lower, upper = case.lower, case.upper
        for _ in range(4):
            out = law.solve(case.j, case.twist, sr.Bounds(lower, upper), row_kinds=case.rows)
            errors.append(out.task_error)
            digits = RANK_TOLERANCE if sr.Status.SINGULAR in out.status else 1e-12
            rounding = max(rounding, digits * np.linalg.norm(case.j) * np.linalg.norm(out.rates))
            lower, upper = (side * rng.uniform(1.0, 2.0, len(side)) for side in (lower, upper))
        tally.holds(np.all(np.diff(errors) <= rounding), case, *errors)
    tally.settle()


def test_never_worse_than_exact_damping(paper_cases, ask, tally):
    for case in paper_cases[:4000]:
        tally[case.decomposed.kind] += 1
        if case.decomposed.kind == "near the rank tolerance":
            continue
        least, damped = ask(sr.LeastError, case, price=None), ask(sr.SingularityRobust, case)
        size = np.linalg.norm(case.decomposed.x) + case.decomposed.s[0] if case.decomposed.s.size else 1.0
        worse = least.task_error - damped.task_error
        tally.holds(worse <= 1e-9 * (damped.task_error + size), case, worse, case.decomposed.condition)
    tally.settle()


def test_one_joint_stops_at_its_bound_and_the_other_helps():
    # Rows 1 and 2: dq1 + dq2 = 3 with dq1 <= 1 leaves 2 to the second.
    bounds = sr.Bounds([-1.0, -9.0], [1.0, 9.0])
    out = sr.LeastError(price=None).solve([[1.0, 1.0]], [3.0], bounds, row_kinds="v")
    np.testing.assert_allclose(out.rates, (1.0, 2.0), atol=1e-12)


def test_a_free_choice_goes_to_the_reference_and_no_further_than_the_bounds():
    # dq1 - dq2 = 0 is all the task asks; (5, 5) would be nearest to the reference.
    bounds = sr.Bounds([-9.0, -9.0], [9.0, 2.0])
    out = sr.LeastError(price=None).solve([[1.0, -1.0]], [0.0], bounds, reference=[6.0, 4.0], row_kinds="v")
    np.testing.assert_allclose(out.rates, (2.0, 2.0), atol=1e-12)
