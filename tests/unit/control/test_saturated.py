"""A joint that limits leave one rate works and is saturated; a joint that a fault leaves one rate has failed."""

import numpy as np
import pytest

import stillreach as sr

PERIOD = 0.01
LEFT_ONE_RATE = {
    "a rate limit of 0": {"velocity": [0.0, 1.0, 1.0]},
    "a range of one point": {"position": [(0.3, 0.3), (-3, 3), (-3, 3)]},
    "no acceleration": {"acceleration": [0.0, 5.0, 5.0]},
}
FAULTS = {"locked": sr.Locked(), "runaway": sr.Runaway(0.01), "derated to nothing": sr.Derated(0.0)}
LAWS = (sr.LeastError(), sr.KeepDirection(), sr.SingularityRobust(), sr.Pseudoinverse())
EVERY_LAW = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
Q = np.array([0.3, 0.9, -0.8])
TASK = sr.Task(rows=(True, True, False, False, False, False))
SLOWLY = np.array([1e-4, 0, 0, 0, 0, 0])
"""[m/s] far from every other limit."""


def planar(**limits):
    return sr.arms.planar(3).with_limits(**limits)


@pytest.mark.parametrize("limits", LEFT_ONE_RATE.values(), ids=LEFT_ONE_RATE)
@EVERY_LAW
def test_a_joint_that_a_limit_leaves_one_rate_is_saturated(law, limits):
    out = sr.Controller(planar(**limits), law=law, task=TASK, period=PERIOD).step(Q, SLOWLY)
    assert out.rates[0] == 0.0
    assert out.status & sr.Status.SATURATED
    assert abs(out.active[0]) > sr.Reason.FAULT


@pytest.mark.parametrize("kind", FAULTS.values(), ids=FAULTS)
@EVERY_LAW
def test_a_joint_that_a_fault_leaves_one_rate_is_not(law, kind):
    ctl = sr.Controller(planar(velocity=10.0), law=law, task=TASK)
    ctl.fail(0, kind)
    out = ctl.step(Q, SLOWLY)
    assert not out.status & sr.Status.SATURATED
    assert abs(out.active[0]) == sr.Reason.FAULT


@EVERY_LAW
def test_no_working_joint_is_said_of_faults_only(law):
    limited = sr.Controller(planar(velocity=0.0), law=law, task=TASK)
    out = limited.step(Q, SLOWLY)
    assert out.status & sr.Status.SATURATED
    assert not out.status & sr.Status.NO_WORKING_JOINT
    for joint in range(3):
        limited.fail(joint)
    out = limited.step(Q, SLOWLY)
    assert out.status & sr.Status.NO_WORKING_JOINT
    assert not out.status & sr.Status.SATURATED


def test_a_derated_joint_with_a_choice_left_works():
    ctl = sr.Controller(planar(position=[(0.3, 0.3), (-3, 3), (-3, 3)]), task=TASK)
    ctl.fail(0, sr.Derated(0.5))
    assert ctl.step(Q, SLOWLY).status & sr.Status.SATURATED


def test_the_flag_lasts_as_long_as_bounds_that_do_not_change():
    """With rate limits alone the bounds are computed once; the flag stays with them, and goes with a fault."""
    ctl = sr.Controller(planar(velocity=[0.0, 1.0, 1.0]), task=TASK)
    q, twist, rates = Q.copy(), SLOWLY.copy(), np.zeros(3)
    tick = ctl.bind(q=q, twist=twist, rates=rates)
    assert all(tick() & sr.Status.SATURATED for _ in range(3))
    ctl.fail(0)
    assert not tick() & sr.Status.SATURATED
    ctl.restore(0)
    assert tick() & sr.Status.SATURATED


@pytest.mark.parametrize("acceleration", [np.inf, 0.5, 5.0])
@EVERY_LAW
def test_a_joint_that_brakes_before_its_limit_is_saturated_alone_and_in_a_batch(law, acceleration):
    arm = planar(position=[(-3, 0.6), (-3, 3), (-3, 3)], velocity=1.0, acceleration=acceleration)
    ctl = sr.Controller(arm, law=law, task=TASK, period=PERIOD)
    q, braking = Q.copy(), 0
    for _ in range(150):
        twist, last = arm.jacobian(q) @ [0.5, 0.2, 0.0], ctl.last_rates
        out = ctl.step(q, twist)
        if abs(out.active[0]) == sr.Reason.POSITION:
            braking += 1
            assert out.status & sr.Status.SATURATED
        batch = sr.solve_batch(
            arm,
            law,
            q[None],
            twist[None],
            sr.Bounds.symmetric(1.0, n=3),
            task=TASK,
            last_rates=last[None],
            period=PERIOD,
            want="active",
        )
        if not isinstance(law, sr.KeepDirection):  # which remembers its last plane
            assert batch.status[0] == out.status
            assert np.array_equal(batch.active[0], out.active)
        q = q + PERIOD * out.rates
    assert braking >= 5


def test_a_rollout_of_many_says_it_too():
    arm = planar(position=[(0.3, 0.3), (-3, 3), (-3, 3)])
    out = sr.rollout_batch(
        arm, sr.LeastError(), Q[None], SLOWLY, sr.Bounds.symmetric(1.0, n=3), period=PERIOD, steps=3, task=TASK
    )
    assert out.any_status[0] & sr.Status.SATURATED
