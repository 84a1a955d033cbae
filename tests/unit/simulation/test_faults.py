import numpy as np
import pytest

import stillreach as sr
from stillreach.simulation.account import fault_lines
from stillreach.status import Health
from tests.unit.simulation.scenarios import eight_joints, eight_joints_start, small_run, waving


def run_with(*faults, period=0.1, duration=2.0):
    return sr.simulate(
        sr.Scenario(
            arm=eight_joints().with_limits(velocity=2.0),
            start=eight_joints_start(),
            motion=waving,
            faults=faults,
            law=sr.SingularityRobust(),
            period=period,
            duration=duration,
        )
    )


@pytest.mark.parametrize(("at", "first"), [(0.0, 0), (0.7, 7), (0.1 + 0.2, 3), (0.71, 8), (0.7 + 5e-11, 7), (2.0, 20)])
def test_a_fault_begins_at_the_first_tick_that_is_not_before_it(at, first):
    run = run_with(sr.Fault("j3", at=at))
    assert np.all(run.rates[:first, 2] != 0.0)
    assert np.all(run.rates[first:, 2] == 0.0)
    assert np.array_equal(run.health[:, 2], np.arange(21) >= first)


def test_a_fault_after_the_end_never_happens():
    assert np.all(run_with(sr.Fault("j3", at=2.05)).health == Health.HEALTHY)


def test_a_locked_joint_stays_where_it_was_and_moves_again_when_restored():
    run = run_with(sr.Fault("j3", at=0.5, until=1.2))
    assert np.all(run.rates[5:12, 2] == 0.0)
    assert np.all(run.q[5:13, 2] == run.q[5, 2])
    assert run.rates[12, 2] != 0.0


def test_a_derated_joint_keeps_to_its_part_of_the_limit_and_a_runaway_to_its_rate():
    run = run_with(
        sr.Fault(1, at=0.4, kind=sr.Derated(0.02)), sr.Fault("j6", at=0.6, kind=sr.Runaway(-0.03), until=1.5)
    )
    assert np.max(np.abs(run.rates[4:, 1])) <= 0.04 < np.max(np.abs(run.rates[:4, 1]))
    assert np.all(run.upper[4:, 1] == 0.02 * 2.0)
    assert np.all(run.rates[6:15, 5] == -0.03)
    assert np.array_equal(run.health[:, 5] == Health.RUNAWAY, (np.arange(21) >= 6) & (np.arange(21) < 15))


def test_of_two_faults_on_a_joint_the_later_one_holds_and_then_the_earlier_one_again():
    run = run_with(sr.Fault("j3", at=0.2, kind=sr.Derated(0.5)), sr.Fault("j3", at=0.6, until=1.0))
    states = [Health.HEALTHY] * 2 + [Health.DERATED] * 4 + [Health.LOCKED] * 4 + [Health.DERATED] * 11
    assert run.health[:, 2].tolist() == states


def test_a_joint_that_one_fault_leaves_and_another_takes_at_the_same_tick_is_never_healthy_between():
    run = run_with(sr.Fault("j3", at=0.2, kind=sr.Derated(0.5), until=0.6), sr.Fault("j3", at=0.6))
    assert run.health[2:, 2].tolist() == [Health.DERATED] * 4 + [Health.LOCKED] * 15


def test_all_joints_failed_leaves_the_arm_standing():
    run = run_with(*(sr.Fault(joint, at=1.0) for joint in range(8)))
    assert np.all(run.rates[10:] == 0.0)
    assert np.all(run.q[10:] == run.q[10])
    assert np.all(sr.Status(int(run.status[-1])) & sr.Status.NO_WORKING_JOINT)


def test_the_rates_are_inside_the_recorded_bounds_at_every_tick():
    run = small_run()
    assert np.all(run.rates >= run.lower)
    assert np.all(run.rates <= run.upper)
    assert np.any(run.damping > 0)


def test_a_fault_of_no_joint_is_refused():
    with pytest.raises(sr.errors.UnknownJointError, match="j12"):
        run_with(sr.Fault("j12"))
    with pytest.raises(sr.InputError, match="faults"):
        run_with("j3")
    with pytest.raises(sr.InputError, match="faults: got 5"):
        small_run(faults=5)


def test_a_fault_that_another_of_its_joint_replaces_is_listed_until_then():
    weak = sr.Derated(0.5)
    first = sr.Fault("j1", at=0.5, until=1.5)
    faults = [
        first,
        sr.Fault("j1", at=1.0, kind=weak),
        sr.Fault("j2", at=1.0),
        sr.Fault("j2", at=1.0, kind=weak),
    ]
    motion = sr.ConstantTwist(np.zeros(6), duration=2.0)
    scenario = sr.Scenario(arm=sr.arms.planar(3), start=np.zeros(3), motion=motion, faults=faults)
    run = sr.simulate(scenario)
    assert run.health[-1].tolist() == [Health.DERATED, Health.DERATED, Health.HEALTHY]
    assert [line.partition(" from ")[::2] for line in fault_lines(scenario)] == [
        ("j1 locked", "0.5 s on, until 1 s"),
        ("j1, j2 derated to 50 %", "1 s on"),
    ]
