"""The damping laws where a joint's two bounds differ: the answer agrees with the sides that it moves to."""

import numpy as np
import pytest

import stillreach as sr
from oracles.cases import law_cases
from oracles.sides import Sided

CONDITION = 1e4
SMALLER = (1e-6, 1e-3, 0.03, 0.2, 0.5, 0.8, 0.95, 0.999)
"""Parts of a damping that must not meet the limit."""


@pytest.fixture(scope="module")
def sided():
    """[(case, Sided)]: no matrix as joint weight, some joint with a bound of its own on either side."""
    cases = []
    for case in law_cases(2500, 31, bounds=("per joint", "one-sided"), weighted=0.25, runaways=0.2, scaled=0.0):
        weight = case.joints is None or np.ndim(case.joints) == 1
        if weight and case.decomposed.kind == "regular" and case.decomposed.condition < CONDITION:
            cases.append((case, Sided(case)))
    return cases


def off(rates, expected):
    return np.linalg.norm(rates - expected) / (np.linalg.norm(expected) or 1.0)


def test_a_given_damping_leaves_the_least_of_error_and_rates(sided, ask, tally):
    for case, oracle in sided:
        kappa = float(10.0 ** np.random.default_rng(len(tally)).uniform(-5, 1) * oracle.size**2)
        out = ask(sr.SingularityRobust, case, damping=kappa)
        tally.keeps_bounds(case, out.rates)
        free = oracle.rates(oracle.moves(kappa))
        expected = np.where(case.failed, free, np.clip(free, case.lower, case.upper))
        tally.holds(off(out.rates, expected) < 1e-7, case, off(out.rates, expected), kappa)
        tally["at rest on a bound of 0" if np.any(out.rates[~case.failed] == 0.0) else "all move"] += 1
    tally.settle()
    assert tally["at rest on a bound of 0"] > 200


@pytest.mark.parametrize("norm", ["inf", "2"])
def test_exact_damping_meets_the_limit_and_no_smaller_one_does(norm, sided, ask, tally):
    for case, oracle in sided[:400]:
        out = ask(sr.SingularityRobust, case, damping="exact", norm=norm)
        tally.keeps_bounds(case, out.rates)
        tally.holds(not out.status & (sr.Status.CLIPPED | sr.Status.ITERATION_LIMIT), case)
        if out.damping == 0.0:
            tally["undamped"] += 1
            z = oracle.moves(1e-9 * oracle.size**2)
            tally.holds(oracle.used(z, norm) <= 1 + 1e-3, case, oracle.used(z, norm))
            continue
        tally["damped"] += 1
        z = oracle.moves(out.damping)
        tally.holds(off(out.rates, oracle.rates(z)) < 1e-6, case, off(out.rates, oracle.rates(z)))
        tally.holds(abs(oracle.used(z, norm) - 1) < 1e-6, case, oracle.used(z, norm))
        for part in SMALLER:
            used = oracle.used(oracle.moves(part * out.damping), norm)
            tally.holds(used > 1 - 1e-9, case, part, used, out.damping)
    tally.settle()
    assert tally["damped"] > 150


@pytest.mark.parametrize("norm", ["inf", "2"])
def test_closed_form_is_eq_16_on_the_sides_of_its_own_answer(norm, sided, ask, tally):
    for case, oracle in sided[:800]:
        out = ask(sr.SingularityRobust, case, damping="closed-form", norm=norm)
        tally.keeps_bounds(case, out.rates)
        tally.holds(not out.status & (sr.Status.CLIPPED | sr.Status.ITERATION_LIMIT), case)
        if out.damping == 0.0:
            tally["undamped"] += 1
            continue
        z = oracle.moves(out.damping)
        tally.holds(off(out.rates, oracle.rates(z)) < 1e-6, case, off(out.rates, oracle.rates(z)))
        tally.holds(oracle.used(z, norm) <= 1 + 1e-9, case, oracle.used(z, norm))
        own = oracle.closed_form(z, norm)
        if own is None:
            tally["equal singular values"] += 1
        elif abs(out.damping / own - 1) < 1e-6:
            tally["eq. (16)"] += 1
        else:  # a joint changes sides, and what eq. (16) asks for jumps past the damping
            tally["not raised"] += 1
            tally.holds(own < out.damping, case, own, out.damping)
    tally.settle()
    assert tally["not raised"] < 0.05 * tally["eq. (16)"]


def test_a_joint_that_was_pushed_against_its_bound_comes_back():
    """Two joints that may not move down both want to; held, the first must move up to make up for the third."""
    j = np.array([[1.0, 0.9, 0.2], [0.0, 1.0, 1.0]])
    bounds = sr.Bounds([0.0, 0.0, -1.0], [1.0, 1.0, 1.0])
    law = sr.SingularityRobust(damping=1e-6)
    for twist in ([0.1, -0.5], [-0.02, -0.1], [-0.1, 0.2]):
        out = law.solve(j, twist, bounds, row_kinds="vv")
        gain = j.T @ out.residual - 1e-6 * out.rates  # of moving each joint up
        free = out.rates != 0.0
        np.testing.assert_allclose(gain[free], 0.0, atol=1e-12)
        assert np.all(gain[~free] <= 1e-12)
