"""A period for each tick: loops that jitter keep their limits."""

import numpy as np
import pytest

import stillreach as sr
from tests.unit.control.robots import Q_PAPER, TWIST, paper, pushed, refused, slide

PUSH = [1.0, 0, 0, 0, 0, 0]


def test_the_acceleration_window_is_that_of_the_given_period():
    ctl = slide(acceleration_limits=2.0, period=0.01)
    rates = [float(ctl.step([0.0], PUSH, period=period).rates[0]) for period in (0.03, 0.001, 0.01)]
    np.testing.assert_allclose(rates, np.cumsum([0.06, 0.002, 0.02]), atol=1e-15)
    assert ctl.period == 0.01
    np.testing.assert_allclose(pushed(ctl, 1.0).rates, 0.102, atol=1e-15)


@pytest.mark.parametrize("period", [0.5, 0.1, 1e-3])
def test_a_joint_does_not_pass_its_limit_in_the_given_period(period):
    ctl = slide(position_limits=(-1.0, 0.05), period=0.01)
    assert float(ctl.step([0.0], [1e3, 0, 0, 0, 0, 0], period=period).rates[0]) == pytest.approx(0.05 / period)


def test_braking_needs_no_regular_period():
    """v period + v² / (2 a) = room: at 1 m/s held for 0.1 s and 2 m/s² these are 0.1 + 0.25 m."""
    ctl = slide(position_limits=(-1.0, 0.35), acceleration_limits=2.0, period=0.01)
    ctl.reset([1.0])
    assert float(ctl.step([0.0], [9.0, 0, 0, 0, 0, 0], period=0.1).rates[0]) == pytest.approx(1.0)


JITTER = 2 * np.array([0.0083, 0.0007, 0.0062, 0.0016, 0.0054, 0.0018, 0.0058, 0.0039, 0.0031])
LATE = np.array([0.01, 0.01, 0.01, 0.03])


@pytest.mark.parametrize("acceleration", [np.inf, 50.0, 2.0])
@pytest.mark.parametrize("periods", [JITTER, LATE, np.array([0.01, 0.05, 1e-5])], ids=["jitter", "late", "wild"])
def test_a_loop_that_jitters_keeps_position_and_acceleration_limits(periods, acceleration):
    arm = sr.arms.canadarm2().with_limits(position=(-1, 1), velocity=1.0)
    ctl = sr.Controller(arm, period=0.01, acceleration_limits=acceleration)
    q, last = np.array([0.2, 0.3, 0.4, -0.5, 0.6, 0.3, 0.2]), np.zeros(7)
    reached = 0.0
    for k in range(600):
        period = float(periods[k % len(periods)])
        out = ctl.step(q, [5, 0, 0, 0, 0.2, 0], period=period)
        assert not out.status & sr.Status.LIMIT_GIVEN_UP
        assert np.abs(out.rates - last).max() <= acceleration * period * (1 + 1e-9) + 1e-12
        q, last = q + period * out.rates, out.rates
        reached = max(reached, np.abs(q).max())
    assert 0.9 < reached <= 1.0 + 1e-9


def test_a_period_that_changes_no_bound_changes_no_bit():
    a, b = (sr.Controller(paper(), period=0.01) for _ in range(2))
    target = paper().forward(Q_PAPER + 0.1)
    np.testing.assert_array_equal(a.step(Q_PAPER, TWIST, period=0.3).rates, b.step(Q_PAPER, TWIST).rates)
    np.testing.assert_array_equal(a.track(Q_PAPER, target, period=0.3).rates, b.track(Q_PAPER, target).rates)


@pytest.mark.parametrize("period", [0.0, -0.01, np.nan, np.inf, "soon", [0.01], True])
def test_what_is_no_period_is_refused_and_changes_nothing(period):
    ctl = sr.Controller(paper(), acceleration_limits=1.0)
    refused(lambda: ctl.step(Q_PAPER, TWIST, period=period), "period")
    refused(lambda: ctl.track(Q_PAPER, np.eye(4), period=period), "period")
    assert not ctl.last_rates.any()


def test_a_transition_lasts_as_long_as_its_periods_say():
    """Half a second: 5 ticks of 0.1 s, whatever the controller's own period."""
    ctl = sr.Controller(paper(), null_motion=sr.null_motions.Posture(q=np.zeros(11)), period=0.001, transition_rate=2.0)
    ctl.reset(np.full(11, 0.1))
    ctl.fail("j1")
    after = sr.Controller(paper(), null_motion=sr.null_motions.Posture(q=np.zeros(11)), transition_rate=0.0)
    after.fail("j1")
    expected = after.step(Q_PAPER, TWIST).rates
    equal = [np.allclose(ctl.step(Q_PAPER, TWIST, period=0.1).rates, expected, atol=1e-9) for _ in range(6)]
    assert equal == [False] * 5 + [True]


def test_a_bound_tick_reads_its_period():
    q, rates, period = np.zeros(1), np.zeros(1), np.array([0.03])
    ctl = slide(acceleration_limits=2.0, period=0.01)
    tick = ctl.bind(q=q, twist=np.array(PUSH), rates=rates, period=period)
    tick()
    assert rates[0] == pytest.approx(0.06)
    period[0] = 0.005
    tick()
    assert rates[0] == pytest.approx(0.07)
    for bad in (np.nan, np.inf, 0.0, -1.0):
        period[0] = bad
        assert tick() & sr.Status.INVALID_INPUT
    assert rates[0] == 0.0  # braked by 0.02 a tick


@pytest.mark.parametrize("period", [0.01, np.zeros(2), np.array(0.01), np.zeros(1, np.float32)], ids=repr)
def test_bind_refuses_what_is_no_array_of_one_period(period):
    ctl = slide()
    refused(lambda: ctl.bind(q=np.zeros(1), twist=np.zeros(6), rates=np.zeros(1), period=period), "period", "(1,)")
