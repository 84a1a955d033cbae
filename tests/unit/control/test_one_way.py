"""One-way joints: they never move to the other side, whatever is commanded and whatever they did before."""

import numpy as np
import pytest

import stillreach as sr
from tests.unit.control.robots import LAWS, TWIST, configuration, mixed, pushed, refused, slide

INSIDE = [law for law in LAWS if not isinstance(law, sr.Pseudoinverse)]
PERIOD, ACCELERATION = 0.01, 2.0
SIDES = pytest.mark.parametrize("side", [1, -1])


def one_way(side, **limits):
    """A slide that moves to one side only."""
    ctl = slide(velocity_limits=[(-0.8, 1.0)], period=PERIOD, **limits)
    ctl.fail("j1", sr.OneWay(side))
    return ctl


@SIDES
def test_its_bounds_are_those_of_the_table(side):
    out = pushed(one_way(side), 0.0)
    assert (out.lower[0], out.upper[0]) == ((0.0, 1.0) if side > 0 else (-0.8, 0.0))


@SIDES
@pytest.mark.parametrize("law", INSIDE, ids=repr)
def test_no_law_moves_it_to_the_other_side(law, side):
    arm = mixed(9)
    ctl = sr.Controller(arm, law=law, velocity_limits=0.5, period=PERIOD)
    joints = [0, 3, 5, 7]
    for joint in joints:
        ctl.fail(joint, sr.OneWay(side))
    q = configuration(arm)
    for t in range(100):
        out = ctl.step(q, np.roll(TWIST, t) * np.cos(t))
        assert np.all(side * out.rates[joints] >= 0.0)
        q = q + PERIOD * out.rates


@SIDES
def test_a_joint_at_its_blocked_side_has_the_fault_as_reason(side):
    out = pushed(one_way(side), -side * 1.0)
    assert out.rates[0] == 0.0
    assert out.active[0] == -side * sr.Reason.FAULT
    assert sr.Status.SATURATED in out.status
    assert pushed(one_way(side), side * 5.0).active[0] == side * sr.Reason.RATE


@SIDES
def test_a_joint_that_moves_the_other_way_stops_at_once(side):
    """The fault goes before the acceleration limit, and the status says so."""
    ctl = slide(velocity_limits=1.0, period=PERIOD, acceleration_limits=ACCELERATION)
    ctl.reset([-side * 0.5])
    ctl.fail("j1", sr.OneWay(side))
    out = pushed(ctl, -side * 1.0)
    assert out.rates[0] == 0.0
    assert sr.Status.LIMIT_GIVEN_UP in out.status


@SIDES
def test_it_slows_down_within_its_acceleration_limit_and_stops_at_zero(side):
    """The window of the acceleration limit closes on the fault's bound: 0.05, 0.03, 0.01, 0 and not below."""
    ctl = one_way(side, acceleration_limits=ACCELERATION)
    ctl.reset([side * 0.07])
    rates = [side * float(pushed(ctl, -side * 1.0).rates[0]) for _ in range(6)]
    np.testing.assert_allclose(rates, [0.05, 0.03, 0.01, 0.0, 0.0, 0.0], atol=1e-15)


@SIDES
def test_limits_that_close_in_never_move_it_to_the_other_side(side):
    """Both come between two ticks: the fault, and a rate limit that it is too fast for, in the wrong direction."""
    ctl = slide(velocity_limits=1.0, period=PERIOD, acceleration_limits=ACCELERATION)
    ctl.reset([-side * 0.9])
    ctl.fail("j1", sr.OneWay(side))
    ctl.set_limits(velocity=0.1)
    for _ in range(5):
        assert side * pushed(ctl, -side * 1.0).rates[0] >= 0.0


@SIDES
def test_a_new_rate_limit_closes_in_on_the_side_that_is_left(side):
    ctl = one_way(side, acceleration_limits=ACCELERATION)
    ctl.reset([side * 0.5])
    ctl.set_limits(velocity=0.45)
    rates = [side * float(pushed(ctl, side * 1.0).rates[0]) for _ in range(4)]
    np.testing.assert_allclose(rates, [0.48, 0.46, 0.45, 0.45], atol=1e-12)


@SIDES
def test_it_works_also_where_every_joint_is_one_way(side):
    arm = sr.arms.planar(3)
    ctl = sr.Controller(arm, task=sr.Task(rows="position"), velocity_limits=0.0, period=PERIOD)
    for joint in range(3):
        ctl.fail(joint, sr.OneWay(side))
    out = ctl.step(np.array([0.3, 0.5, 0.4]), np.array([1.0, 0, 0, 0, 0, 0]))
    assert sr.Status.NO_WORKING_JOINT not in out.status
    assert sr.Status.SATURATED in out.status


@SIDES
def test_the_price_counts_in_the_rate_limit_of_the_side_that_is_left(side):
    """Where the task gives way, |error| / damping is the price times the typical rate."""
    arm, price = mixed(9), 0.5
    ctl = sr.Controller(arm, law=sr.LeastError(price=price), velocity_limits=np.tile([-3.0, 1.0], (9, 1)))
    for joint in range(arm.n):
        ctl.fail(joint, sr.OneWay(side))
    out = ctl.step(configuration(arm), 20.0 * TWIST)
    assert out.damping > 0.0
    assert out.task_error / out.damping == pytest.approx(price * (1.0 if side > 0 else 3.0), rel=1e-6)


@pytest.mark.parametrize("direction", [0, 0.5, np.nan, "+", None])
def test_a_direction_is_one_of_two(direction):
    refused(lambda: sr.OneWay(direction), "direction")
