"""Null motions that climb what is left after losses are derivatives of it, and climb it."""

import numpy as np
import pytest

import stillreach as sr
from stillreach.arm.relative import failure_sets, null_basis, without
from stillreach.tolerance.speeds import guaranteed, normals
from tests.unit.arm.coupled_arms import coupled
from tests.unit.control.robots import Q_PAPER, configuration, mixed, null_projector, skew
from tests.unit.control.test_manipulability import (
    ARMS,
    TASKS,
    controller,
    gradient_by_differences,
    task_jacobian,
    weights_of,
)

HOPELESS, NEARLY = 1e-3, 1.8


def relative(J, size=1):
    """Relative manipulability without each set of columns, by the null space."""
    return without(null_basis(J), failure_sets(range(J.shape[1]), size))


def chosen(left, best=1.0):
    """The losses that have a part in the gradient."""
    fine = left.reshape(-1, left.shape[-1]).min(axis=0) > HOPELESS * best
    return fine & (left < NEARLY * left[..., fine].min())


def softened(left, part):
    """ln of the smooth minimum whose gradient is claimed."""
    return -np.log(np.sum(left[part] ** -8.0)) / 8.0


@pytest.mark.parametrize("failed", [(), (2,)], ids=str)
@pytest.mark.parametrize(("weighted", "size"), [("unit", 1), ("diagonal", 1), ("diagonal", 2), ("unit", 3)])
@pytest.mark.parametrize("name", ["pose", "position", "five-axis", "tool offset"])
@pytest.mark.parametrize("make", ARMS)
def test_it_is_the_projected_gradient(make, name, weighted, failed, size):
    arm = ARMS[make]()
    spare = arm.n - len(failed) - len(sr.Task(**TASKS[name]).indices)
    if spare < 1:
        pytest.skip("no joint is spare")
    weights, C, units = weights_of(arm, weighted)
    task = sr.Task(weights=weights, **TASKS[name])
    one, two = (  # what is added to leave saddles is the same for both gains: the difference is the gradient's
        controller(
            arm, failed, task=task, null_motion=sr.null_motions.Tolerance(gain=gain, max_rate=1e3, failures=size)
        )
        for gain in (0.1, 0.2)
    )
    working, lost = ~np.isin(np.arange(arm.n), failed), min(size, spare)
    compared = unique = 0
    for seed in range(12):
        q = configuration(arm, seed) if make != "paper" else Q_PAPER + 0.3 * configuration(arm, seed)
        at = lambda x: task_jacobian(arm, x, task, C, units, working)  # noqa: E731
        left = relative(at(q), lost)
        if np.linalg.cond(at(q)) > 500 or left.max() < 0.01 or np.any(np.abs(left / HOPELESS - 1.0) < 0.01):
            continue
        part = chosen(left)
        gradient = gradient_by_differences(lambda x: softened(relative(at(x), lost), part), q)  # noqa: B023
        gradient = np.where(working, gradient, 0.0)
        rates = 10.0 * (two.step(q, np.zeros(6)).rates - one.step(q, np.zeros(6)).rates)
        expected = np.zeros(arm.n)
        expected[working] = units[working] * (null_projector(at(q)) @ (gradient[working] / units[working]))
        np.testing.assert_allclose(rates, expected, atol=2e-6 * (1 + np.linalg.norm(gradient)))
        compared += 1
        if part.sum() == 1:  # then it is the gradient of ln r of the worst joint alone
            unique += 1
            hard = gradient_by_differences(lambda x: np.log(relative(at(x), lost)[part][0]), q)  # noqa: B023
            np.testing.assert_allclose(hard[working], gradient[working], atol=1e-6 * (1 + np.linalg.norm(hard)))
    assert compared >= 1


FOLLOWED = {
    f"{k} lost": (
        sr.null_motions.Tolerance(gain=0.3 if k == 1 else 0.1, max_rate=0.3, failures=k),
        lambda arm, q, k=k: sr.tolerance.report(arm, q, k=k).worst(k)[1],
    )
    for k in (1, 2, 3)
} | {
    "speed": (
        sr.null_motions.GuaranteedSpeed(gain=0.1, max_rate=0.3),
        lambda arm, q: np.min(sr.tolerance.report(arm, q, k=1).speeds[0]),
    )
}
"""A null motion, and what grows when an arm follows it."""


@pytest.mark.parametrize(("motion", "left"), FOLLOWED.values(), ids=FOLLOWED)
def test_following_it_the_worst_loss_costs_less_while_the_tool_stands_still(motion, left):
    arm = sr.arms.nasa_modular()
    gained = []
    for seed in range(5):
        q = np.random.default_rng(seed).uniform(-1.5, 1.5, arm.n)
        hold, before = arm.forward(q), left(arm, q)
        ctl = sr.Controller(arm, null_motion=motion, period=0.02)
        for _ in range(600):
            q = q + 0.02 * ctl.track(q, hold).rates
        np.testing.assert_allclose(arm.forward(q), hold, atol=1e-3)
        gained.append(left(arm, q) / before)
    assert min(gained) > 1.0
    assert np.median(gained) > 1.1


SPEED_CASES = {
    "pose": (lambda: mixed(8, seed=6), {"rows": "pose"}, {}),
    "position": (lambda: skew(5), {"rows": "position"}, {}),
    "one row": (lambda: skew(4), {"rows": (True, False, False, False, False, False)}, {}),
    "tool axes": (lambda: skew(7), {"rows": (True, True, True, True, True, False), "frame": "tool"}, {}),
    "faults": (lambda: mixed(9, seed=6), {"rows": "pose"}, {1: sr.Derated(0.4), 3: sr.Locked(), 6: sr.Derated(0.7)}),
    "coupled": (coupled, {"rows": "position"}, {}),
    "weighted": (lambda: mixed(8, seed=6), {"rows": "pose", "weights": sr.Weights(length=0.3, angle=1.2)}, {}),
}


@pytest.mark.parametrize("name", SPEED_CASES)
def test_it_is_the_projected_gradient_of_the_guaranteed_speed(name):
    make, task, faults = SPEED_CASES[name]
    arm, task = make(), sr.Task(**task)
    rates = np.random.default_rng(3).uniform(0.3, 2.0, arm.n)
    arm = arm.with_limits(velocity=rates)
    lower, upper, still = -rates, rates.copy(), np.zeros(arm.n, dtype=bool)
    for joint, fault in faults.items():
        share = fault.fraction if isinstance(fault, sr.Derated) else 1.0
        lower[joint] *= share * (not isinstance(fault, sr.Locked))
        upper[joint] *= share * (not isinstance(fault, sr.Locked))
        still[joint] = isinstance(fault, sr.Locked)

    def controller_of(gain):
        motion = sr.null_motions.GuaranteedSpeed(gain=gain, max_rate=5.0)
        ctl = sr.Controller(arm, law=sr.LeastError(price=None), task=task, null_motion=motion)
        for joint, fault in faults.items():
            ctl.fail(joint, fault)
        ctl.reset()
        return ctl

    one, two = controller_of(1e-3), controller_of(2e-3)
    _, C, units = weights_of(arm, "unit")
    if task.weights is not None and name == "weighted":
        C, units = np.diag([1 / 0.3] * 3 + [1 / 1.2] * 3), np.where(arm.kinds == 1, 0.3, 1.2)
    at = lambda x: task_jacobian(arm, x, task, C, np.ones(arm.n), ~still)  # noqa: E731

    def left(x):
        """(N, k) distances of the facets without each joint, of the others."""
        J, low, high = at(x), lower[~still], upper[~still]
        distances = []
        for lost in range(J.shape[1]):
            rest = np.delete(np.arange(J.shape[1]), lost)
            facets, whole = normals(J[:, rest])
            assert whole
            push = np.concatenate([facets, -facets]) @ J[:, rest]
            distances.append(np.sum(np.maximum(push, 0.0) * high[rest] + np.minimum(push, 0.0) * low[rest], axis=1))
        return np.array(distances).T

    compared = 0
    for seed in range(12):
        q = configuration(arm, seed)
        values = left(q)
        losses = values.min(axis=0)
        whole = np.min(guaranteed(at(q), normals(at(q))[0], lower[~still], upper[~still]))
        if np.linalg.cond(at(q)) > 200 or np.any(np.abs(np.log2(losses / (HOPELESS * whole) + 1e-300)) < 1.0):
            continue
        part = chosen(values, whole)
        gradient = np.where(still, 0.0, gradient_by_differences(lambda x: softened(left(x), part), q))  # noqa: B023
        moved = 1e3 * (two.step(q, np.zeros(6)).rates - one.step(q, np.zeros(6)).rates)
        expected = np.zeros(arm.n)
        mine = units[~still]
        expected[~still] = mine * (null_projector(at(q) * mine) @ (gradient[~still] / mine))
        np.testing.assert_allclose(moved, expected, atol=1e-5 * (1 + np.linalg.norm(gradient)))
        compared += 1
        if compared == 3:
            return
    pytest.fail("too few postures could be compared")


def test_where_no_joint_is_spare_it_asks_for_nothing():
    arm = sr.arms.panda()
    q = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
    ctl = sr.Controller(arm, null_motion=sr.null_motions.Tolerance(max_rate=0.2))
    ctl.fail(0)
    assert np.abs(ctl.step(q, np.zeros(6)).rates).max() <= 1e-2 * 0.2  # the push that leaves saddles


def test_its_settings_are_those_of_manipulability():
    with pytest.raises(sr.InputError, match="gain"):
        sr.Controller(sr.arms.panda(), null_motion=sr.null_motions.Tolerance(gain=0.0))
    with pytest.raises(sr.InputError, match="max_rate"):
        sr.null_motions.Tolerance(max_rate=np.inf)


def test_what_a_tick_cannot_look_at_is_refused():
    with pytest.raises(sr.InputError, match="failures: got 9, expected 1 to 8"):
        sr.null_motions.Tolerance(failures=9)
    with pytest.raises(sr.InputError, match=r"failures.*27,405 sets.*at most 5,000"):
        sr.Controller(sr.arms.snake(30), null_motion=sr.null_motions.Tolerance(failures=4))
    with pytest.raises(sr.InputError, match="null_motion: got GuaranteedSpeed for 30 joints and 6 rows"):
        sr.Controller(sr.arms.snake(30), null_motion=sr.null_motions.GuaranteedSpeed())
    sr.Controller(sr.arms.snake(30), task=sr.Task(rows="position"), null_motion=sr.null_motions.GuaranteedSpeed())
