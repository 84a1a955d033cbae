"""A fault is a bound: health and limits of each joint as one interval per tick, in the stated order of precedence."""

import numpy as np
import pytest

import stillreach as sr
from oracles.bounds_table import joint_bounds, room_rate
from tests.unit.control.robots import ALONG_X, configuration, mixed, pushed, slide

PERIOD = 0.01
FAULTS = {
    "healthy": None,
    "locked": sr.Locked(),
    "free": sr.FreeSwinging(),
    "derated": sr.Derated(0.3),
    "runaway": sr.Runaway(0.4),
    "one way": sr.OneWay(1),
    "the other way": sr.OneWay(-1),
    "confined": sr.Confined(-0.9, 0.4999),
    "confined apart": sr.Confined(1.1, np.inf),
}
ORACLE_FAULTS = {
    "healthy": None,
    "locked": "locked",
    "free": "locked",
    "derated": ("derated", 0.3),
    "runaway": ("runaway", 0.4),
    "one way": ("one-way", 1),
    "the other way": ("one-way", -1),
    "confined": ("confined", -0.9, 0.4999),
    "confined apart": ("confined", 1.1, np.inf),
}


def draw(rng, n):
    """Limits, positions and last rates for n joints, odd ones included."""
    pick = lambda *values: rng.choice(values, n)  # noqa: E731
    rate = np.stack([-pick(0.0, 0.5, 1.0, np.inf), pick(0.0, 0.2, 1.0, np.inf)], axis=1)
    position = np.stack([-pick(0.0, 1.0, np.inf), pick(0.0, 1.0, np.inf)], axis=1)
    q = pick(-1.2, -1.0, -0.999, 0.0, 0.5, 0.998, 1.0, 1.3)
    return rate, position, q, pick(-2.0, -0.3, 0.0, 0.1, 0.9, 3.0), pick(0.0, 1.0, 50.0, np.inf)


def answer(rate, position, q, last, acceleration, health):
    """One tick of an arm with these limits: its Solution."""
    ctl = sr.Controller(
        mixed(len(q)), period=PERIOD, velocity_limits=rate, position_limits=position, acceleration_limits=acceleration
    )
    for joint, name in enumerate(health):
        if FAULTS[name]:
            ctl.fail(joint, FAULTS[name])
    ctl.reset(last)
    return ctl.step(q, np.zeros(6))


@pytest.mark.parametrize("seed", range(60))
def test_the_interval_of_each_joint_is_the_one_in_the_table(seed):
    """Without braking curves (position and acceleration limits never meet in one joint) the table is exact."""
    rng = np.random.default_rng([21, seed])
    n = 8
    rate, position, q, last, acceleration = draw(rng, n)
    acceleration = np.where(np.all(np.isinf(position), axis=1), acceleration, np.inf)
    health = rng.choice(list(FAULTS), n)
    acceleration[np.char.startswith(health, "confined")] = np.inf
    out = answer(rate, position, q, last, acceleration, health)
    given_up = False
    for i in range(n):
        low, high, gave = joint_bounds(
            fault=ORACLE_FAULTS[health[i]],
            rate=rate[i].tolist(),
            position=position[i].tolist(),
            q=float(q[i]),
            period=PERIOD,
            last=float(last[i]),
            acceleration=float(acceleration[i]),
        )
        given_up |= gave
        np.testing.assert_allclose((out.lower[i], out.upper[i]), (low, high), rtol=1e-12, atol=1e-15)
    assert bool(out.status & sr.Status.LIMIT_GIVEN_UP) == given_up
    assert np.all(out.rates >= out.lower)
    assert np.all(out.rates <= out.upper)


@pytest.mark.parametrize("seed", range(40))
def test_a_joint_with_every_limit_is_never_allowed_more_than_the_continuous_braking_curve(seed):
    rng = np.random.default_rng([22, seed])
    n = 8
    rate, position, q, last, acceleration = draw(rng, n)
    out = answer(rate, position, q, last, acceleration, ["healthy"] * n)
    room = np.stack([position[:, 1] - q, q - position[:, 0]], axis=1)
    for i in range(n):
        up, down = (room_rate(float(side), PERIOD, float(acceleration[i])) for side in room[i])
        assert -down * (1 + 1e-12) <= out.lower[i] <= out.upper[i] <= up * (1 + 1e-12)


def test_a_fault_goes_before_every_limit():
    limits = {"velocity_limits": 0.1, "position_limits": (-1.0, 0.0), "acceleration_limits": 0.5, "period": PERIOD}
    ctl = slide(**limits)
    ctl.fail("j1", sr.Runaway(3.0))
    assert pushed(ctl, -1.0, q=0.5).rates[0] == 3.0
    ctl.fail("j1", sr.Locked())
    assert pushed(ctl, -1.0, q=0.5).rates[0] == 0.0


def test_a_rate_limit_goes_before_an_acceleration_limit():
    ctl = slide(velocity_limits=0.1, acceleration_limits=1.0, period=PERIOD)
    ctl.reset([0.5])
    out = pushed(ctl, 1.0)
    assert out.rates[0] == 0.1
    assert out.status & sr.Status.LIMIT_GIVEN_UP


def test_a_position_limit_goes_before_an_acceleration_limit():
    ctl = slide(position_limits=(-1.0, 1.0), acceleration_limits=1.0, period=PERIOD)
    ctl.reset([0.5])
    out = pushed(ctl, 1.0, q=1.0)
    assert out.rates[0] == 0.0
    assert out.status & sr.Status.LIMIT_GIVEN_UP
    ctl.reset([-0.5])
    assert pushed(ctl, -1.0, q=-1.0).rates[0] == 0.0


@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_that_gives_up_its_acceleration_limit_is_at_the_bound_on_that_side(side):
    ctl = slide(position_limits=(-1.0, 1.0), acceleration_limits=1.0, period=PERIOD)
    ctl.reset([side * 0.5])
    out = pushed(ctl, side * 1.0, q=side * 1.0)
    assert sr.Status.LIMIT_GIVEN_UP in out.status
    assert out.active[0] == side * sr.Reason.POSITION


@pytest.mark.parametrize("acceleration", [0.0, 1e-320, 1e-12])
def test_a_joint_that_can_hardly_brake_still_does_not_pass_its_position_limit(acceleration):
    ctl = slide(position_limits=(-1.0, 1.0), acceleration_limits=acceleration, period=PERIOD)
    ctl.reset([3.0])
    out = pushed(ctl, 3.0, q=0.995)
    assert 0.995 + PERIOD * out.rates[0] <= 1.0
    assert out.status & sr.Status.LIMIT_GIVEN_UP


def test_limits_that_agree_give_nothing_up():
    ctl = slide(velocity_limits=1.0, position_limits=(-1.0, 1.0), acceleration_limits=100.0, period=PERIOD)
    assert not pushed(ctl, 5.0).status & sr.Status.LIMIT_GIVEN_UP


@pytest.mark.parametrize("law", [sr.LeastError(), sr.KeepDirection(), sr.SingularityRobust(), sr.Pseudoinverse()])
def test_a_zero_limit_means_zero_not_none(law):
    arm = mixed(11)
    limits = np.where(np.arange(11) % 3 == 0, 0.0, 1.0)
    out = sr.Controller(arm, law=law, velocity_limits=limits).step(configuration(arm), np.ones(6))
    assert np.all(out.rates[::3] == 0.0)
    assert np.any(out.rates != 0.0)


def test_zero_limits_on_every_joint_stop_the_arm_whose_joints_still_work():
    arm = mixed()
    for limits in ({"velocity_limits": 0.0}, {"position_limits": (0.0, 0.0)}, {"acceleration_limits": 0.0}):
        out = sr.Controller(arm, **limits).step(np.zeros(8), np.ones(6))
        assert np.all(out.rates == 0.0)
        assert out.status & sr.Status.SATURATED
        assert not out.status & sr.Status.NO_WORKING_JOINT


def test_an_infinite_limit_is_none():
    arm = mixed()
    q = configuration(arm)
    free = sr.Controller(arm, velocity_limits=np.inf, law=sr.LeastError(price=None)).step(q, 1e6 * np.ones(6))
    np.testing.assert_allclose(free.rates, np.linalg.pinv(arm.jacobian(q)) @ (1e6 * np.ones(6)), rtol=1e-9)


def test_a_rate_limit_may_differ_by_side():
    ctl = slide(velocity_limits=[[-0.1, 0.7]])
    assert pushed(ctl, 5.0).rates[0] == 0.7
    assert pushed(ctl, -5.0).rates[0] == -0.1
    one_way = slide(velocity_limits=[[0.0, np.inf]])
    assert pushed(one_way, -5.0).rates[0] == 0.0
    assert pushed(one_way, 5.0).rates[0] == pytest.approx(5.0)


def test_the_arms_own_limits_are_the_default():
    arm = sr.arms.canadarm2()
    out = sr.Controller(arm).step(np.full(7, 0.3), np.full(6, 50.0))
    np.testing.assert_allclose(np.max(np.abs(out.rates)), np.deg2rad(4), rtol=1e-12)


@pytest.mark.parametrize(
    ("limits", "last", "q", "rate", "reason"),
    [
        ({"velocity_limits": 0.5}, 0.0, 0.0, 2.0, sr.Reason.RATE),
        ({"position_limits": (-1.0, 1.0)}, 0.0, 0.995, 2.0, sr.Reason.POSITION),
        ({"position_limits": (-1.0, 1.0), "acceleration_limits": 400.0}, 3.0, 0.95, 9.0, sr.Reason.POSITION),
        ({"acceleration_limits": 3.0}, 0.1, 0.0, 2.0, sr.Reason.ACCELERATION),
        ({"velocity_limits": 0.5, "acceleration_limits": 3.0}, 0.48, 0.0, 2.0, sr.Reason.RATE),
    ],
)
@pytest.mark.parametrize("side", [1, -1])
def test_an_active_bound_says_why_and_on_which_side(limits, last, q, rate, reason, side):
    ctl = slide(period=PERIOD, **limits)
    ctl.reset([side * last])
    out = pushed(ctl, side * rate, q=side * q)
    assert out.active[0] == side * reason
    assert out.status & sr.Status.SATURATED


@pytest.mark.parametrize("side", [1, -1])
def test_an_active_bound_of_a_derated_joint_is_its_fault(side):
    ctl = slide(velocity_limits=1.0)
    ctl.fail(0, sr.Derated(0.25))
    out = pushed(ctl, 3.0 * side)
    assert out.rates[0] == 0.25 * side
    assert out.active[0] == side * sr.Reason.FAULT


def test_a_failed_joint_gives_its_fault_as_the_reason_and_a_free_one_none():
    arm = mixed()
    ctl = sr.Controller(arm, velocity_limits=100.0)
    ctl.fail(1)
    ctl.fail(2, sr.Runaway(0.01))
    out = ctl.step(configuration(arm), 1e-3 * np.ones(6))
    assert np.abs(out.active[1]) == np.abs(out.active[2]) == sr.Reason.FAULT
    assert np.all(np.delete(out.active, [1, 2]) == sr.Reason.FREE)


@pytest.mark.parametrize("side", [1, -1])
def test_a_joint_outside_its_limits_moves_back_if_asked_never_further_out_and_is_not_forced(side):
    ctl = slide(position_limits=(-1.0, 1.0), velocity_limits=2.0, period=PERIOD)
    assert pushed(ctl, side * 1.0, q=side * 1.2).rates[0] == 0.0
    assert pushed(ctl, 0.0, q=side * 1.2).rates[0] == 0.0
    assert pushed(ctl, -side * 1.0, q=side * 1.2).rates[0] == pytest.approx(-side)


def test_a_return_rate_asks_joints_outside_back_without_disturbing_the_task():
    arm = mixed()
    q = configuration(arm)
    limits = np.stack([np.full(8, -10.0), np.full(8, 10.0)], axis=1)
    limits[4] = (q[4] + 0.3, 5.0)
    quiet, asked = (
        sr.Controller(arm, position_limits=limits, velocity_limits=9.0, return_rate=rate).step(q, np.zeros(6))
        for rate in (0.0, 0.2)
    )
    np.testing.assert_array_equal(quiet.rates, 0.0)
    assert 0.0 < asked.rates[4] <= 0.2
    np.testing.assert_allclose(asked.residual, 0.0, atol=1e-12)


def test_a_joint_that_the_task_leaves_free_returns_at_the_return_rate_and_stops_at_its_limit():
    joints = [sr.Joint(kind="prismatic", axis=(1, 0, 0)), sr.Joint(kind="prismatic", axis=(0, 1, 0))]
    limits = [(-9.0, 9.0), (-1.0, 1.0)]
    ctl = sr.Controller(sr.Arm(joints), task=ALONG_X, position_limits=limits, return_rate=0.5, period=PERIOD)
    q = np.array([0.0, 1.0125])
    seen = []
    for _ in range(5):
        rates = ctl.step(q, np.zeros(6)).rates
        seen.append(rates[1])
        q = q + PERIOD * rates
    np.testing.assert_allclose(seen, [-0.5, -0.5, -0.25, 0.0, 0.0], atol=1e-9)
    assert q[1] == pytest.approx(1.0, abs=1e-12)


def test_a_locked_joint_outside_its_limits_stays_where_it_is():
    ctl = slide(position_limits=(-1.0, 1.0), return_rate=0.5)
    ctl.fail(0)
    assert pushed(ctl, -1.0, q=2.0).rates[0] == 0.0


@pytest.mark.parametrize(
    ("settings", "argument"),
    [
        ({"period": 0.0}, "period"),
        ({"period": np.nan}, "period"),
        ({"period": "1 ms"}, "period"),
        ({"velocity_limits": -1.0}, "velocity_limits"),
        ({"velocity_limits": np.nan}, "velocity_limits"),
        ({"velocity_limits": np.ones(5)}, "velocity_limits"),
        ({"velocity_limits": [[0.1, 1.0]] * 8}, "velocity_limits"),
        ({"position_limits": [[1.0, -1.0]] * 8}, "position_limits"),
        ({"position_limits": (1.0, -1.0)}, "position_limits"),
        ({"position_limits": np.zeros(8)}, "position_limits"),
        ({"acceleration_limits": -1.0}, "acceleration_limits"),
        ({"acceleration_limits": np.ones(7)}, "acceleration_limits"),
        ({"return_rate": -0.1}, "return_rate"),
        ({"transition_rate": np.inf}, "transition_rate"),
        ({"track_gain": -1.0}, "track_gain"),
        ({"track_limits": (1.0, -1.0)}, "track_limits"),
        ({"null_motion": np.zeros(7)}, "null_motion"),
        ({"null_motion": "centre"}, "null_motion"),
        ({"law": "least error"}, "law"),
        ({"task": "position"}, "task"),
    ],
    ids=str,
)
def test_a_setting_that_is_none_is_refused_by_name(settings, argument):
    with pytest.raises(sr.InputError) as caught:
        sr.Controller(mixed(), **settings)
    assert caught.value.argument == argument
