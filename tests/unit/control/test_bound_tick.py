"""tick(): arrays bound once, read and written in place; it never raises, and recovers from what it was fed."""

import gc
import weakref

import numpy as np
import pytest

import stillreach as sr
from tests.unit.control.robots import TWIST, configuration, mixed

N = 8
LAWS = [sr.LeastError(), sr.KeepDirection(), sr.SingularityRobust(), sr.Pseudoinverse()]
EVERY_LAW = pytest.mark.parametrize("law", LAWS, ids=repr)


def bound(ctl, **extra):
    """Arrays and their tick."""
    q, twist, rates = configuration(ctl.arm), TWIST.copy(), np.full(N, 7.0)
    return q, twist, rates, ctl.bind(q=q, twist=twist, rates=rates, **extra)


@EVERY_LAW
def test_tick_and_step_give_the_same_rates(law):
    one, other = (sr.Controller(mixed(), law=law, velocity_limits=0.1) for _ in range(2))
    q, twist, rates, tick = bound(one)
    for i in range(30):
        twist[:] = np.sin(i + np.arange(6))
        if i == 10:
            one.fail("j3")
            other.fail("j3")
        status = tick()
        expected = other.step(q, twist)
        np.testing.assert_array_equal(rates, expected.rates)
        assert status == expected.status
        assert isinstance(status, sr.Status)
        q += 0.01 * rates


def test_tick_reads_and_writes_in_place():
    q, twist, rates, tick = bound(sr.Controller(mixed()))
    tick()
    first = rates.copy()
    twist[:] = -TWIST
    tick()
    np.testing.assert_allclose(rates, -first, rtol=1e-9)
    twist[:] = 0
    q[:] = 0.1
    tick()
    np.testing.assert_array_equal(rates, 0.0)


def test_bind_keeps_its_arrays_and_its_controller_alive():
    ctl = sr.Controller(mixed())
    q, twist, rates, tick = bound(ctl)
    expected = sr.Controller(mixed()).step(q, twist).rates
    kept = weakref.ref(rates)
    del ctl, q, twist, rates
    gc.collect()
    trash = [np.full(N, np.nan) for _ in range(1000)]
    assert not tick() & sr.Status.INVALID_INPUT
    np.testing.assert_array_equal(kept(), expected)
    del tick, trash
    gc.collect()
    assert kept() is None


def test_a_bound_array_cannot_be_resized_away():
    q, _, _, tick = bound(sr.Controller(mixed()))
    with pytest.raises(ValueError, match=r"resize|reference"):
        q.resize(10_000)
    tick()


@pytest.mark.parametrize(
    "overlap", ["q is rates", "q and rates, shifted", "twist in rates", "twist and rates, shifted", "one array"]
)
def test_overlapping_arrays_are_read_before_rates_are_written(overlap):
    memory = np.zeros(3 * N)
    q, rates, twist = {
        "q is rates": (memory[:N], memory[:N], memory[2 * N : 2 * N + 6]),
        "q and rates, shifted": (memory[:N], memory[3 : N + 3], memory[2 * N : 2 * N + 6]),
        "twist in rates": (memory[:N], memory[N : 2 * N], memory[N : N + 6]),
        "twist and rates, shifted": (memory[:N], memory[N : 2 * N], memory[N + 5 : N + 11]),
        "one array": (memory[:N], memory[:N], memory[:6]),
    }[overlap]
    tick = sr.Controller(mixed()).bind(q=q, twist=twist, rates=rates)
    q[:] = configuration(mixed())
    if overlap != "one array":
        twist[:] = TWIST
    expected = sr.Controller(mixed()).step(q.copy(), twist.copy()).rates
    tick()
    np.testing.assert_array_equal(rates, expected)


def test_two_ticks_of_one_controller_share_its_state():
    ctl = sr.Controller(mixed(), acceleration_limits=1.0, period=0.01)
    _, twist, rates, tick = bound(ctl)
    _, _, others, other = bound(ctl)
    twist[:] *= 100
    tick()
    np.testing.assert_array_equal(ctl.last_rates, rates)
    other()
    assert np.max(np.abs(others - rates)) <= 0.01 * (1 + 1e-12)


@EVERY_LAW
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("where", ["q", "twist", "target"])
def test_input_that_is_no_number_stops_the_arm_and_failed_joints_keep_their_rates(law, value, where):
    ctl = sr.Controller(mixed(), law=law)
    target = ctl.arm.forward(configuration(ctl.arm)) if where == "target" else None
    q, twist, rates, tick = bound(ctl, **({} if target is None else {"target": target}))
    ctl.fail("j2")
    ctl.fail("j5", sr.Runaway(-0.3))
    tick()
    {"q": q, "twist": twist, "target": target}[where].flat[3] = value
    for _ in range(3):
        assert tick() & sr.Status.INVALID_INPUT
        np.testing.assert_array_equal(rates, np.where(np.arange(N) == 4, -0.3, 0.0))


@pytest.mark.parametrize("place", [*np.ndindex(4, 4), np.s_[:3, 0]], ids=str)
def test_a_nan_anywhere_in_the_target_and_a_mirrored_axis_stop_the_arm(place):
    ctl = sr.Controller(mixed())
    target = ctl.arm.forward(configuration(ctl.arm))
    _, _, rates, tick = bound(ctl, target=target)
    target[place] *= -1.0 if isinstance(place[0], slice) else np.nan
    assert tick() & sr.Status.INVALID_INPUT
    assert np.all(rates == 0.0)


@EVERY_LAW
def test_braking_keeps_the_acceleration_limits_and_ends_at_rest(law):
    ctl = sr.Controller(mixed(), law=law, acceleration_limits=2.0, period=0.01, velocity_limits=1.0)
    q, twist, rates, tick = bound(ctl)
    twist *= 3
    for _ in range(20):
        tick()
    assert np.max(np.abs(rates)) > 0.05
    twist[4] = np.nan
    for _ in range(60):
        before = rates.copy()
        assert tick() & sr.Status.INVALID_INPUT
        np.testing.assert_allclose(np.abs(rates), np.maximum(np.abs(before) - 0.02, 0.0), atol=1e-15)
        q += 0.01 * rates
    assert np.all(rates == 0.0)


def test_one_broken_encoder_does_not_free_the_others_from_their_position_limits():
    ctl = sr.Controller(mixed(), position_limits=(-1.0, 1.0), acceleration_limits=1.0, period=0.01)
    ctl.reset(np.full(N, 0.5))
    q, _, rates, tick = bound(ctl)
    q[:] = 1.0
    q[0] = np.nan
    assert tick() & sr.Status.INVALID_INPUT
    assert rates[0] == pytest.approx(0.49)
    assert np.all(rates[1:] == 0.0)


@EVERY_LAW
def test_a_healthy_tick_after_a_bad_one_is_as_good_as_ever(law):
    ctl = sr.Controller(mixed(), law=law)
    q, twist, rates, tick = bound(ctl)
    tick()
    expected, kept = rates.copy(), q[2]
    q[2] = np.nan
    tick()
    q[2] = kept
    assert not tick() & sr.Status.INVALID_INPUT
    np.testing.assert_allclose(rates, expected, rtol=1e-9)
    twist[0] = np.inf
    tick()
    twist[0] = TWIST[0]
    assert not tick() & sr.Status.INVALID_INPUT
    np.testing.assert_allclose(rates, expected, rtol=1e-9)


@EVERY_LAW
@pytest.mark.parametrize("size", [1e308, 1e200, 1e-308, 5e-324])
@pytest.mark.parametrize("where", ["q", "twist"])
def test_huge_and_tiny_input_is_answered_inside_the_bounds(law, size, where):
    ctl = sr.Controller(mixed(), law=law, velocity_limits=1.0)
    q, twist, rates, tick = bound(ctl)
    {"q": q, "twist": twist}[where][:] = size
    tick()
    assert np.all(np.isfinite(rates))
    if not isinstance(law, sr.Pseudoinverse):
        assert np.max(np.abs(rates)) <= 1.0
