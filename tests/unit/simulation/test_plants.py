"""What the arm does beside what the controller knows: faults known later, late drives, encoders that are off."""

import math
from dataclasses import replace

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError
from stillreach.plants import KinematicPlant
from stillreach.status import Health


def line(arm, start, **settings):
    """A steady twist for half a second, in open loop."""
    defaults = {"motion": sr.ConstantTwist([0.0, 0.02, 0.01, 0.0, 0.0, 0.0]), "duration": 0.5, "period": 0.002}
    return sr.Scenario(arm=arm, start=start, **{**defaults, **settings})


PANDA = sr.arms.panda()
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
J4 = "panda_joint4"


def test_the_tool_error_at_the_end_of_a_delay():
    """Open loop, locked joint: the error is what the joint would have moved the tool meanwhile, to 5 %."""
    rng = np.random.default_rng(7)
    arms = [PANDA, sr.arms.iiwa14(), sr.arms.nasa_modular()]
    for case in range(100):
        arm = arms[case % 3]
        lower, upper = np.clip(arm.position_limits, -2.5, 2.5).T
        start = rng.uniform(lower + 0.15 * (upper - lower), upper - 0.15 * (upper - lower))
        twist = rng.normal(size=6) * 0.002
        joint, delay, period = int(rng.integers(arm.n)), int(rng.integers(5, 21)), 0.002
        fault = sr.Fault(joint, at=0.1, known_after=delay * period)
        motion = sr.ConstantTwist(twist)
        run = sr.simulate(line(arm, start, motion=motion, faults=[fault], period=period, duration=0.2))
        first, end = 50, 50 + delay
        assert run.scenario.schedule.known.keys() == {end}
        column = arm.jacobian(run.q[first])[:, joint]
        moved = np.abs(run.rates[first:end, joint].sum()) * period
        expected = np.linalg.norm(column[:3]) * moved
        late = run.summary().unnoticed[0]
        assert (late.since, late.until) == (run.time[first], run.time[end])
        assert late.noticed
        off = run.pose[end, :3, 3] - run.target[end, :3, 3] - run.pose[first, :3, 3] + run.target[first, :3, 3]
        if expected < 1e-6:  # a joint that hardly moves the tool
            continue
        assert np.linalg.norm(off) == pytest.approx(expected, rel=0.05)
        assert late.distance == pytest.approx(expected, rel=0.05, abs=late.distance_before * 1.05)


def test_truth_and_knowledge_part_for_the_delay():
    run = sr.simulate(line(PANDA, START, faults=[sr.Fault(J4, at=0.1, until=0.3, known_after=0.04)]))
    truth, known = run.health[:, 3] == Health.LOCKED, run.known[:, 3] == Health.LOCKED
    assert np.array_equal(np.flatnonzero(truth), np.arange(50, 150))
    assert np.array_equal(np.flatnonzero(known), np.arange(70, 170))
    still = np.diff(run.q[:, 3]) == 0.0
    assert still[50:150].all()
    assert run.rates[50:70, 3].all()  # told to move
    assert not run.rates[70:170, 3].any()
    found = run.summary().unnoticed
    assert [late.what for late in found] == ["locked", None]
    assert "restored" in str(run.summary())


def test_a_fault_that_is_never_known():
    run = sr.simulate(line(PANDA, START, faults=[sr.Fault(J4, at=0.1, known_after=math.inf)]))
    assert not run.known.any()
    assert (run.health[50:, 3] == Health.LOCKED).all()
    late = run.summary().unnoticed[0]
    assert not late.noticed
    assert late.until == run.time[-1]
    assert "does not know its state" in run.summary().why.sentence


@pytest.mark.parametrize(
    ("kind", "true"),
    [
        (sr.Derated(0.01), lambda rate, limit, q: np.clip(rate, -0.01 * limit, 0.01 * limit)),
        (sr.Runaway(-0.2), lambda rate, limit, q: -0.2),
        (sr.OneWay(1.0), lambda rate, limit, q: max(rate, 0.0)),
        (sr.OneWay(-1.0), lambda rate, limit, q: min(rate, 0.0)),
        (sr.Confined(-2.18, -2.17), None),
    ],
)
def test_what_each_fault_does_before_it_is_known(kind, true):
    into_range = 0
    for sign in (1.0, -1.0):
        motion = sr.ConstantTwist(np.array([0.1, 0.05, 0.05, 0.0, 0.0, 0.0]) * sign)
        run = sr.simulate(line(PANDA, START, motion=motion, faults=[sr.Fault(J4, kind=kind, known_after=math.inf)]))
        moved = np.diff(run.q[:, 3]) / run.scenario.period
        if true is None:
            assert (run.q[:, 3] >= -2.1816616).all()  # where it was
            assert (run.q[1:, 3] <= -2.17 + 1e-12).all()
            into_range += bool(run.q[-1, 3] == pytest.approx(-2.17))
            continue
        for rate, told, q in zip(moved, run.rates[:-1, 3], run.q[:-1, 3], strict=True):
            assert rate == pytest.approx(true(told, PANDA.velocity_limits[3], q), abs=1e-9)
    assert into_range == (true is None)  # with one of the two signs, where it stops at the upper end


def test_without_delay_a_run_has_the_same_bits_as_ever():
    """By way of the plant and without it."""
    faults = [sr.Fault(J4, at=0.1), sr.Fault(1, at=0.2, kind=sr.Derated(0.3)), sr.Fault(6, kind=sr.OneWay(1.0))]
    plain = sr.simulate(line(PANDA, START, faults=faults, loop="closed"))
    by_plant = sr.simulate(
        line(PANDA, START, faults=[*faults, sr.Fault(0, at=0.49, until=0.495, known_after=0.004)], loop="closed")
    )
    for name in ("q", "rates", "pose", "status", "health"):
        assert np.array_equal(getattr(plain, name)[:245], getattr(by_plant, name)[:245])
    assert np.array_equal(plain.measured, plain.q)
    assert np.array_equal(plain.known, plain.health)


def test_late_drives_by_a_difference_equation():
    """First order and a dead time: the joint's rates are those of SciPy's filter, delayed by whole ticks."""
    from scipy.signal import lfilter

    plant = KinematicPlant(lag=0.03, dead_time=0.01)
    run = sr.simulate(line(PANDA, START, plant=plant))
    follow = 1.0 - math.exp(-0.002 / 0.03)
    told = np.vstack((np.zeros((5, 7)), run.rates[:-6]))
    expected = lfilter([follow], [1.0, follow - 1.0], told, axis=0)
    assert np.allclose(np.diff(run.q, axis=0) / 0.002, expected, atol=1e-9)


def test_encoders_that_are_off():
    plant = KinematicPlant(resolution=0.01, noise=0.003, seed=4)
    scenario = line(PANDA, START, plant=plant, loop="closed")
    run = sr.simulate(scenario)
    steps = run.measured / 0.01
    assert np.allclose(steps, np.round(steps), atol=1e-9)
    noise = np.random.default_rng(4).normal(0.0, 0.003, run.q.shape)
    assert np.array_equal(np.round((run.q + noise) / 0.01), np.round(steps))
    assert np.allclose(run.pose, PANDA.forward(run.q))  # the true pose, not the measured one
    assert np.array_equal(run.q, sr.simulate(scenario).q)
    other = sr.simulate(replace(scenario, plant=replace(plant, seed=5)))
    assert not np.array_equal(run.q, other.q)


def test_a_run_with_a_plant_is_saved_whole_and_replays(tmp_path):
    plant = KinematicPlant(lag=0.02, dead_time=0.004, resolution=1e-4, noise=1e-4, seed=3)
    faults = [sr.Fault(J4, at=0.1, known_after=0.04), sr.Fault(2, at=0.2, known_after=math.inf)]
    run = sr.simulate(line(PANDA, START, plant=plant, faults=faults))
    run.save(tmp_path / "run.npz")
    again = sr.Run.load(tmp_path / "run.npz")
    assert again.scenario.plant == plant
    assert again.scenario.faults == run.scenario.faults
    replayed = sr.simulate(again.scenario)
    for name, array in run.arrays().items():
        assert np.array_equal(array, getattr(again, name))
        assert np.array_equal(array, getattr(replayed, name))


def test_in_a_scenario_file(tmp_path):
    (tmp_path / "late.toml").write_text(
        """
        start = [20, -45, 20, -125, 20, 95, 45]
        [units]
        angle = "deg"
        [robot]
        arm = "panda"
        [[motion]]
        kind = "wait"
        duration = 1
        [[faults]]
        joint = "panda_joint4"
        kind = "locked"
        at = 0.5
        known_after = 0.04
        [plant]
        kind = "kinematic"
        lag = 0.02
        resolution = 0.1
        """
    )
    scenario = sr.Scenario.load(tmp_path / "late.toml")
    assert scenario.faults[0].known_after == 0.04
    assert scenario.plant == KinematicPlant(lag=0.02, resolution=np.deg2rad(0.1))


@pytest.mark.parametrize(
    ("make", "argument"),
    [
        (lambda: KinematicPlant(lag=-1.0), "lag"),
        (lambda: KinematicPlant(dead_time=math.inf), "dead_time"),
        (lambda: KinematicPlant(noise=math.nan), "noise"),
        (lambda: KinematicPlant(resolution="fine"), "resolution"),
        (lambda: KinematicPlant(seed=1.5), "seed"),
        (lambda: sr.Fault(J4, known_after=-0.1), "known_after"),
        (lambda: line(PANDA, START, plant="kinematic"), "plant"),
    ],
)
def test_invalid_arguments(make, argument):
    with pytest.raises(InputError) as caught:
        make()
    assert caught.value.argument == argument
