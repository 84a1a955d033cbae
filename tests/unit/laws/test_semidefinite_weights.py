"""Weights that are only positive semidefinite: the paper calls W1, W2 arbitrary, and eq. (8) needs P regular only."""

from dataclasses import dataclass

import numpy as np
import pytest

import stillreach as sr
from oracles import equations
from tests.refusals import refused

FREE = sr.Bounds.unbounded


@dataclass(frozen=True)
class Case:
    """A problem with P = J' W1 J + W2 regular and well conditioned, W1 and W2 of reduced rank."""

    j: np.ndarray
    twist: np.ndarray
    w1: np.ndarray
    w2: np.ndarray
    failed: np.ndarray

    @property
    def weights(self):
        return sr.Weights(task=self.w1, joints=self.w2)

    @property
    def kinds(self):
        return "v" * len(self.j)

    @property
    def working(self):
        return np.setdiff1d(np.arange(self.j.shape[1]), self.failed)


def reduced(rng, size, rank):
    """A weight of a given rank, diagonal or full."""
    if rng.random() < 0.5:
        return np.diag(rng.permutation(np.concatenate([rng.uniform(0.2, 4.0, rank), np.zeros(size - rank)])))
    root = rng.normal(size=(rank, size))
    return root.T @ root


def cases(seed, count=300, *, full_task=False):
    """Random cases of every shape; `full_task`: W1 has full rank, and enough joints work to meet the task."""
    rng = np.random.default_rng(seed)
    while count:
        m, n = int(rng.integers(1, 7)), int(rng.integers(1, 12))
        r1 = m if full_task else int(rng.integers(0, m + 1))
        w1, w2 = reduced(rng, m, r1), reduced(rng, n, int(rng.integers(max(0, n - r1), n + 1)))
        j, failed = rng.normal(size=(m, n)), np.flatnonzero(rng.random(n) < 0.2)
        case = Case(j, rng.normal(size=m), w1, w2, failed)
        k = len(case.working)
        if k and np.linalg.cond(j.T @ w1 @ j + w2) < 1e4 and (not full_task or (k >= m and condition(case) < 1e4)):
            count -= 1
            yield case


def saddle(case):
    """The matrix of: weighted norm least, J dq given, over the working joints."""
    w, m = case.working, len(case.j)
    return np.block([[case.w2[np.ix_(w, w)], case.j[:, w].T], [case.j[:, w], np.zeros((m, m))]])


def condition(case):
    return np.linalg.cond(saddle(case))


def close(rates, expected):
    size = max(np.max(np.abs(expected), initial=0.0), 1e-3)
    np.testing.assert_allclose(rates / size, expected / size, atol=1e-9)


def test_the_law_is_eq_8_wherever_p_is_regular():
    rng = np.random.default_rng(0)
    for case in cases(1):
        kappa = float(10.0 ** rng.uniform(-1, 1))
        law = sr.SingularityRobust(damping=kappa, weights=case.weights)
        rates = law.solve(case.j, case.twist, FREE(case.j.shape[1]).lock(case.failed), row_kinds=case.kinds).rates
        a = equations.failed_rows(np.isin(np.arange(case.j.shape[1]), case.failed))
        close(rates, equations.eq8(case.j, case.twist, a, case.w1, kappa * case.w2))


def test_a_vector_with_zeros_is_the_diagonal_matrix():
    rng = np.random.default_rng(2)
    j, twist = rng.normal(size=(6, 9)), rng.normal(size=6)
    w1, w2 = np.array([1.0, 0.0, 2.0, 1.0, 3.0, 1.0]), np.array([0.0, 1.0, 1.0, 0.0, 2.0, 1.0, 1.0, 1.0, 0.5])
    answers = [
        sr.SingularityRobust(damping=0.3, weights=weights).solve(j, twist, FREE(9)).rates
        for weights in (sr.Weights(task=w1, joints=w2), sr.Weights(task=np.diag(w1), joints=np.diag(w2)))
    ]
    close(answers[0], equations.eq8(j, twist, np.zeros((0, 9)), np.diag(w1), 0.3 * np.diag(w2)))
    close(answers[1], answers[0])


def test_the_pseudoinverse_has_the_least_weighted_rates_that_meet_the_task():
    for case in cases(3, full_task=True):
        law = sr.Pseudoinverse(weights=case.weights)
        rates = law.solve(case.j, case.twist, FREE(case.j.shape[1]).lock(case.failed), row_kinds=case.kinds).rates
        w = case.working
        close(rates[w], np.linalg.solve(saddle(case), np.concatenate([np.zeros(len(w)), case.twist]))[: len(w)])


def test_a_reference_adds_the_null_motion_that_is_nearest_in_the_weight():
    rng = np.random.default_rng(4)
    for case in cases(5, count=100, full_task=True):
        w, reference = case.working, rng.normal(size=case.j.shape[1])
        bounds = FREE(case.j.shape[1]).lock(case.failed)
        pull = np.concatenate([case.w2[np.ix_(w, w)] @ reference[w], case.twist])
        for law in (sr.Pseudoinverse(weights=case.weights), sr.SingularityRobust(weights=case.weights)):
            out = law.solve(case.j, case.twist, bounds, reference=reference, row_kinds=case.kinds)
            close(out.rates[w], np.linalg.solve(saddle(case), pull)[: len(w)])


def test_a_runaway_joint_pulls_at_the_joints_that_its_weight_is_coupled_with():
    rng = np.random.default_rng(6)
    for case in cases(7, count=100):
        n = case.j.shape[1]
        moving = np.zeros(n)
        moving[case.failed] = rng.normal(size=len(case.failed))
        bounds = sr.Bounds(np.where(moving != 0, moving, -np.inf), np.where(moving != 0, moving, np.inf))
        w, kappa = case.working, 0.4
        p = (case.j.T @ case.w1 @ case.j + kappa * case.w2)[np.ix_(w, w)]
        pull = case.j[:, w].T @ case.w1 @ (case.twist - case.j @ moving) - kappa * (case.w2 @ moving)[w]
        law = sr.SingularityRobust(damping=kappa, weights=case.weights)
        close(law.solve(case.j, case.twist, bounds, row_kinds=case.kinds).rates[w], np.linalg.solve(p, pull))


@pytest.mark.parametrize("damping", ["exact", "closed-form"])
def test_damping_keeps_the_limit_by_the_weighted_law(damping):
    damped = 0
    for case in cases(8):
        n = case.j.shape[1]
        law = sr.SingularityRobust(damping=damping, weights=case.weights)
        bounds = sr.Bounds.symmetric(0.3, n=n).lock(case.failed)
        out = law.solve(case.j, case.twist, bounds, row_kinds=case.kinds)
        assert out.check()
        if out.status & sr.Status.CLIPPED or not out.damping > 0.0:
            continue
        damped += 1
        a = equations.failed_rows(np.isin(np.arange(n), case.failed))
        expected = equations.eq8(case.j, case.twist, a, case.w1, out.damping * case.w2)
        np.testing.assert_allclose(out.rates, expected, atol=1e-7)
        largest = np.max(np.abs(expected))
        assert largest == pytest.approx(0.3, rel=1e-6) if damping == "exact" else largest <= 0.3 * (1 + 1e-9)
    assert damped > 50


def test_a_row_without_weight_is_not_a_lost_one():
    rng = np.random.default_rng(9)
    j, twist = rng.normal(size=(6, 8)), rng.normal(size=6)
    position = np.array([1.0, 1, 1, 0, 0, 0])
    for law in (sr.Pseudoinverse, sr.SingularityRobust):
        out = law(weights=sr.Weights(task=position)).solve(j, twist, FREE(8))
        assert out.status == sr.Status.OK
        close(out.rates, np.linalg.pinv(j[:3]) @ twist[:3])
        assert out.task_error < 1e-12
        assert out.lost_directions().shape == (6, 0)
        still = law(weights=sr.Weights(task=position)).solve(j, twist, FREE(8).lock(range(8)))
        assert still.lost_directions().shape == (6, 3)
        assert law(weights=sr.Weights(task=np.zeros(6))).solve(j, twist, FREE(8)).status == sr.Status.OK


def test_a_lost_direction_lies_in_what_has_weight():
    j = np.array([[1.0, 2.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # nothing moves along the second row
    law = sr.Pseudoinverse(weights=sr.Weights(task=[1.0, 1.0, 0.0]))
    lost = law.solve(j, np.ones(3), FREE(3), row_kinds="vvv").lost_directions()
    np.testing.assert_allclose(np.abs(lost), [[0.0], [1.0], [0.0]], atol=1e-12)


def test_without_any_weight_on_the_task_nothing_moves():
    j, twist = np.random.default_rng(10).normal(size=(6, 8)), np.ones(6)
    out = sr.SingularityRobust(damping=0.1, weights=sr.Weights(task=np.zeros(6))).solve(j, twist, FREE(8))
    assert np.all(out.rates == 0.0)  # eq. (8) with W1 = 0


def test_weights_with_a_singular_p_are_refused_with_the_reason():
    twins = np.array([[1.0, 1.0, 0.5], [2.0, 2.0, 1.0]])  # joints 1 and 2 do the same
    law = sr.SingularityRobust(damping=0.1, weights=sr.Weights(joints=[0.0, 0.0, 1.0]))
    with refused("weights.joints", "1 of 3"):
        law.solve(twins, [1.0, 0.0], FREE(3), row_kinds="vv")
    rates = law.solve(twins, [1.0, 0.0], FREE(3).lock([0]), row_kinds="vv").rates  # without the twin P is regular
    close(rates, equations.eq8(twins, [1.0, 0.0], np.eye(3)[:1], np.eye(2), np.diag([0.1, 0.0, 0.1])))


def test_more_joints_without_weight_than_rows_are_refused_before_the_loop():
    arm = sr.arms.nasa_modular()
    law = sr.SingularityRobust(weights=sr.Weights(joints=[0.0] * 7 + [1.0] * 4))
    with refused("weights.joints", "4", "11", "5"):
        sr.Controller(arm, law=law)
    with refused("weights.joints", "4", "11"):
        sr.solve_batch(arm, law, np.zeros((2, 11)), np.zeros(6), sr.Bounds.symmetric(1.0, n=11))


def test_in_a_loop_motions_without_weight_rest_where_p_is_singular():
    """The straight arm: all rolls turn about one line, so that two of them without weight are not told apart."""
    arm = sr.arms.nasa_modular()
    weights = sr.Weights(joints=[0.0, 1.0, 0.0] + [1.0] * 8)
    ctl = sr.Controller(arm, law=sr.SingularityRobust(damping=0.01, weights=weights), period=0.01)
    out = ctl.step(np.zeros(11), [0.1, 0, 0, 0, 0, 0.2])
    assert out.status & sr.Status.SINGULAR
    assert np.all(np.isfinite(out.rates))
    assert np.count_nonzero(out.rates[[0, 2]]) == 1  # one of the two turns, the other rests
    assert out.rates[[0, 2]].sum() == pytest.approx(0.2)  # it costs nothing, so the whole turn is made by it
    bent = ctl.step(np.full(11, 0.4), [0.1, 0, 0, 0, 0, 0.2])
    assert not bent.status & sr.Status.SINGULAR


def test_a_batch_has_the_bits_of_single_calls():
    rng, arm = np.random.default_rng(11), sr.arms.nasa_modular()
    root = rng.normal(size=(8, 11))
    q, twist = rng.uniform(-2, 2, (40, 11)), rng.normal(size=(40, 6))
    bounds = sr.Bounds.symmetric(0.9, n=11).lock([3])
    for weights in (sr.Weights(task=[1, 1, 1, 0, 0, 1]), sr.Weights(joints=root.T @ root)):
        law = sr.SingularityRobust(weights=weights)
        rates = sr.solve_batch(arm, law, q, twist, bounds).rates
        for i in range(40):
            assert np.array_equal(rates[i], law.solve(arm.jacobian(q[i]), twist[i], bounds).rates)


@pytest.mark.parametrize("weights", [{"task": [1, 1, 1, 1, 1, 0]}, {"joints": [0.0] + [1.0] * 10}])
def test_what_cannot_use_semidefinite_weights_says_which_laws_can(weights):
    arm, weights = sr.arms.nasa_modular(), sr.Weights(**weights)
    q, name = np.zeros(11), "task" if weights.joints is None else "joints"
    asked = [lambda law=law: sr.Controller(arm, law=law(weights=weights)) for law in (sr.LeastError, sr.KeepDirection)]
    asked += [
        lambda: sr.LeastError(weights=weights).solve(arm.jacobian(q), np.zeros(6), FREE(11)),
        lambda: arm.manipulability(q, task=sr.Task(weights=weights)),
    ]
    for ask in asked:
        with refused(f"weights.{name}", "SingularityRobust", "Pseudoinverse"):
            ask()


def test_manipulability_is_not_pursued_in_a_task_without_weight():
    arm, law = sr.arms.nasa_modular(), sr.SingularityRobust(weights=sr.Weights(task=[1, 1, 1, 0, 0, 0]))
    with pytest.raises(sr.InputError, match="null_motion"):
        sr.Controller(arm, law=law, null_motion=sr.null_motions.Manipulability())
    ctl = sr.Controller(arm, law=law)
    with pytest.raises(sr.InputError, match="null_motion"):
        ctl.set_null_motion(sr.null_motions.Manipulability())
    only = sr.Task(rows="position")  # the rows that have weight are a definite task
    sr.Controller(arm, law=law, task=only, null_motion=sr.null_motions.Manipulability())


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("task", [1.0, -1.0, 1.0], "at least 0"),
        ("joints", np.diag([1.0, 1.0, -1e-3]), "negative eigenvalue -0.001"),
        ("task", [[1.0, 2.0], [2.0, 1.0]], "negative eigenvalue -1"),
        ("joints", [[0.0, 1.0], [1.0, 1.0]], "negative eigenvalue"),
        ("task", [[1.0, 0.5], [0.0, 1.0]], "symmetric"),
    ],
)
def test_weights_that_are_negative_somewhere_are_refused(name, value, words):
    with pytest.raises(sr.InputError, match=words) as caught:
        sr.Weights(**{name: value})
    assert caught.value.argument == name
