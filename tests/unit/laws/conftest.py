"""Cases and questions that the law tests share."""

from collections import Counter

import numpy as np
import pytest

import stillreach as sr
from oracles.cases import BOUNDS, law_cases

COUNT = 20_000


@pytest.fixture(scope="session")
def paper_cases():
    """One symmetric limit for all joints, as in the paper; failed joints at rest, some moving, some weighted."""
    return tuple(law_cases(COUNT, 1, weighted=0.25, runaways=0.1))


@pytest.fixture(scope="session")
def bound_cases():
    """Every kind of bound: per joint, one-sided, infinite."""
    return tuple(law_cases(COUNT, 2, bounds=BOUNDS, weighted=0.25, runaways=0.2))


@pytest.fixture(scope="session")
def ask():
    """ask(Law, case, reference=None, **settings): what the law answers to a case, its weights included."""

    def ask(law, case, *, reference=None, **settings):
        weights = sr.Weights(length=case.length, angle=case.angle, task=case.task, joints=case.joints)
        bounds = sr.Bounds(case.lower, case.upper)
        law = law(weights=weights, **settings)
        return law.solve(case.j, case.twist, bounds, reference=reference, row_kinds=case.rows)

    return ask


@pytest.fixture
def tally(capsys, request):
    """A counter of cases by class, printed when the test ends."""
    counts = Counter()
    yield counts
    with capsys.disabled():
        print(f"\n  {request.node.name}: " + ", ".join(f"{name} {counts[name]}" for name in sorted(counts)))


@pytest.fixture(scope="session")
def distance():
    """distance(case, rates, expected): how far apart, relative to what a perturbed Jacobian makes of the case.

    Wedin (1973): the part of the twist out of reach, over the smallest singular value, counts beside the rates.
    """

    def distance(case, rates, expected):
        scale = np.linalg.norm(expected) + case.decomposed.unreachable * np.linalg.norm(case.decomposed.back, 2)
        gap = np.linalg.norm(rates - expected)
        return gap / scale if gap > 0 else 0.0

    return distance


@pytest.fixture(scope="session")
def tolerance():
    """tolerance(case): the relative error that a stable method may make."""
    return lambda case: max(1e-9, 100 * np.finfo(float).eps * case.decomposed.condition)
