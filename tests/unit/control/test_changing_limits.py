"""set_limits and set_speed while the loop runs: what is refused, and how rates come down to new limits."""

import copy

import numpy as np
import pytest

import stillreach as sr
from tests.unit.control.robots import Q_PAPER, TWIST, mixed, paper, pushed, refused, slide

PERIOD, ACCELERATION = 0.01, 2.0  # a step of 0.02 a tick


def moving(rate=1.0, q=0.0, **limits):
    """A slide at `rate`, and where it is after the last tick."""
    ctl = slide(velocity_limits=2.0, acceleration_limits=ACCELERATION, period=PERIOD, **limits)
    ctl.reset([rate])
    return ctl, q


def ridden(ctl, q, command, ticks):
    """Rates and positions of some ticks that push at `command`, and all statuses."""
    rates, places, status = [], [], sr.Status.OK
    for _ in range(ticks):
        out = pushed(ctl, command, q)
        q += PERIOD * float(out.rates[0])
        status |= out.status
        rates.append(float(out.rates[0]))
        places.append(q)
    return np.array(rates), np.array(places), status


@pytest.mark.parametrize(
    "name",
    ["velocity_limits", "position_limits", "acceleration_limits", "period", "track_gain", "speed"],
)
def test_a_setting_that_is_assigned_to_is_refused_not_ignored(name):
    ctl = slide()
    with pytest.raises(AttributeError, match=f"{name} cannot be set.*set_limits"):
        setattr(ctl, name, 0.05)


def test_a_controller_may_keep_its_bound_tick_and_a_copy_has_none():
    ctl, rates = slide(), np.zeros(1)
    ctl.tick = ctl.bind(q=np.zeros(1), twist=np.ones(6), rates=rates)
    ctl.tick()
    assert rates[0] == 1.0
    assert not hasattr(copy.copy(ctl), "tick")


def test_a_subclass_may_have_attributes_of_its_own_but_no_setting_by_assignment():
    class Named(sr.Controller):
        pass

    ctl = Named(paper())
    ctl.note = "welder"
    assert ctl.note == "welder"
    with pytest.raises(AttributeError):
        ctl.velocity_limits = 0.1


def test_rates_come_down_to_a_lower_velocity_limit_within_the_acceleration_limit():
    ctl, q = moving(1.0)
    ctl.set_limits(velocity=0.3)
    rates, _, status = ridden(ctl, q, 5.0, 60)
    np.testing.assert_allclose(rates, np.maximum(1.0 - 0.02 * np.arange(1, 61), 0.3), atol=1e-12)
    assert not status & sr.Status.LIMIT_GIVEN_UP


def test_each_side_has_its_own_new_limit():
    ctl, q = moving(-1.0)
    ctl.set_limits(velocity=[[-0.5, 0.1]])
    rates, _, _ = ridden(ctl, q, -5.0, 40)
    np.testing.assert_allclose(rates, np.minimum(-1.0 + 0.02 * np.arange(1, 41), -0.5), atol=1e-12)
    rates, _, _ = ridden(ctl, q, 5.0, 60)
    np.testing.assert_allclose(rates[-1], 0.1, atol=1e-12)


def test_a_higher_velocity_limit_is_approached_within_the_acceleration_limit():
    ctl, q = moving(2.0)
    ctl.set_limits(velocity=3.0)
    rates, _, _ = ridden(ctl, q, 9.0, 60)
    np.testing.assert_allclose(rates, np.minimum(2.0 + 0.02 * np.arange(1, 61), 3.0), atol=1e-12)


def test_without_acceleration_limits_a_new_velocity_limit_holds_at_once():
    ctl = slide(velocity_limits=2.0, period=PERIOD)
    pushed(ctl, 1.5)
    ctl.set_limits(velocity=0.25)
    out = pushed(ctl, 1.5)
    assert out.rates[0] == 0.25
    assert out.upper[0] == 0.25


def test_once_kept_a_new_limit_goes_before_the_acceleration_limit_again():
    ctl, q = moving(0.5)
    ctl.set_limits(velocity=0.4)
    ridden(ctl, q, 5.0, 20)
    ctl.reset([1.0])
    out = pushed(ctl, 5.0)
    assert out.rates[0] == 0.4
    assert out.status & sr.Status.LIMIT_GIVEN_UP


def test_a_fault_does_not_wait_for_a_limit_that_closes_in():
    ctl, _ = moving(1.0)
    ctl.set_limits(velocity=0.5)
    ctl.fail(0, sr.Derated(0.5))
    out = pushed(ctl, 5.0)
    assert out.rates[0] == 0.25
    assert out.status & sr.Status.LIMIT_GIVEN_UP


def test_a_joint_that_cannot_stop_before_a_new_position_limit_brakes_passes_and_stays():
    """From 1 m/s by 0.02 a tick: 0.98 + ... + 0.02 m/s for 0.01 s each are 0.245 m; the limit is 0.1 m away."""
    ctl, q = moving(1.0)
    ctl.set_limits(position=(-5.0, 0.1))
    rates, places, status = ridden(ctl, q, 5.0, 80)
    np.testing.assert_allclose(rates, np.maximum(1.0 - 0.02 * np.arange(1, 81), 0.0), atol=1e-12)
    np.testing.assert_allclose(places[-1], 0.245, atol=1e-12)
    assert not status & sr.Status.LIMIT_GIVEN_UP
    back, _, _ = ridden(ctl, places[-1], -5.0, 3)
    np.testing.assert_allclose(back, [-0.02, -0.04, -0.06], atol=1e-12)


def test_a_joint_that_can_stop_before_a_new_position_limit_does():
    ctl, q = moving(1.0)
    ctl.set_limits(position=(-5.0, 0.6))
    rates, places, status = ridden(ctl, q, 5.0, 200)
    assert np.abs(np.diff(np.concatenate([[1.0], rates]))).max() <= 0.02 + 1e-9
    assert 0.59 < places[-1] <= 0.6 + 1e-12
    assert not status & sr.Status.LIMIT_GIVEN_UP


def test_new_acceleration_limits_are_the_new_window():
    ctl, q = moving(0.0)
    ctl.set_limits(acceleration=0.5)
    rates, _, _ = ridden(ctl, q, 5.0, 5)
    np.testing.assert_allclose(rates, 0.005 * np.arange(1, 6), atol=1e-15)
    assert ctl.acceleration_limits.tolist() == [0.5]


def test_limits_may_come_by_joint_name():
    ctl = sr.Controller(paper())
    ctl.set_limits(velocity={name: k / 10 for k, name in reversed(list(enumerate(paper().joint_names)))})
    np.testing.assert_allclose(ctl.velocity_limits[:, 1], np.arange(11) / 10)
    ctl.set_limits(position={name: (-k, k + 1) for k, name in reversed(list(enumerate(paper().joint_names)))})
    np.testing.assert_array_equal(ctl.position_limits[:, 1], np.arange(11) + 1)


BAD_LIMITS = {
    "velocity": [-1.0, np.nan, "fast", [1.0, 2.0], [[1], [1, 2]], np.full((8, 2), 0.1), np.full((3, 2), 0.0), True],
    "position": [(1.0, -1.0), 1.0, (np.inf, np.inf), (-np.inf, -np.inf), [[0.0, 1.0]] * 7, [(0.0, 1.0), (0.0,)]],
    "acceleration": [-1.0, [1.0] * 7, np.full((8, 2), 1.0), {"j1": 1.0}],
}


@pytest.mark.parametrize(
    ("name", "value"), [(name, value) for name in BAD_LIMITS for value in BAD_LIMITS[name]], ids=str
)
def test_refused_limits_change_nothing(name, value):
    ctl, twin = (sr.Controller(mixed(), velocity_limits=1.0, acceleration_limits=20.0, period=PERIOD) for _ in range(2))
    good = {"velocity": 0.1, "position": (-0.1, 0.1), "acceleration": 0.1}
    refused(lambda: ctl.set_limits(**{**good, name: value}), name)
    constructor = "velocity_limits" if name == "velocity" else f"{name}_limits"
    refused(lambda: sr.Controller(mixed(), **{constructor: value}), constructor)
    q = np.linspace(-0.7, 0.9, 8)
    np.testing.assert_array_equal(ctl.step(q, TWIST).rates, twin.step(q, TWIST).rates)


LAWS = [sr.LeastError(), sr.LeastError(price=None), sr.KeepDirection(), sr.Pseudoinverse(), sr.SingularityRobust()]


@pytest.mark.parametrize("law", LAWS, ids=repr)
@pytest.mark.parametrize("size", [0.5, 20.0])
def test_at_a_lower_speed_the_arm_does_the_same_more_slowly(law, size):
    """Command, null motion and limits at a fraction: so are the rates, whether or not limits hold them."""
    full, slow = (
        sr.Controller(paper(), law=law, velocity_limits=1.0, null_motion=sr.null_motions.Centring()) for _ in range(2)
    )
    slow.set_speed(0.25)
    out = slow.step(Q_PAPER, size * TWIST)
    np.testing.assert_allclose(out.rates, 0.25 * full.step(Q_PAPER, size * TWIST).rates, rtol=1e-7, atol=1e-9)
    assert out.upper.max() == 0.25


def test_the_speed_slows_an_arm_without_limits_too_and_may_be_0():
    free = sr.Controller(mixed(), velocity_limits=np.inf)
    before = free.step(np.zeros(8), TWIST).rates
    free.set_speed(0.5)
    np.testing.assert_allclose(free.step(np.zeros(8), TWIST).rates, 0.5 * before, rtol=1e-9)
    free.set_speed(0.0)
    assert not free.step(np.zeros(8), TWIST).rates.any()


def test_a_correction_is_slowed_as_well():
    arm = paper()
    target = arm.forward(Q_PAPER + 0.01)
    full, slow = (sr.Controller(arm) for _ in range(2))
    slow.set_speed(0.1)
    np.testing.assert_allclose(slow.track(Q_PAPER, target).twist, 0.1 * full.track(Q_PAPER, target).twist, rtol=1e-12)


def test_the_speed_goes_down_and_up_within_the_acceleration_limits_and_leaves_the_limits():
    ctl, q = moving(1.0)
    ctl.set_speed(0.2)
    rates, _, status = ridden(ctl, q, 1.0, 60)
    np.testing.assert_allclose(rates, np.maximum(1.0 - 0.02 * np.arange(1, 61), 0.2), atol=1e-12)
    ctl.set_speed(1.0)
    rates, _, _ = ridden(ctl, q, 1.0, 60)
    np.testing.assert_allclose(rates, np.minimum(0.2 + 0.02 * np.arange(1, 61), 1.0), atol=1e-12)
    assert ctl.velocity_limits.tolist() == [[-2.0, 2.0]]
    assert not status & sr.Status.LIMIT_GIVEN_UP


def test_speed_and_velocity_limits_multiply():
    ctl = slide(velocity_limits=2.0)
    ctl.set_speed(0.5)
    ctl.set_limits(velocity=0.8)
    assert pushed(ctl, 9.0).rates[0] == 0.4
    ctl.set_speed(1.0)
    assert pushed(ctl, 9.0).rates[0] == 0.8


@pytest.mark.parametrize("value", [-0.1, 1.1, np.nan, np.inf, "half", None, True, [0.5]])
def test_a_speed_is_a_fraction(value):
    ctl = slide(velocity_limits=2.0)
    refused(lambda: ctl.set_speed(value), "fraction")
    assert ctl.speed == 1.0
    assert pushed(ctl, 9.0).rates[0] == 2.0


def test_a_bound_tick_sees_new_limits():
    ctl, q, rates = (
        slide(velocity_limits=2.0, acceleration_limits=ACCELERATION, period=PERIOD),
        np.zeros(1),
        np.zeros(1),
    )
    ctl.reset([1.0])
    tick = ctl.bind(q=q, twist=np.array([9.0, 0, 0, 0, 0, 0]), rates=rates)
    ctl.set_limits(velocity=0.5)
    tick()
    assert rates[0] == pytest.approx(0.98, abs=1e-12)


def test_every_joint_of_an_arm_closes_in_on_its_own_limit():
    """Slowed from a fast motion to a tenth, never by more than the acceleration limit a tick."""
    arm, period, limit = paper(), 0.01, 1.0
    ctl = sr.Controller(arm, period=period, acceleration_limits=limit)
    q = Q_PAPER
    for _ in range(200):
        q = q + period * ctl.step(q, [-0.5, 0.2, 0, 0, 0, 0.3]).rates
    last = ctl.last_rates
    new = 0.1 * arm.velocity_limits
    assert np.any(np.abs(last) > new)
    ctl.set_limits(velocity=new)
    for _ in range(150):
        out = ctl.step(q, [-0.5, 0.2, 0, 0, 0, 0.3])
        assert np.abs(out.rates - last).max() <= limit * period + 1e-12
        assert not out.status & sr.Status.LIMIT_GIVEN_UP
        q, last = q + period * out.rates, out.rates
    assert np.all(np.abs(last) <= new + 1e-12)
