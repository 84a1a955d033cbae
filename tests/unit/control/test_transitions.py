"""A joint fails or comes back while the arm moves: the least change that keeps the task, and a smooth return."""

import numpy as np
import pytest

import stillreach as sr
from oracles.null_space import least_jump, relative_manipulability
from tests.unit.control.robots import Q_PAPER, TWIST, configuration, mixed, null_projector, paper, skew

LAWS = [
    sr.LeastError(price=None),
    sr.LeastError(price=1e9),
    sr.KeepDirection(),
    sr.Pseudoinverse(),
    sr.SingularityRobust(),
]
EVERY_LAW = pytest.mark.parametrize("law", LAWS, ids=repr)
ARMS = {"paper": (paper, Q_PAPER), "mixed": (lambda: mixed(10), None), "skew": (lambda: skew(9), None)}
NULL = {"without null motion": lambda n: None, "with null motion": lambda n: 0.5 * np.cos(2.0 * np.arange(n))}


def moving(arm, q, law, null, ticks=3, **settings):
    """A controller that has been moving the tool for some ticks, and its last rates."""
    ctl = sr.Controller(arm, law=law, null_motion=null, velocity_limits=1e4, **settings)
    for _ in range(ticks):
        rates = ctl.step(q, TWIST).rates
    return ctl, rates.copy()


@EVERY_LAW
@pytest.mark.parametrize("null", NULL)
@pytest.mark.parametrize("name", ARMS)
def test_the_jump_of_a_single_failure_is_its_rate_over_its_relative_manipulability(law, null, name):
    make, q = ARMS[name]
    arm = make()
    q = configuration(arm) if q is None else q
    j = arm.jacobian(q)
    compared = 0
    for joint in range(arm.n):
        r = relative_manipulability(j, [joint])
        if r <= 1e-3:
            continue
        ctl, before = moving(arm, q, law, NULL[null](arm.n))
        ctl.fail(joint)
        out = ctl.step(q, TWIST)
        jump = np.linalg.norm(out.rates - before)
        assert jump == pytest.approx(abs(before[joint]) / r, rel=1e-10 * max(1.0, 1e-2 / r**2))
        np.testing.assert_allclose(out.residual, 0.0, atol=1e-9)
        compared += 1
    assert compared >= 5


@EVERY_LAW
@pytest.mark.parametrize("null", NULL)
@pytest.mark.parametrize("failed", [(1, 3), (0, 5, 8), (2, 4, 6, 9)], ids=str)
def test_the_jump_of_several_failures_is_the_least_one_that_keeps_the_task(law, null, failed):
    arm = paper()
    ctl, before = moving(arm, Q_PAPER, law, NULL[null](11))
    for joint in failed:
        ctl.fail(joint)
    out = ctl.step(Q_PAPER, TWIST)
    expected = least_jump(arm.jacobian(Q_PAPER), before, failed)
    np.testing.assert_allclose(out.rates - before, expected, atol=1e-9 * np.linalg.norm(expected))


@EVERY_LAW
@pytest.mark.parametrize("kind", [sr.Locked(), sr.Runaway(0.2)], ids=repr)
def test_a_restored_joint_does_not_make_the_arm_jump_at_all(kind, law):
    """It is taken over at its rate, and going on like that still does the task."""
    ctl = sr.Controller(paper(), law=law, velocity_limits=1e4)
    ctl.fail(4, kind)
    for _ in range(3):
        before = ctl.step(Q_PAPER, TWIST).rates.copy()
    ctl.restore(4)
    np.testing.assert_allclose(ctl.step(Q_PAPER, TWIST).rates, before, atol=1e-10)


@pytest.mark.parametrize("law", [sr.LeastError(price=None), sr.KeepDirection()], ids=repr)
def test_acceleration_limits_go_before_the_task_in_that_tick(law):
    arm = paper()
    ctl, before = moving(arm, Q_PAPER, law, None, ticks=200, acceleration_limits=5.0, period=0.001)
    ctl.fail(6)
    out = ctl.step(Q_PAPER, TWIST)
    others = np.arange(11) != 6
    assert abs(before[6]) > 1e-3
    assert out.rates[6] == 0.0
    assert np.max(np.abs(out.rates - before)[others]) <= 5.0 * 0.001 * (1 + 1e-9)


def standing(period, rate, *, seconds=3.0):
    """A tool that stands still, no null motion at first; then j5 is restored: what share of it is back at each tick."""
    arm = paper()
    nu = 0.3 * np.cos(2.0 * np.arange(11))
    ctl = sr.Controller(arm, null_motion=nu, transition_rate=rate, period=period, velocity_limits=10.0)
    ctl.fail(4)
    ctl.reset()
    start = ctl.step(Q_PAPER, np.zeros(6)).rates.copy()
    end = null_projector(arm.jacobian(Q_PAPER)) @ nu
    ctl.restore(4)
    rates, tick = _bound(ctl)
    path = []
    for _ in range(int(seconds / period)):
        tick()
        path.append(rates.copy())
    path = np.array(path)
    return path, (path - start) @ (end - start) / np.sum((end - start) ** 2), np.max(np.abs(end - start))


def _bound(ctl):
    q, twist, rates = Q_PAPER.copy(), np.zeros(6), np.zeros(11)
    return rates, ctl.bind(q=q, twist=twist, rates=rates)


@pytest.mark.parametrize("period", [0.01, 0.002])
@pytest.mark.parametrize("rate", [0.5, 2.0, 10.0])
def test_the_null_motion_comes_back_with_no_jump_larger_than_its_rate(period, rate):
    path, share, whole = standing(period, rate)
    jumps = np.max(np.abs(np.diff(path, axis=0)), axis=1)
    assert np.max(jumps) <= 2.0 * rate * period * whole
    assert share[0] == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.diff(share) >= -1e-9)


@pytest.mark.parametrize("rate", [1.0, 2.0, 5.0])
def test_the_null_motion_is_back_after_the_time_that_its_rate_says(rate):
    """Half of it within a quarter and twice of 1 / rate, nearly all after five times that."""
    _, share, _ = standing(0.002, rate, seconds=5.0 / rate)
    half = 0.002 * np.argmax(share >= 0.5)
    assert 0.25 / rate <= half <= 2.0 / rate
    assert share[-1] == pytest.approx(1.0, abs=0.02)


def test_how_fast_it_comes_back_does_not_depend_on_the_period():
    half = [period * np.argmax(standing(period, 2.0)[1] >= 0.5) for period in (0.01, 0.001)]
    assert half[1] == pytest.approx(half[0], rel=0.1)


def test_with_a_transition_rate_of_zero_the_null_motion_goes_on_at_once():
    arm = paper()
    nu = 0.3 * np.cos(2.0 * np.arange(11))
    ctl = sr.Controller(arm, null_motion=nu, transition_rate=0.0, velocity_limits=10.0)
    ctl.step(Q_PAPER, np.zeros(6))
    ctl.fail(4)
    working = np.arange(11) != 4
    expected = null_projector(arm.jacobian(Q_PAPER), working) @ nu
    np.testing.assert_allclose(ctl.step(Q_PAPER, np.zeros(6)).rates, expected, atol=1e-10)


def test_reset_ends_a_transition():
    arm = paper()
    nu = 0.3 * np.cos(2.0 * np.arange(11))
    ctl = sr.Controller(arm, null_motion=nu, velocity_limits=10.0)
    ctl.fail(4)
    ctl.reset()
    working = np.arange(11) != 4
    expected = null_projector(arm.jacobian(Q_PAPER), working) @ nu
    np.testing.assert_allclose(ctl.step(Q_PAPER, np.zeros(6)).rates, expected, atol=1e-10)


@EVERY_LAW
@pytest.mark.parametrize("seed", range(5))
def test_whatever_comes_and_goes_the_task_is_kept_and_the_bounds_are_too(law, seed):
    """Faults come and go at random; a feasible task does not notice."""
    arm, rng = paper(), np.random.default_rng([61, seed])
    ctl = sr.Controller(
        arm, law=law, null_motion=sr.null_motions.Posture(q=0.5 * Q_PAPER), period=0.01, velocity_limits=3.0
    )
    q, hurt = Q_PAPER.copy(), set()
    for t in range(200):
        if t % 10 == 5:
            joint = int(rng.integers(11))
            if joint in hurt or len(hurt) >= 2:
                joint = hurt.pop() if joint not in hurt else joint
                hurt.discard(joint)
                ctl.restore(joint)
            else:
                hurt.add(joint)
                ctl.fail(joint, (sr.Locked(), sr.Runaway(0.02), sr.Derated(0.5))[rng.integers(3)])
        out = ctl.step(q, 0.2 * TWIST)
        if not isinstance(law, sr.Pseudoinverse):
            assert np.all((out.rates >= out.lower) & (out.rates <= out.upper))
        if out.singular_values()[-1] > 0.1 and not out.status & (sr.Status.SATURATED | sr.Status.DAMPED):
            np.testing.assert_allclose(out.residual, 0.0, atol=1e-9)
        q = q + 0.01 * out.rates
