"""Cases and questions that the law tests share: 3,000 of each sort, 20,000 with STILLREACH_FULL=1."""

import os
from collections import Counter

import numpy as np
import pytest

import stillreach as sr
from oracles.cases import BOUNDS, law_case, law_cases

COUNT = 20_000 if os.environ.get("STILLREACH_FULL") else 3_000


@pytest.fixture(scope="session")
def paper_cases():
    """One symmetric limit for all joints, as in the paper; failed joints at rest, some moving, some weighted."""
    return tuple(law_cases(COUNT, 1, weighted=0.25, runaways=0.1))


@pytest.fixture(scope="session")
def bound_cases():
    """Every kind of bound: per joint, one-sided, infinite."""
    return tuple(law_cases(COUNT, 2, bounds=BOUNDS, weighted=0.25, runaways=0.2))


@pytest.fixture(scope="session")
def bound_case():
    """bound_case(i): bound_cases[i], also beyond the end."""
    return lambda i: law_case(2, i, bounds=BOUNDS, weighted=0.25, runaways=0.2)


@pytest.fixture(scope="session")
def ask():
    """ask(Law, case, reference=None, **settings): what the law answers to a case, its weights included."""

    def ask(law, case, *, reference=None, **settings):
        weights = sr.Weights(length=case.length, angle=case.angle, task=case.task, joints=case.joints)
        bounds = sr.Bounds(case.lower, case.upper)
        law = law(weights=weights, **settings)
        return law.solve(case.j, case.twist, bounds, reference=reference, row_kinds=case.rows)

    return ask


class Tally(Counter):
    """Counts cases by class, and remembers which facts did not hold for which case."""

    def __init__(self):
        super().__init__()
        self.broken = []

    def holds(self, fact, case, *numbers):
        """Note whether a fact holds for a case; `numbers` are shown where it does not."""
        if not fact:
            self.broken.append(f"{case.label} {' '.join(f'{n:.6g}' for n in numbers)}")
        return bool(fact)

    def keeps_bounds(self, case, rates):
        """Finite, inside the bounds, failed joints at exactly their rate."""
        self.holds(np.all(np.isfinite(rates)), case)
        self.holds(np.all((case.lower <= rates) & (rates <= case.upper)), case)
        self.holds(np.array_equal(rates[case.failed], case.lower[case.failed]), case)

    def settle(self):
        """Fail the test if any fact did not hold."""
        shown = "\n".join(self.broken[:20])
        assert not self.broken, f"{len(self.broken)} times:\n{shown}"


@pytest.fixture
def tally(capsys, request):
    """A Tally whose counts are printed when the test ends."""
    tally = Tally()
    yield tally
    with capsys.disabled():
        print(f"\n  {request.node.name}: " + ", ".join(f"{name} {tally[name]}" for name in sorted(tally)))


@pytest.fixture(scope="session")
def distance():
    """distance(case, rates, expected): how far apart, relative to what a perturbed Jacobian makes of the case.

    Wedin (1973): the part of the twist out of reach, over the smallest singular value, counts beside the rates.
    """

    def distance(case, rates, expected):
        scale = np.linalg.norm(expected) + case.decomposed.unreachable * case.decomposed.back_size
        gap = np.linalg.norm(rates - expected)
        return gap / scale if gap > 0 else 0.0

    return distance


@pytest.fixture(scope="session")
def tolerance():
    """tolerance(case): the relative error that a stable method may make."""
    return lambda case: max(1e-9, 100 * np.finfo(float).eps * case.decomposed.condition)
