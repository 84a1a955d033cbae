"""Faults are the controller's state: any joint, any time, several at once, and restored."""

import numpy as np
import pytest

import stillreach as sr
from oracles.box import excess_error_bound
from tests.unit.control.robots import EVERY_LAW, Q_PAPER, TWIST, configuration, mixed, paper, refused

ARMS = {"paper": (paper, Q_PAPER), "mixed": (lambda: mixed(11), None)}


@pytest.fixture(params=ARMS)
def arm_at(request):
    """(arm, configuration) in turn."""
    make, q = ARMS[request.param]
    arm = make()
    return arm, configuration(arm) if q is None else q


@EVERY_LAW
def test_several_joints_fail_at_once_by_name_and_by_index(law, arm_at):
    arm, q = arm_at
    ctl = sr.Controller(arm, law=law, velocity_limits=50.0)
    ctl.fail("j2")
    ctl.fail(3)
    ctl.fail("j7", sr.Runaway(0.02))
    ctl.fail(np.int64(8), sr.Derated(0.5))
    out = ctl.step(q, TWIST)
    assert np.all(out.rates[[1, 3]] == 0.0)
    assert out.rates[6] == 0.02
    assert (out.lower[8], out.upper[8]) == (-25.0, 25.0)
    np.testing.assert_allclose(out.residual, 0.0, atol=1e-9)
    np.testing.assert_array_equal(ctl.health, [0, 1, 0, 1, 0, 0, 3, 0, 2, 0, 0])
    assert ctl.faults == {"j2": sr.Locked(), "j4": sr.Locked(), "j7": sr.Runaway(0.02), "j9": sr.Derated(0.5)}


@EVERY_LAW
@pytest.mark.parametrize("scale", [1.0, 1e3, 0.0])
def test_a_locked_joint_has_rate_exactly_zero_whatever_is_asked(law, scale, arm_at):
    arm, q = arm_at
    ctl = sr.Controller(arm, law=law, null_motion=np.ones(11), velocity_limits=1.0)
    for failed in ([0], [10], [1, 3, 6], list(range(10)), list(range(11))):
        for joint in range(arm.n):
            ctl.restore(joint)
        for joint in failed:
            ctl.fail(joint)
        for _ in range(3):
            out = ctl.step(q, scale * TWIST)
            assert np.all(out.rates[failed] == 0.0)
            assert np.all(np.isfinite(out.rates))
    assert out.status & sr.Status.NO_WORKING_JOINT


@EVERY_LAW
@pytest.mark.parametrize("rate", [0.05, -0.3])
def test_a_runaway_joint_is_made_up_for_by_the_others(law, rate, arm_at):
    arm, q = arm_at
    ctl = sr.Controller(arm, law=law, velocity_limits=100.0)
    ctl.fail(4, sr.Runaway(rate))
    out = ctl.step(q, np.zeros(6))
    assert out.rates[4] == rate
    assert out.task_error < 1e-9
    assert np.linalg.norm(arm.jacobian(q) @ out.rates) < 1e-9
    assert not out.status & sr.Status.FAULT_NOT_COMPENSATED


@EVERY_LAW
def test_a_runaway_joint_that_nobody_can_make_up_for_is_reported(law):
    """Of four parallel joints three stand still: the tool of a planar arm must move."""
    arm = sr.arms.planar(4)
    ctl = sr.Controller(arm, law=law, task=sr.Task(rows=(True, True, False, False, False, False)))
    ctl.fail("j1", sr.Runaway(0.1))
    for joint in ("j2", "j3"):
        ctl.fail(joint)
    out = ctl.step(np.array([0.2, 0.5, -0.4, 0.3]), np.zeros(6))
    assert out.rates[0] == 0.1
    assert out.task_error > 1e-3
    assert out.status & sr.Status.FAULT_NOT_COMPENSATED


@EVERY_LAW
def test_a_task_out_of_reach_is_not_blamed_on_a_runaway_joint(law):
    """The tool could stand still in spite of it; only the twist is more than the arm can do, with and without."""
    ctl = sr.Controller(paper(), law=law, velocity_limits=0.2)
    ctl.fail(1, sr.Runaway(0.01))
    out = ctl.step(Q_PAPER, [0, 0, -50.0, 0, 0, 0])
    assert out.task_error > 1.0 or sr.Status.OVER_LIMIT in out.status
    assert not out.status & sr.Status.FAULT_NOT_COMPENSATED
    assert ctl.step(Q_PAPER, np.zeros(6)).task_error < 1e-9


@pytest.mark.parametrize("law", [sr.LeastError(price=None), sr.KeepDirection()], ids=repr)
def test_what_cannot_be_made_up_for_is_done_as_well_as_it_can_be(law):
    arm = paper()
    ctl = sr.Controller(arm, law=law, velocity_limits=0.2)
    ctl.fail(1, sr.Runaway(2.0))
    out = ctl.step(Q_PAPER, np.zeros(6))
    assert out.status & sr.Status.FAULT_NOT_COMPENSATED
    assert np.max(np.abs(np.delete(out.rates, 1))) <= 0.2
    assert excess_error_bound(arm.jacobian(Q_PAPER), np.zeros(6), out.lower, out.upper, out.rates) < 1e-9


@EVERY_LAW
def test_every_joint_failed_is_answered(law):
    arm = mixed(11)
    ctl = sr.Controller(arm, law=law)
    for joint in range(11):
        ctl.fail(joint)
    out = ctl.step(np.zeros(11), TWIST)
    assert np.all(out.rates == 0.0)
    assert out.status & sr.Status.NO_WORKING_JOINT
    ctl.fail(5, sr.Runaway(-1.5))
    out = ctl.step(np.zeros(11), np.zeros(6))
    np.testing.assert_array_equal(out.rates, np.where(np.arange(11) == 5, -1.5, 0.0))
    assert out.status & sr.Status.FAULT_NOT_COMPENSATED


@EVERY_LAW
def test_a_restored_arm_answers_as_if_nothing_had_been(law, arm_at):
    arm, q = arm_at
    fresh = sr.Controller(arm, law=law, transition_rate=0.0).step(q, TWIST)
    ctl = sr.Controller(arm, law=law, transition_rate=0.0)
    for joint, kind in ((1, sr.Locked()), (5, sr.Derated(0.0)), (8, sr.Runaway(1.0))):
        ctl.fail(joint, kind)
    ctl.step(q, TWIST)
    for joint in (1, "j6", 8):
        ctl.restore(joint)
    assert ctl.faults == {}
    assert not np.any(ctl.health)
    np.testing.assert_allclose(ctl.step(q, TWIST).rates, fresh.rates, rtol=1e-9, atol=1e-12)


def test_derated_to_nothing_is_locked_and_to_one_is_healthy():
    arm = mixed()
    q = configuration(arm)
    for limit in (1.0, np.inf):
        ctl = sr.Controller(arm, velocity_limits=limit)
        ctl.fail(2, sr.Derated(0.0))
        assert ctl.step(q, 5 * TWIST).rates[2] == 0.0
        ctl.fail(2, sr.Derated(1.0))
        out = ctl.step(q, 5 * TWIST)
        assert (out.lower[2], out.upper[2]) == (-limit, limit)


def test_a_second_fault_of_a_joint_takes_the_place_of_the_first():
    arm = mixed()
    ctl = sr.Controller(arm, velocity_limits=1.0)
    ctl.fail("j3", sr.Derated(0.5))
    ctl.fail(2, sr.Runaway(-0.1))
    assert ctl.faults == {"j3": sr.Runaway(-0.1)}
    assert ctl.step(configuration(arm), TWIST).rates[2] == -0.1
    ctl.fail("j3")
    ctl.fail("j3")
    assert ctl.step(configuration(arm), TWIST).rates[2] == 0.0
    ctl.restore("j3")
    assert ctl.faults == {}


def test_restoring_a_healthy_joint_changes_nothing():
    arm = mixed(11)
    q = configuration(arm)
    one, other = (sr.Controller(arm, null_motion=np.ones(11)) for _ in range(2))
    for ctl in (one, other):
        ctl.step(q, TWIST)
    other.restore("j5")
    assert other.faults == {}
    np.testing.assert_array_equal(one.step(q, -TWIST).rates, other.step(q, -TWIST).rates)


def test_the_record_of_faults_is_a_copy():
    ctl = sr.Controller(mixed())
    ctl.fail(0)
    ctl.faults.clear()
    assert ctl.faults == {"j1": sr.Locked()}
    assert not np.shares_memory(ctl.health, ctl.health)


@pytest.mark.parametrize("joint", ["j12", "", 11, -1, 1.0, True, None, np.nan, ["j1"]], ids=str)
def test_a_joint_that_is_none_is_refused_and_nothing_changes(joint):
    ctl = sr.Controller(mixed(11))
    ctl.fail("j2")
    for call in (ctl.fail, ctl.restore):
        with pytest.raises(sr.errors.UnknownJointError, match="j1"):
            call(joint)
    assert ctl.faults == {"j2": sr.Locked()}
    assert np.sum(ctl.health) == 1


@pytest.mark.parametrize("kind", ["locked", None, sr.Locked, 0.5], ids=str)
def test_a_kind_of_fault_that_is_none_is_refused_and_nothing_changes(kind):
    ctl = sr.Controller(mixed())
    refused(lambda: ctl.fail("j1", kind), "kind", "Locked", "Derated", "Runaway")
    assert ctl.faults == {}
    assert not np.any(ctl.health)


@pytest.mark.parametrize("value", [np.nan, np.inf, "fast", None])
def test_a_runaway_has_a_finite_rate_and_a_derating_a_fraction(value):
    refused(lambda: sr.Runaway(value), "rate")
    refused(lambda: sr.Derated(value), "fraction")


@pytest.mark.parametrize("fraction", [-0.1, 1.1])
def test_a_fraction_is_between_0_and_1(fraction):
    refused(lambda: sr.Derated(fraction), "fraction", "0", "1")


def test_reset_says_what_the_last_rates_were_and_keeps_the_faults():
    arm = mixed()
    ctl = sr.Controller(arm, acceleration_limits=2.0, period=0.1)
    ctl.fail("j4")
    rates = np.linspace(-1, 1, 8)
    ctl.reset(rates)
    np.testing.assert_array_equal(ctl.last_rates, rates)
    assert ctl.faults == {"j4": sr.Locked()}
    out = ctl.step(configuration(arm), np.zeros(6))
    keep = np.arange(8) != 3
    np.testing.assert_allclose(out.lower[keep], rates[keep] - 0.2, atol=1e-15)
    np.testing.assert_allclose(out.upper[keep], rates[keep] + 0.2, atol=1e-15)
    np.testing.assert_array_equal(ctl.last_rates, out.rates)
    ctl.reset()
    np.testing.assert_array_equal(ctl.last_rates, np.zeros(8))


@pytest.mark.parametrize("rates", [np.full(8, np.nan), np.ones(7), 1.0, "fast", [1.0] * 7 + [np.inf]], ids=str)
def test_reset_with_no_rates_is_refused_and_changes_nothing(rates):
    ctl = sr.Controller(mixed())
    ctl.reset(np.arange(8.0))
    refused(lambda: ctl.reset(rates), "rates")
    np.testing.assert_array_equal(ctl.last_rates, np.arange(8.0))


def test_a_follower_cannot_fail_alone_and_the_message_names_its_leader():
    follower = sr.Follower(sr.Joint(name="mimic"), leader="finger", place=1)
    arm = sr.Arm([sr.Joint(name="finger")], followers=[follower])
    for call in (
        lambda: sr.Controller(arm).fail("mimic"),
        lambda: sr.Controller(arm).restore("mimic"),
        lambda: sr.Scenario(
            arm=arm, start=[0.0], motion=sr.ConstantTwist(np.zeros(6), duration=1.0), faults=sr.Fault("mimic")
        ),
        lambda: arm.singular_values([0.0], joints=["mimic"]),
    ):
        with pytest.raises(sr.errors.UnknownJointError) as caught:
            call()
        assert caught.value.choices == ("finger",)
        assert "'mimic'" in caught.value.got


def test_a_controller_tells_its_law_period_and_faults():
    ctl = sr.Controller(sr.arms.planar(3), law=sr.KeepDirection(), period=0.002)
    start = f"<Controller of planar3: {sr.KeepDirection()}, 2 ms, "
    assert repr(ctl) == f"{start}no faults>"
    ctl.fail("j3", sr.Derated(0.2))
    ctl.fail("j1")
    assert repr(ctl) == f"{start}j1 Locked(), j3 Derated(fraction=0.2)>"
