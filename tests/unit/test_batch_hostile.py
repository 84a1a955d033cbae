"""Batches under signal handlers, without memory, at the end of the process, and with bounds that leave out 0."""

import signal
import subprocess
import sys

import numpy as np
import pytest

import stillreach as sr

HEAD = """
import os, resource, signal, sys, threading, time
import numpy as np
import stillreach as sr
"""


def child(code):
    """Exit code and standard error of Python code in a process of its own."""
    done = subprocess.run([sys.executable, "-c", HEAD + code], capture_output=True, text=True, timeout=120, check=False)
    return done.returncode, done.stderr


def test_a_rollout_inside_a_signal_handler_changes_no_other():
    arm, big = sr.arms.nasa_modular(), sr.arms.snake(120)
    bounds, wide = sr.Bounds.symmetric(1.0, n=11), sr.Bounds.symmetric(1.0, n=120)
    q = np.random.default_rng(0).uniform(-1, 1, (64, 11))
    nested = []

    def handler(*_):
        twist = [0.1] * 6
        nested.append(
            sr.rollout_batch(
                big, sr.LeastError(), np.full((4, 120), 0.1), twist, wide, period=0.001, steps=2, threads=1
            )
        )
        sr.solve_batch(big, sr.LeastError(), np.full((4, 120), 0.1), twist, wide, threads=2)
        big.jacobian(np.full((100, 120), 0.1))

    def rollout(threads):
        return sr.rollout_batch(arm, sr.LeastError(), q, [0.01] * 6, bounds, period=0.001, steps=3000, threads=threads)

    first = rollout(1)
    before = signal.signal(signal.SIGALRM, handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.03, 0.03)
        again = [rollout(1), rollout(2)]
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert nested
    for other in again:
        np.testing.assert_array_equal(first.final_q, other.final_q)


def test_a_batch_whose_threads_get_no_memory_raises_memory_error():
    code, error = child("""
n = 1000
arm = sr.arms.snake(n)
q, out, bounds = np.zeros((600, n)), np.empty((600, n)), sr.Bounds.symmetric(1.0, n=n)
law = sr.LeastError(weights=sr.Weights(joints=np.eye(n)))
now = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (now + 45 * 2**20,) * 2)
try:
    sr.solve_batch(arm, law, q, [0.1] * 6, bounds, threads=3, out=out)
except MemoryError:
    sys.exit(5)
""")
    assert code == 5, error


@pytest.mark.parametrize("call", ["sr.solve_batch(arm, law, q, [0.1] * 6, b, threads=2)", "arm.jacobian(q)"])
def test_the_end_of_the_process_does_not_wait_for_a_batch_of_a_daemon_thread(call):
    code, error = child(f"""
arm, law = sr.arms.nasa_modular(), sr.LeastError()
q, b = np.random.default_rng(0).random((200000, 11)), sr.Bounds.symmetric(1.0, n=11)
def work():
    while True:
        {call}
threading.Thread(target=work, daemon=True).start()
time.sleep(0.3)
""")
    assert (code, error) == (0, "")


TASK = sr.Task(rows=(True, True, False, False, False, False))


@pytest.mark.parametrize("acceleration", [5.0, np.inf])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    "law", [sr.LeastError(), sr.SingularityRobust(), sr.KeepDirection()], ids=lambda law: type(law).__name__
)
def test_rate_bounds_that_leave_out_0_come_before_position_and_acceleration_limits(acceleration, side, law):
    """A drive that creeps at 0.3 to 0.5 rad/s at its position limit: 0.3 is right, with LIMIT_GIVEN_UP."""
    arm = sr.arms.planar(3).with_limits(velocity=10.0, position=(-1.0, 1.0), acceleration=acceleration)
    bounds = np.sort(side * np.array([[0.3, 0.5], [-1, 1], [-1, 1]]), axis=1)
    run = sr.rollout_batch(
        arm,
        law,
        side * np.array([[1.0, 0.2, 0.1]]),
        [0.1, 0, 0, 0, 0, 0],
        (bounds[None, :, 0], bounds[None, :, 1]),
        task=TASK,
        last_rates=side * np.array([[0.4, 0.0, 0.0]]),
        period=0.01,
        steps=6,
        record=("rates", "status"),
    )
    np.testing.assert_array_equal(run.rates[0, :, 0], side * 0.3)
    assert np.all(run.status & sr.Status.LIMIT_GIVEN_UP)


def test_rates_outside_the_acceleration_window_are_bounded_and_said():
    """From rest, 0.3 rad/s at once breaks 5 rad/s² over 10 ms (0.05 rad/s); the rate bound holds."""
    arm = sr.arms.planar(3).with_limits(velocity=10.0, acceleration=5.0)
    batch = sr.solve_batch(
        arm, sr.LeastError(), np.zeros((1, 3)), np.zeros(6), (np.array([[0.3, -1, -1]]), np.array([[0.5, 1, 1]])),
        task=TASK, last_rates=np.zeros((1, 3)), period=0.01,
    )  # fmt: skip
    assert batch.rates[0, 0] == 0.3
    assert batch.status[0] & sr.Status.LIMIT_GIVEN_UP


def test_far_from_the_limits_such_bounds_give_up_nothing():
    arm = sr.arms.planar(3).with_limits(velocity=10.0, position=(-1.0, 1.0), acceleration=50.0)
    batch = sr.solve_batch(
        arm, sr.LeastError(), np.zeros((1, 3)), np.zeros(6), (np.array([[0.3, -1, -1]]), np.array([[0.5, 1, 1]])),
        task=TASK, last_rates=np.zeros((1, 3)), period=0.01,
    )  # fmt: skip
    assert 0.3 <= batch.rates[0, 0] <= 0.5
    assert not batch.status[0] & sr.Status.LIMIT_GIVEN_UP


START = [[np.nan] * 7, [1e300] * 7, ["a"] * 7, [None] * 7, np.ones(7, bool), [0.5] * 7, [1] * 6, 3, {}]


@pytest.mark.parametrize("start", START, ids=repr)
def test_a_start_that_is_no_active_bounds_is_refused(start):
    J = np.random.default_rng(0).random((6, 7))
    with pytest.raises(sr.InputError, match="start"):
        sr.LeastError().solve(J, [0.1] * 6, sr.Bounds.symmetric(1.0, n=7), start=start)


def test_weights_at_the_end_of_the_numbers_leave_damping_a_number():
    arm, q = sr.arms.nasa_modular(), np.linspace(0.1, 1, 11)
    law = sr.SingularityRobust(weights=sr.Weights(joints=np.full(11, 5e-324)))
    assert not np.isnan(sr.Controller(arm, law=law).step(q, [0.1] * 6).damping)
