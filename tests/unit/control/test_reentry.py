"""Calls inside calls: gradients that come back to the controller, Ctrl-C in them, and cycles of references."""

import gc
import weakref

import numpy as np
import pytest

import stillreach as sr

N = 10
ARM = sr.arms.snake(N)
Q = np.linspace(0.1, 0.5, N)
TWIST = [0.01, 0, 0, 0, 0, 0]
OTHER = np.full(N, 0.7)


def with_gradient(action, value=0.0, **settings):
    """A controller whose gradient calls action(controller), once."""
    done = []

    def gradient(_):
        if not done:
            done.append(True)
            action(ctl)
        return np.full(N, value)

    ctl = sr.Controller(ARM, null_motion=sr.null_motions.Gradient(gradient=gradient), **settings)
    return ctl


@pytest.mark.parametrize(
    "action",
    [
        lambda ctl: ctl.reset(np.full(N, 0.3)),
        lambda ctl: ctl.step(OTHER, TWIST),
        lambda ctl: ctl.track(OTHER, ARM.forward(OTHER)),
        lambda ctl: ctl.bind(q=OTHER, twist=np.zeros(6), rates=np.empty(N))(),
    ],
    ids=["reset", "step", "track", "tick"],
)
def test_a_tick_answers_for_its_own_q_whatever_its_gradient_calls(action):
    ctl = with_gradient(action)
    np.testing.assert_allclose(ctl.step(Q, TWIST).jacobian, ARM.jacobian(Q))
    ctl = with_gradient(action)
    np.testing.assert_allclose(ctl.track(Q, ARM.forward(Q)).jacobian, ARM.jacobian(Q))


def test_a_conversion_that_steps_the_same_controller_changes_no_answer():
    class Twist:
        def __array__(self, dtype=None, copy=None):
            ctl.step(OTHER, np.zeros(6))
            return np.array(TWIST, dtype=float)

    ctl = sr.Controller(ARM)
    solution = ctl.step(Q, Twist())
    np.testing.assert_allclose(solution.jacobian, ARM.jacobian(Q))
    np.testing.assert_allclose(solution.rates, sr.Controller(ARM).step(Q, TWIST).rates, atol=1e-9)


def test_a_null_motion_set_inside_a_gradient_counts_from_the_next_tick_on():
    still = np.zeros(6)
    ctl = with_gradient(lambda ctl: ctl.set_null_motion(sr.null_motions.Rates(rates=np.full(N, 0.05))), value=-0.2)
    plain = sr.Controller(ARM, null_motion=sr.null_motions.Gradient(gradient=np.full(N, -0.2)))
    np.testing.assert_allclose(ctl.step(Q, still).rates, plain.step(Q, still).rates, atol=1e-9)
    plain.set_null_motion(sr.null_motions.Rates(rates=np.full(N, 0.05)))
    np.testing.assert_allclose(ctl.step(Q, still).rates, plain.step(Q, still).rates, atol=1e-9)


def test_a_joint_that_fails_inside_a_gradient_stands_still_in_the_same_tick():
    ctl = with_gradient(lambda ctl: ctl.fail("j3"), value=0.4)
    assert ctl.step(Q, TWIST).rates[2] == 0.0
    assert list(ctl.faults) == ["j3"]


def test_a_tick_inside_a_gradient_that_changes_the_null_motion_leaves_the_new_one():
    def action(ctl):
        ctl.set_null_motion(sr.null_motions.Rates(rates=np.full(N, 0.05)))
        ctl.step(OTHER, np.zeros(6))

    ctl = with_gradient(action, value=-0.2)
    ctl.step(Q, np.zeros(6))
    plain = sr.Controller(ARM, null_motion=np.full(N, 0.05))
    np.testing.assert_allclose(ctl.step(Q, np.zeros(6)).rates, plain.step(Q, np.zeros(6)).rates, atol=1e-9)


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, GeneratorExit])
def test_what_is_no_exception_in_a_gradient_ends_the_bound_loop(error):
    def gradient(_):
        raise error

    rates = np.full(N, 7.0)
    tick = sr.Controller(ARM, null_motion=sr.null_motions.Gradient(gradient=gradient)).bind(
        q=Q, twist=np.zeros(6), rates=rates
    )
    with pytest.raises(error):
        tick()
    np.testing.assert_array_equal(rates, 7.0)


def test_an_interrupted_simulation_in_a_gradient_ends_the_bound_loop():
    def gradient(_):
        raise sr.errors.SimulationInterrupted(None)

    ctl = sr.Controller(ARM, null_motion=sr.null_motions.Gradient(gradient=gradient))
    with pytest.raises(KeyboardInterrupt):
        ctl.bind(q=Q, twist=np.zeros(6), rates=np.empty(N))()


def test_a_tick_without_memory_for_its_answer_did_not_happen(monkeypatch):
    ctl = sr.Controller(ARM, acceleration_limits=1.0)
    with pytest.raises(sr.InputError, match="out"):
        ctl.step(Q, TWIST, out=np.zeros(N + 1))
    np.testing.assert_array_equal(ctl.last_rates, 0.0)


def test_out_resized_by_the_gradient_is_refused_and_not_written_to():
    out = np.zeros(N)
    ctl = with_gradient(lambda _: out.resize(1000, refcheck=False))
    with pytest.raises(sr.InputError, match="out"):
        ctl.step(Q, TWIST, out=out)


class Robot:
    """Owns its controller, whose gradient is a method of its own."""

    def __init__(self):
        self.controller = sr.Controller(sr.arms.planar(7), null_motion=sr.null_motions.Gradient(gradient=self.gradient))

    def gradient(self, q):
        return np.zeros_like(q)


class Array(np.ndarray):
    """An array that can hold attributes."""


def stepped_robot():
    robot = Robot()
    robot.controller.step(np.zeros(7), np.zeros(6))
    return robot


def controller_with_its_tick():
    ctl = sr.Controller(sr.arms.planar(7))
    ctl.tick = ctl.bind(q=np.zeros(7), twist=np.zeros(6), rates=np.zeros(7))
    return ctl


def array_with_its_tick():
    rates = np.zeros(7).view(Array)
    rates.tick = sr.Controller(sr.arms.planar(7)).bind(q=np.zeros(7), twist=np.zeros(6), rates=rates)
    return rates


def array_with_its_solution():
    out = np.zeros(7).view(Array)
    out.solution = sr.Controller(sr.arms.planar(7)).step(np.zeros(7), np.zeros(6), out=out)
    return out


@pytest.mark.parametrize(
    "make", [Robot, stepped_robot, controller_with_its_tick, array_with_its_tick, array_with_its_solution]
)
def test_cycles_through_the_core_are_collected(make):
    if make is controller_with_its_tick and not hasattr(sr.Controller, "__dict__"):
        pytest.skip("controllers take no attributes")
    alive = [weakref.ref(make()) for _ in range(5)]
    gc.collect()
    assert [ref() for ref in alive] == [None] * 5


@pytest.mark.parametrize("wrong", [object(), 3, None])
def test_bind_refuses_what_is_no_controller(wrong):
    with pytest.raises(TypeError):
        sr.Controller.bind(wrong, q=np.zeros(3), twist=np.zeros(6), rates=np.zeros(3))


@pytest.mark.filterwarnings("ignore:nanobind")
def test_bind_refuses_a_controller_before_its_init():
    early = sr.Controller.__new__(sr.Controller)
    with pytest.raises(TypeError):
        early.bind(q=np.zeros(0), twist=np.zeros(6), rates=np.zeros(0))
    gc.collect()


def test_a_masked_value_is_no_measurement():
    ctl = sr.Controller(ARM)
    masked = np.ma.masked_array(Q, mask=np.arange(N) == 3)
    with pytest.raises(sr.InputError, match="masked"):
        ctl.step(masked, TWIST)
    with pytest.raises(sr.InputError, match="masked"):
        ctl.bind(q=masked, twist=np.zeros(6), rates=np.empty(N))
    with pytest.raises(sr.InputError, match="masked"):
        ARM.forward(masked)
    whole = np.ma.masked_array(Q)
    np.testing.assert_array_equal(ctl.step(whole, TWIST).rates, sr.Controller(ARM).step(Q, TWIST).rates)
