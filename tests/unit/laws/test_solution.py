"""What a solution says about itself."""

import numpy as np
import pytest

import stillreach as sr
from oracles.weighted import task_error

LAWS = [
    sr.Pseudoinverse,
    sr.SingularityRobust,
    lambda **k: sr.SingularityRobust(damping="closed-form", **k),
    lambda **k: sr.SingularityRobust(damping=0.05, **k),
    lambda **k: sr.SingularityRobust(norm="2", **k),
]
EVERY_LAW = pytest.mark.parametrize("law", LAWS)


@EVERY_LAW
def test_residual_and_task_error_are_recomputed_from_the_rates(law, bound_cases):
    for case in bound_cases[:1500]:
        weights = sr.Weights(length=case.length, angle=case.angle, task=case.task, joints=case.joints)
        out = law(weights=weights).solve(case.j, case.twist, sr.Bounds(case.lower, case.upper), row_kinds=case.rows)
        size = np.linalg.norm(case.twist) + np.linalg.norm(case.j) * np.linalg.norm(out.rates) + 1e-300
        np.testing.assert_allclose(out.residual / size, (case.twist - case.j @ out.rates) / size, atol=1e-14)
        rows = case.units["row_units"]
        expected = task_error(case.j, case.twist, out.rates, row_units=rows, task=case.task)
        floor = 1e-13 * size / np.min(rows) * (1 if case.task is None else np.sqrt(np.linalg.norm(case.task)))
        assert out.task_error == pytest.approx(expected, rel=1e-9, abs=floor), case.label


@EVERY_LAW
def test_the_shapes_and_types_are_the_documented_ones(law):
    out = law().solve(np.ones((4, 3)), np.ones(4), sr.Bounds.symmetric(1.0, n=3), row_kinds="vvvw")
    assert out.rates.shape == (3,)
    assert out.rates.dtype == np.float64
    assert out.residual.shape == (4,)
    assert len(out.active) == 3
    assert isinstance(out.status, sr.Status)
    for name in ("damping", "scale", "task_error"):
        assert isinstance(getattr(out, name), float), name


def test_a_joint_at_its_bound_is_reported():
    bounds = sr.Bounds.symmetric(1.0, n=2)
    out = sr.SingularityRobust().solve(np.eye(2), [3.0, 0.2], bounds, row_kinds="vv")
    assert out.status & sr.Status.SATURATED
    assert bool(out.active[0])
    assert not bool(out.active[1])
    calm = sr.SingularityRobust().solve(np.eye(2), [0.3, 0.2], bounds, row_kinds="vv")
    assert calm.status == sr.Status.OK
    assert not np.any(np.asarray(calm.active))


@EVERY_LAW
def test_two_solutions_do_not_share_their_arrays(law):
    bounds = sr.Bounds.symmetric(1.0, n=2)
    first = law().solve(np.eye(2), [0.5, 0.5], bounds, row_kinds="vv")
    kept = first.rates.copy()
    law().solve(np.eye(2), [-0.5, 0.1], bounds, row_kinds="vv")
    np.testing.assert_array_equal(first.rates, kept)


@EVERY_LAW
def test_asking_twice_gives_the_same_bits(law, bound_cases):
    for case in bound_cases[:300]:
        bounds = sr.Bounds(case.lower, case.upper)
        a, b = (law().solve(case.j, case.twist, bounds, row_kinds=case.rows) for _ in range(2))
        np.testing.assert_array_equal(a.rates, b.rates)
        assert (a.status, a.damping, a.task_error) == (b.status, b.damping, b.task_error)
