"""The tolerance null motion is the derivative of the worst relative manipulability, and climbs it."""

import numpy as np
import pytest

import stillreach as sr
from stillreach.arm.relative import failure_sets, null_basis, without
from tests.unit.control.robots import Q_PAPER, configuration, null_projector
from tests.unit.control.test_manipulability import (
    ARMS,
    TASKS,
    controller,
    gradient_by_differences,
    task_jacobian,
    weights_of,
)

HOPELESS, NEARLY = 1e-3, 1.8


def relative(J):
    """(k,) relative manipulability of each column, by the null space."""
    return without(null_basis(J), failure_sets(range(J.shape[1]), 1))


def chosen(J):
    """The columns that have a part in the gradient."""
    r = relative(J)
    return (r > HOPELESS) & (r < NEARLY * r[r > HOPELESS].min())


def softened(J, part):
    """ln of the smooth minimum whose gradient is claimed."""
    return -np.log(np.sum(relative(J)[part] ** -8.0)) / 8.0


@pytest.mark.parametrize("failed", [(), (2,)], ids=str)
@pytest.mark.parametrize("weighted", ["unit", "diagonal"])
@pytest.mark.parametrize("name", ["pose", "position", "five-axis", "tool offset"])
@pytest.mark.parametrize("make", ARMS)
def test_it_is_the_projected_gradient(make, name, weighted, failed):
    arm = ARMS[make]()
    if arm.n - len(failed) <= len(sr.Task(**TASKS[name]).indices):
        pytest.skip("no joint is spare")
    weights, C, units = weights_of(arm, weighted)
    task = sr.Task(weights=weights, **TASKS[name])
    one, two = (  # what is added to leave saddles is the same for both gains: the difference is the gradient's
        controller(arm, failed, task=task, null_motion=sr.null_motions.Tolerance(gain=gain, max_rate=1e3))
        for gain in (1.0, 2.0)
    )
    working = ~np.isin(np.arange(arm.n), failed)
    compared = unique = 0
    for seed in range(12):
        q = configuration(arm, seed) if make != "paper" else Q_PAPER + 0.3 * configuration(arm, seed)
        at = lambda x: task_jacobian(arm, x, task, C, units, working)  # noqa: E731
        if np.linalg.cond(at(q)) > 500 or relative(at(q)).min() < 0.01:
            continue
        part = chosen(at(q))
        gradient = np.zeros(arm.n)
        gradient = gradient_by_differences(lambda x: softened(at(x), part), q)  # noqa: B023
        gradient = np.where(working, gradient, 0.0)
        rates = two.step(q, np.zeros(6)).rates - one.step(q, np.zeros(6)).rates
        expected = np.zeros(arm.n)
        expected[working] = units[working] * (null_projector(at(q)) @ (gradient[working] / units[working]))
        np.testing.assert_allclose(rates, expected, atol=5e-5 * (1 + np.linalg.norm(gradient)))
        compared += 1
        if part.sum() == 1:  # then it is the gradient of ln r of the worst joint alone
            unique += 1
            hard = gradient_by_differences(lambda x: np.log(relative(at(x)).min()), q)  # noqa: B023
            np.testing.assert_allclose(hard[working], gradient[working], atol=1e-6 * (1 + np.linalg.norm(hard)))
    assert compared >= 1


def test_following_it_the_worst_joint_costs_less_while_the_tool_stands_still():
    arm = sr.arms.nasa_modular()
    gained = []
    for seed in range(5):
        q = np.random.default_rng(seed).uniform(-1.5, 1.5, arm.n)
        hold, before = arm.forward(q), sr.tolerance.report(arm, q, k=1).worst()[1]
        ctl = sr.Controller(arm, null_motion=sr.null_motions.Tolerance(gain=0.3, max_rate=0.3), period=0.02)
        for _ in range(600):
            q = q + 0.02 * ctl.track(q, hold).rates
        np.testing.assert_allclose(arm.forward(q), hold, atol=1e-3)
        gained.append(sr.tolerance.report(arm, q, k=1).worst()[1] / before)
    assert min(gained) > 1.0
    assert np.median(gained) > 1.1


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
