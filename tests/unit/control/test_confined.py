"""Confined joints: they stop inside their reduced range, and outside of it only come back."""

import numpy as np
import pytest

import stillreach as sr
from oracles.bounds_table import room_rate
from tests.unit.control.robots import Q_PAPER, TWIST, configuration, mixed, paper, pushed, refused, slide

RANGE = (-0.6, 0.4)
PERIODS = [1e-3, 2e-3, 5e-3, 1e-2]
ACCELERATIONS = [0.5, 4.0, 50.0, np.inf]


def confined(lower=RANGE[0], upper=RANGE[1], **limits):
    """A slide that is confined."""
    ctl = slide(**limits)
    ctl.fail("j1", sr.Confined(lower, upper))
    return ctl


def driven(ctl, period, command, q, ticks):
    """Positions after each tick, rates and all statuses of a slide that is pushed at `command`."""
    positions, rates, status = [], [], sr.Status.OK
    for _ in range(ticks):
        out = pushed(ctl, command, q)
        q += period * float(out.rates[0])
        positions.append(q)
        rates.append(float(out.rates[0]))
        status |= out.status
    return np.array(positions), np.array(rates), status


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("acceleration", ACCELERATIONS)
def test_inside_it_brakes_in_time_and_stops_at_the_end(acceleration, period, side):
    end = RANGE[1] if side > 0 else RANGE[0]
    ctl = confined(velocity_limits=2.0, acceleration_limits=acceleration, period=period)
    ticks = int((1.5 + 2.0 * 2.0 / acceleration) / period) + 50
    positions, rates, status = driven(ctl, period, side * 10.0, 0.0, ticks)
    assert np.max(side * positions) <= side * end + 1e-12
    slack = 1e-3 + (acceleration * period**2 if np.isfinite(acceleration) else 0.0)
    assert side * end - side * positions[-1] <= slack
    changes = np.abs(np.diff(np.concatenate(([0.0], rates)))) / period
    assert np.max(changes) <= acceleration * (1 + 1e-9)
    assert not status & sr.Status.LIMIT_GIVEN_UP


@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("acceleration", ACCELERATIONS)
def test_it_moves_as_between_position_limits_of_that_range(acceleration, period):
    """Another road to the same rates: a healthy joint with these position limits."""
    limits = {"velocity_limits": 1.0, "acceleration_limits": acceleration, "period": period}
    commands = np.random.default_rng(3).uniform(-2.0, 2.0, 12).repeat(int(0.3 / period))
    fault, limit = confined(**limits), slide(position_limits=RANGE, **limits)
    q = 0.0
    for command in commands:
        out, other = pushed(fault, command, q), pushed(limit, command, q)
        assert (out.lower[0], out.upper[0]) == (other.lower[0], other.upper[0])
        assert out.rates[0] == other.rates[0]
        q += period * float(out.rates[0])


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("period", PERIODS)
@pytest.mark.parametrize("acceleration", ACCELERATIONS)
def test_outside_it_may_come_back_and_moves_no_further_out(acceleration, period, side):
    start = side * 0.9
    ctl = confined(velocity_limits=0.7, acceleration_limits=acceleration, period=period)
    positions, rates, _ = driven(ctl, period, side * 5.0, start, 20)
    assert np.all(rates == 0.0)
    positions, rates, status = driven(ctl, period, -side * 5.0, start, int(4.0 / period))
    assert np.all(side * rates <= 0.0)
    assert np.max(np.abs(rates)) == pytest.approx(0.7)
    assert RANGE[0] - 1e-12 <= positions[-1] <= RANGE[1] + 1e-12
    assert not status & sr.Status.LIMIT_GIVEN_UP


@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_that_moves_out_when_it_is_confined_stops_at_once(side):
    """The fault goes before the acceleration limit, and the status says so."""
    ctl = slide(velocity_limits=1.0, acceleration_limits=1.0, period=0.01)
    ctl.reset([side * 0.5])
    ctl.fail("j1", sr.Confined(-0.1, 0.1))
    out = pushed(ctl, side * 1.0, q=side * 0.3)
    assert out.rates[0] == 0.0
    assert sr.Status.LIMIT_GIVEN_UP in out.status


@pytest.mark.parametrize("side", [1, -1])
def test_the_reason_at_the_end_of_the_range_is_the_fault(side):
    ctl = confined(velocity_limits=1.0, period=0.01)
    out = pushed(ctl, side * 1.0, q=RANGE[1] - 1e-3 if side > 0 else RANGE[0] + 1e-3)
    assert out.active[0] == side * sr.Reason.FAULT
    assert abs(out.rates[0]) == pytest.approx(0.1)
    assert pushed(ctl, side * 5.0, q=0.0).active[0] == side * sr.Reason.RATE


@pytest.mark.parametrize("q", [-0.45, -0.25, 0.0, 0.25, 0.45])
def test_the_tighter_of_range_and_position_limits_holds_on_each_side(q):
    ctl = confined(-0.3, 0.5, position_limits=(-0.5, 0.3), period=0.01)
    out = pushed(ctl, 0.0, q)
    assert out.upper[0] == pytest.approx(room_rate(0.3 - q, 0.01, np.inf))
    assert -out.lower[0] == pytest.approx(room_rate(q + 0.3, 0.01, np.inf))


def test_bounds_follow_the_position_without_any_other_limit():
    """A controller without position limits computes its bounds once, unless a joint is confined."""
    ctl = slide(velocity_limits=1.0, period=0.01)
    assert pushed(ctl, 5.0, q=0.0).upper[0] == 1.0
    ctl.fail("j1", sr.Confined(-1.0, 0.5))
    assert [pushed(ctl, 5.0, q=q).upper[0] for q in (0.0, 0.495, 0.6)] == [1.0, pytest.approx(0.5), 0.0]
    ctl.restore("j1")
    assert pushed(ctl, 5.0, q=0.6).upper[0] == 1.0


@pytest.mark.parametrize("law", [sr.LeastError(), sr.KeepDirection(), sr.SingularityRobust()], ids=repr)
def test_an_arm_with_confined_joints_keeps_them_inside(law):
    arm, period = mixed(9), 0.005
    ctl = sr.Controller(arm, law=law, velocity_limits=1.0, acceleration_limits=8.0, period=period)
    q = configuration(arm)
    for joint in (1, 4, 6):
        ctl.fail(joint, sr.Confined(q[joint] - 0.05, q[joint] + 0.08))
    low, high = q[[1, 4, 6]] - 0.05, q[[1, 4, 6]] + 0.08
    reached = np.zeros(3, bool)
    for t in range(600):
        out = ctl.step(q, 3.0 * TWIST * np.sign(np.sin(t / 90)))
        q = q + period * out.rates
        reached |= np.abs(out.active[[1, 4, 6]]) == sr.Reason.FAULT
        assert np.all((q[[1, 4, 6]] >= low - 1e-12) & (q[[1, 4, 6]] <= high + 1e-12))
        assert not out.status & sr.Status.LIMIT_GIVEN_UP
    assert np.any(reached)


def test_return_rate_brings_a_joint_back_into_its_range():
    arm = paper()
    ctl = sr.Controller(arm, velocity_limits=1.0, return_rate=0.2, transition_rate=0.0, period=0.01)
    q = Q_PAPER.copy()
    ctl.fail("j5", sr.Confined(q[4] + 0.1, q[4] + 0.5))
    for _ in range(200):
        q += 0.01 * ctl.step(q, np.zeros(6)).rates
    assert Q_PAPER[4] + 0.1 - 1e-6 <= q[4] <= Q_PAPER[4] + 0.5


def test_centring_aims_at_the_middle_of_the_range():
    arm = sr.arms.planar(4)
    ctl = sr.Controller(
        arm, task=sr.Task(rows=(True, *[False] * 5)), null_motion=sr.null_motions.Centring(), period=0.01
    )
    for joint in range(4):
        ctl.fail(joint, sr.Confined(0.2 + 0.1 * joint, 0.6 + 0.1 * joint))
    q = np.array([0.2, 0.6, 0.5, 0.9])
    tool = arm.forward(q)[0, 3]
    for _ in range(3000):
        q += 0.01 * ctl.track(q, _at(arm, q, tool)).rates
    middle = 0.4 + 0.1 * np.arange(4)
    assert np.linalg.norm(q - middle) < np.linalg.norm([0.2, 0.1, -0.1, 0.2])


def _at(arm, q, x):
    pose = arm.forward(q)
    pose[0, 3] = x
    return pose


def test_a_confined_joint_works_and_counts_with_its_rate_limit():
    """Its price is that of a healthy joint; where its range leaves it no rate the status is saturated, not failed."""
    ctl, free = slide(velocity_limits=1.0, period=0.01), slide(velocity_limits=1.0, period=0.01)
    ctl.fail("j1", sr.Confined(0.0, 0.0))
    out = pushed(ctl, 1.0, q=0.0)
    assert sr.Status.SATURATED in out.status
    assert sr.Status.NO_WORKING_JOINT not in out.status
    arm = paper()
    confined_arm, healthy = (sr.Controller(arm, velocity_limits=0.3) for _ in range(2))
    for joint in range(arm.n):
        confined_arm.fail(joint, sr.Confined(-7.0, 7.0))
    np.testing.assert_array_equal(confined_arm.step(Q_PAPER, 20 * TWIST).rates, healthy.step(Q_PAPER, 20 * TWIST).rates)
    assert pushed(free, 1.0).rates[0] == 1.0


@pytest.mark.parametrize("ends", [(0.5, 0.4), (np.nan, 1.0), (np.inf, np.inf), (-np.inf, -np.inf)])
def test_a_range_without_a_position_is_refused(ends):
    refused(lambda: sr.Confined(*ends), "lower")
