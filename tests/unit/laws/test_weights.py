"""Weights: units and W1, W2 mean the same in every law, whichever way they are written."""

from dataclasses import replace

import numpy as np
import pytest

import stillreach as sr
from oracles.cases import BOUNDS, law_cases

LAWS = [
    (sr.Pseudoinverse, {}),
    (sr.SingularityRobust, {"damping": "exact"}),
    (sr.SingularityRobust, {"damping": "exact", "norm": "2"}),
    (sr.SingularityRobust, {"damping": "closed-form"}),
    (sr.SingularityRobust, {"damping": 0.2}),
]
EVERY_LAW = pytest.mark.parametrize(("law", "settings"), LAWS, ids=lambda value: getattr(value, "__name__", None))


def tame(seed, count=400, **kinds):
    """Cases whose answer does not hang on the last digits."""
    for case in law_cases(count, seed, scaled=0.0, **kinds):
        if case.decomposed.kind in ("regular", "no working joint") and case.decomposed.condition < 1e3:
            yield case


def same(a, b, label):
    size = max(np.max(np.abs(a.rates), initial=0.0), 1e-300)
    np.testing.assert_allclose(b.rates / size, a.rates / size, atol=1e-7, err_msg=label)
    assert b.damping == pytest.approx(a.damping, rel=1e-6), label


@EVERY_LAW
def test_a_vector_is_the_diagonal_of_a_matrix(law, settings, ask):
    rng = np.random.default_rng(10)
    for case in tame(10, bounds=BOUNDS, runaways=0.2):
        if law is sr.SingularityRobust and not np.array_equal(case.lower[~case.failed], -case.upper[~case.failed]):
            continue  # a matrix may couple a joint's two sides, and then no one answer need be the least
        m, n = case.j.shape
        task, joints = rng.uniform(0.2, 5.0, m), rng.uniform(0.2, 5.0, n)
        vectors = ask(law, replace(case, task=task, joints=joints), **settings)
        matrices = ask(law, replace(case, task=np.diag(task), joints=np.diag(joints)), **settings)
        same(vectors, matrices, case.label)


@EVERY_LAW
def test_task_weights_are_squares_of_inverse_row_units(law, settings, ask):
    for case in tame(11, bounds=BOUNDS):
        by_units = replace(case, length=0.3, angle=1.0)
        rows = np.where(np.array(list(case.rows)) == "v", 0.3, 1.0)
        same(ask(law, by_units, **settings), ask(law, replace(case, task=rows**-2.0), **settings), case.label)


@EVERY_LAW
def test_a_change_of_units_with_matching_weights_leaves_the_rates(law, settings, ask):
    """J and the twist in millimetres with length = 1 mm: the same numbers, the same answer."""
    for case in tame(12, bounds=BOUNDS):
        rows = np.where(np.array(list(case.rows)) == "v", 1000.0, 1.0)
        inner = replace(case, j=rows[:, None] * case.j, twist=rows * case.twist, length=1000.0)
        same(ask(law, case, **settings), ask(law, inner, **settings), case.label)


@EVERY_LAW
def test_one_number_for_all_joints_changes_nothing_but_a_given_damping(law, settings, ask):
    for case in tame(13, bounds=BOUNDS):
        joints = np.full(case.j.shape[1], 4.0)
        if settings.get("damping") == 0.2:
            four_times = {**settings, "damping": 0.8}
            a, b = ask(law, case, **four_times), ask(law, replace(case, joints=joints), **settings)
        else:
            a, b = ask(law, case, **settings), ask(law, replace(case, joints=joints), **settings)
        size = max(np.max(np.abs(a.rates), initial=0.0), 1e-300)
        np.testing.assert_allclose(b.rates / size, a.rates / size, atol=1e-7, err_msg=case.label)


def test_an_expensive_joint_moves_less():
    j, twist = np.array([[1.0, 1.0]]), [1.0]
    law = sr.Pseudoinverse(weights=sr.Weights(joints=[1.0, 4.0]))
    np.testing.assert_allclose(law.solve(j, twist, sr.Bounds.unbounded(2), row_kinds="v").rates, (0.8, 0.2), rtol=1e-12)


def test_an_important_row_is_served_better():
    j, twist = np.array([[1.0], [1.0]]), [1.0, 0.0]
    law = sr.Pseudoinverse(weights=sr.Weights(task=[9.0, 1.0]))
    out = law.solve(j, twist, sr.Bounds.unbounded(1), row_kinds="vv")
    assert out.rates[0] == pytest.approx(0.9)
    assert out.task_error == pytest.approx(np.sqrt(9 * 0.1**2 + 0.9**2))


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("length", 0.0),
        ("length", -1.0),
        ("length", np.nan),
        ("angle", np.inf),
        ("angle", "deg"),
        ("task", [1.0, -1.0, 1.0, 1.0, 1.0, 1.0]),
        ("task", np.diag([1.0, 1.0, 1.0, 1.0, 1.0, -1e-3])),
        ("task", np.eye(6) + np.eye(6, k=1)),
        ("joints", [1.0, np.nan]),
        ("joints", np.ones((2, 3))),
        ("joints", -np.eye(3)),
    ],
)
def test_weights_that_measure_nothing_are_refused(argument, value):
    with pytest.raises(sr.InputError) as caught:
        sr.Weights(**{argument: value})
    assert argument in caught.value.argument
    assert argument in str(caught.value)


@pytest.mark.parametrize(("argument", "value"), [("task", np.ones(4)), ("joints", np.ones(6))])
def test_weights_that_do_not_fit_the_jacobian_are_refused(argument, value):
    law = sr.Pseudoinverse(weights=sr.Weights(**{argument: value}))
    with pytest.raises(sr.InputError, match=argument):
        law.solve(np.ones((6, 7)), np.ones(6), sr.Bounds.unbounded(7))
