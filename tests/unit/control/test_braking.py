"""Braking distance: a joint driven at its position limit stops there, and never brakes harder than it may."""

import numpy as np
import pytest

import stillreach as sr
from tests.unit.control.robots import mixed, pushed, slide

LIMIT = 1.0
DRIVES = [(2.0, 4.0), (0.7, 1.0), (3.3, 50.0), (1.0, 0.6), (0.05, 7.0)]  # rate limit, acceleration limit
PERIODS = [1e-3, 0.01, 0.037, 0.1]
ACCELERATION, PERIOD = 5.0, 0.01  # of an arm among whose joints some brake


def drive(rate, acceleration, period, side, *, start=-0.2):
    """Full speed at the limit until well after it must have stopped: positions (T + 1,), rates (T,), statuses.

    Where nothing would happen for long it starts nearer.
    """
    ctl = slide(position_limits=(-LIMIT, LIMIT), velocity_limits=rate, acceleration_limits=acceleration, period=period)
    start = max(start, LIMIT - rate**2 / acceleration - 200 * rate * period)
    steps = int(2 * ((LIMIT - start) / rate + rate / acceleration) / period) + 50
    q, positions, rates, status = side * start, [side * start], [], sr.Status.OK
    for _ in range(steps):
        out = pushed(ctl, side * 10.0 * rate, q=q)
        q += period * out.rates[0]
        positions.append(q)
        rates.append(out.rates[0])
        status |= out.status
    return side * np.array(positions), side * np.array(rates), status


CASES = [(*limits, period) for limits in DRIVES for period in PERIODS]


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("rate", "acceleration", "period"), CASES)
def test_it_never_passes_the_limit_and_stops_there(rate, acceleration, period, side):
    positions, rates, _ = drive(rate, acceleration, period, side)
    assert np.max(positions) <= LIMIT + 1e-12
    assert LIMIT - positions[-1] <= 1e-3 + acceleration * period**2
    assert abs(rates[-1]) <= 1e-3 * rate + acceleration * period
    assert np.max(rates) <= rate


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("rate", "acceleration", "period"), CASES)
def test_it_never_breaks_its_acceleration_limit_on_the_way(rate, acceleration, period, side):
    _, rates, status = drive(rate, acceleration, period, side)
    changes = np.abs(np.diff(np.concatenate(([0.0], rates)))) / period
    assert np.max(changes) <= acceleration * (1 + 1e-9)
    assert not status & sr.Status.LIMIT_GIVEN_UP


@pytest.mark.parametrize("start", np.linspace(-0.3, 0.3, 7))
def test_where_it_started_makes_no_difference_to_that(start):
    positions, rates, status = drive(2.0, 4.0, 0.01, 1, start=start)
    assert np.max(positions) <= LIMIT + 1e-12
    assert np.max(np.abs(np.diff(rates))) <= 0.04 * (1 + 1e-9)
    assert not status & sr.Status.LIMIT_GIVEN_UP


def test_the_braking_curve_is_used_not_only_respected():
    """It brakes late: with short periods the time to the limit is within 2 % of the fastest possible one."""
    rate, acceleration, period = 2.0, 4.0, 1e-3
    positions, _, _ = drive(rate, acceleration, period, 1)
    ramp = rate / acceleration
    fastest = 2 * ramp + (LIMIT + 0.2 - rate * ramp) / rate
    assert np.argmax(positions > LIMIT - 1e-3) * period <= 1.02 * fastest


def test_without_an_acceleration_limit_it_arrives_in_one_tick():
    ctl = slide(position_limits=(-LIMIT, LIMIT), period=0.1)
    assert pushed(ctl, 100.0, q=0.75).rates[0] == pytest.approx(2.5, rel=1e-12)
    assert pushed(ctl, -100.0, q=-0.75).rates[0] == pytest.approx(-2.5, rel=1e-12)


@pytest.mark.parametrize(
    "law", [sr.LeastError(), sr.KeepDirection(), sr.SingularityRobust()], ids=lambda x: type(x).__name__
)
def test_a_whole_arm_stays_inside_every_limit_while_it_is_pushed_about(law):
    arm = mixed()
    rng = np.random.default_rng(31)
    position, acceleration, rate, period = 1.0, 5.0, 1.5, 0.01
    ctl = sr.Controller(
        arm,
        law=law,
        position_limits=(-position, position),
        velocity_limits=rate,
        acceleration_limits=acceleration,
        period=period,
    )
    q, last = np.zeros(arm.n), np.zeros(arm.n)
    for t in range(800):
        if t % 100 == 0:
            twist = 3.0 * rng.normal(size=6)
        rates = ctl.step(q, twist).rates
        assert np.max(np.abs(rates)) <= rate
        assert np.max(np.abs(rates - last)) <= acceleration * period * (1 + 1e-9)
        q, last = q + period * rates, rates
        assert np.max(np.abs(q)) <= position + 1e-12


def brake_in_a_crowd(q, twist, nudge):
    """100 ticks of an arm whose joints run into their limits: rates (T, n), damping (T,), statuses, q (n,)."""
    arm = sr.arms.nasa_modular().with_limits(position=(-2.5, 2.5), acceleration=ACCELERATION)
    ctl = sr.Controller(arm, law=sr.LeastError(), period=PERIOD, velocity_limits=np.deg2rad(50))
    for joint in (1, 3, 6):
        ctl.fail(joint)
    q, rates, damping, status = q + nudge, [], [], sr.Status.OK
    for _ in range(100):
        out = ctl.step(q, twist)
        q = q + PERIOD * out.rates
        rates.append(out.rates)
        damping.append(out.damping)
        status |= out.status
    return np.array(rates), np.array(damping), status, q


def test_rounding_does_not_choose_which_joints_count_while_one_brakes():
    """On its braking curve a joint has one rate left up to rounding; it was fixed in one tick and free in the next."""
    rng = np.random.default_rng(6)
    braked = 0
    for _ in range(60):
        q, twist = rng.uniform(-2.0, 2.0, 11), 0.5 * rng.normal(size=6)
        rates, damping, status, end = brake_in_a_crowd(q, twist, 0.0)
        others = brake_in_a_crowd(q, twist, 1e-13 * rng.standard_normal(11))
        assert not status & sr.Status.LIMIT_GIVEN_UP
        assert np.max(np.abs(np.diff(rates, axis=0, prepend=0.0))) <= ACCELERATION * PERIOD * (1 + 1e-12)
        assert np.max(np.abs(rates - others[0])) <= 1e-9
        assert np.max(np.abs(damping - others[1])) <= 1e-9
        braked += np.max(np.abs(end)) > 2.4  # joints came to their limits
    assert braked >= 5
