"""A run in a few numbers, on arms whose runs are known by hand."""

import numpy as np
import pytest
from scipy.optimize import linprog

import stillreach as sr
from stillreach.simulation.commanded import commanded, deviation
from stillreach.simulation.held import held_back, rate_shares
from tests.unit.simulation.scenarios import first_ticks, followed

SLIDE = sr.Task(rows=(True, False, False, False, False, False))


def rail(**limits) -> sr.Arm:
    """One slide along x."""
    return sr.Arm([sr.Joint(kind="prismatic", axis=(1, 0, 0), **limits)])


def along(speed: float, **settings) -> sr.Scenario:
    """The rail told to go along x for 1 s, in 100 ticks."""
    start, arm = settings.pop("start", [0.0]), settings.pop("arm")
    motion = sr.ConstantTwist([speed, 0, 0, 0, 0, 0], duration=1.0)
    return sr.Scenario(arm=arm, start=start, motion=motion, task=SLIDE, period=0.01, **settings)


def found(scenario: sr.Scenario, **allowed):
    return sr.simulate(scenario).summary(**allowed)


def test_a_rail_that_is_asked_for_twice_its_rate_gets_half_way():
    scenario = along(2.0, arm=rail(velocity_limit=1.0))
    told = found(scenario)
    assert not told.finished
    assert told.way == pytest.approx(2.0)
    assert told.goal_distance == pytest.approx(1.0)
    assert told.distance.value == pytest.approx(1.0)
    assert told.distance.time == 1.0
    assert (told.linear, told.angular) == (True, False)
    assert told.rate.value == 1.0
    assert told.rate_joint == "j1"
    assert told.longest == ("j1", "rate", pytest.approx(1.0))


def test_a_rail_at_its_end_is_held_by_its_position_limit():
    scenario = along(0.5, arm=rail(velocity_limit=1.0, position_limits=(-1.0, 0.25)))
    told = found(scenario)
    assert told.held["j1"].keys() == {"position"}
    assert told.held["j1"]["position"] == pytest.approx(0.5, abs=0.03)
    assert told.goal_distance == pytest.approx(0.25)


def test_a_rail_that_must_speed_up_is_held_by_its_acceleration_limit():
    scenario = along(0.5, arm=rail(velocity_limit=1.0, acceleration_limit=1.0), law=sr.LeastError(price=None))
    told = found(scenario)
    assert told.held["j1"].keys() == {"acceleration"}
    assert told.held["j1"]["acceleration"] == pytest.approx(0.5, abs=0.02)  # 0.5 m/s at 1 m/s²


def test_a_derated_rail_is_held_by_its_rate_and_a_locked_one_by_nothing():
    derated = along(0.5, arm=rail(velocity_limit=1.0), faults=[sr.Fault("j1", at=0.5, kind=sr.Derated(0.1))])
    told = found(derated)
    assert told.held == {"j1": {"rate": pytest.approx(0.5)}}
    assert told.rate.value == pytest.approx(1.0)  # of the limit that is left
    assert told.rate_value == pytest.approx(0.1)
    assert told.goal_distance == pytest.approx(0.5 * (0.5 - 0.1))
    locked = along(0.5, arm=rail(velocity_limit=1.0), faults=[sr.Fault("j1", at=0.5)])
    told = found(locked)
    assert told.held == {}
    assert told.longest is None
    assert told.goal_distance == pytest.approx(0.25)
    assert told.lost.shape == (1, 1)
    assert told.statuses["NO_WORKING_JOINT"] == pytest.approx(0.5, abs=0.02)


def test_a_joint_without_limits_has_no_share_of_one():
    scenario = along(0.5, arm=rail())
    told = found(scenario)
    assert told.rate is None
    assert told.rate_value == pytest.approx(0.5)
    assert np.all(rate_shares(sr.simulate(scenario)) == 0.0)
    assert held_back(sr.simulate(scenario)) == {}


def test_limits_of_one_side_are_measured_on_that_side():
    scenario = along(-0.5, arm=rail(), velocity_limits=[(-0.5, 10.0)])
    assert found(scenario).rate.value == pytest.approx(1.0)


def test_arrived_is_what_the_user_says_it_is():
    scenario = along(2.0, arm=rail(velocity_limit=1.0))
    assert found(scenario, allowed_distance=1.01).finished
    assert not found(scenario, allowed_distance=0.99).finished


def test_lost_directions_are_those_of_the_faults_that_last():
    faults = [sr.Fault("j1", until=0.5), sr.Fault("j2")]
    task = sr.Task(rows=(True, True, False, False, False, False))
    twist = sr.ConstantTwist([0.01, 0, 0, 0, 0, 0], duration=1.0)
    scenario = sr.Scenario(arm=sr.arms.planar(2), start=[0.3, 0.9], motion=twist, task=task, faults=faults)
    run = sr.simulate(scenario)
    told = run.summary()
    column = scenario.arm.jacobian(run.q[-1])[:2, 0]
    assert told.lost.shape == (1, 2)
    assert abs(told.lost[0] @ column) == pytest.approx(0.0, abs=1e-12)
    assert told.singular_values == pytest.approx([np.linalg.norm(column)])


@pytest.mark.parametrize("looks", [7, 50, 10**6])
def test_the_commanded_path_is_the_same_however_often_it_is_looked_at(looks):
    parts = [[0.1, 0, 0, 0, 0.3, 0], [0, 0.2, 0, 1.0, 0, 0.5]]
    motion = [sr.ConstantTwist(parts[0], duration=0.5), sr.ConstantTwist(parts[1], duration=0.7)]
    arm = sr.arms.canadarm2()
    scenario = sr.Scenario(arm=arm, start=np.full(7, 0.3), motion=motion, period=0.01, duration=1.5)
    path = commanded(scenario, looks)
    held = [parts[0]] * 50 + [parts[1]] * 70 + [[0] * 6] * 30
    literal = followed(arm.forward(np.full(7, 0.3)), held, 0.01)
    assert (path.ticks[0], path.ticks[-1]) == (0, 150)
    assert np.all(np.diff(path.ticks) > 0)
    np.testing.assert_allclose(path.poses, literal[path.ticks], atol=1e-12)


def test_a_closed_loop_is_told_of_the_same_path():
    line = [
        sr.Line(to=[0.2, 0, 0.1], relative=True, duration=0.6),
        sr.ConstantTwist([0, 0, 0.1, 0, 0, 0], duration=0.4),
    ]
    scenario = sr.Scenario(
        arm=sr.arms.nasa_modular(), start=np.full(11, 0.2), motion=line, period=0.001, loop="closed", track_gain=5.0
    )
    run = sr.simulate(scenario)
    distance, angle = deviation(run)
    assert np.max(distance) < 1e-4  # an arm that can do all that it is told leaves it by an Euler step's error only
    assert np.max(angle) < 1e-4


def test_rows_along_the_tool_are_measured_along_the_tool():
    """The tool turns by a quarter about z; only its own x counts, which then points along the base's y."""
    arm = sr.Arm([sr.Joint(), sr.Joint(kind="prismatic", axis=(1, 0, 0)), sr.Joint(kind="prismatic", axis=(0, 1, 0))])
    task = sr.Task(rows=(True, False, False, False, False, False), frame="tool")
    motion = sr.ConstantTwist([0.3, 0.1, 0, 0, 0, 0], duration=1.0)
    faults = [sr.Fault(joint) for joint in range(3)]
    scenario = sr.Scenario(arm=arm, start=[np.pi / 2, 1.0, 0.0], motion=motion, task=task, faults=faults)
    run = sr.simulate(scenario)
    distance, angle = deviation(run)
    np.testing.assert_allclose(distance, 0.1 * run.time, atol=1e-12)
    assert np.all(angle == 0.0)


def test_an_interrupted_run_has_not_arrived():
    scenario = along(0.5, arm=rail(velocity_limit=1.0))
    run = sr.simulate(scenario)
    part = first_ticks(run, 40)
    told = part.summary()
    assert str(told).splitlines()[1].split(None, 1) == ["arrived", "interrupted at 0.39 s"]
    assert not told.finished
    assert told.end == pytest.approx(0.39)
    assert told.goal_distance == pytest.approx(0.0, abs=1e-12)


def test_a_tool_that_is_late_is_on_its_path():
    assert found(along(2.0, arm=rail(velocity_limit=1.0))).beside < 1e-12
    stuck = along(2.0, arm=rail(velocity_limit=1.0), faults=[sr.Fault("j1")])
    assert (found(stuck).distance.value, found(stuck).beside) == (pytest.approx(2.0), pytest.approx(0.0, abs=1e-12))


@pytest.mark.parametrize("frame", ["base", "tool"])
def test_how_far_beside_its_path_a_tool_is(frame):
    """A link of 2 m that runs away from x to y, told to stay or to come in along x by 1 m: known by trigonometry."""
    angle = 0.5
    arm = sr.Arm([sr.Joint(axis=(0, 0, 1))], tool=[[1, 0, 0, 2], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    for speed, expected in ((0.0, 2 * 2.0 * np.sin(angle / 2)), (-1.0, 2.0 * np.sin(angle))):
        scenario = sr.Scenario(
            arm=arm,
            start=[0.0],
            motion=sr.ConstantTwist([speed, 0, 0, 0, 0, 0], duration=1.0),
            task=sr.Task(rows="position", frame=frame),
            faults=[sr.Fault("j1", kind=sr.Runaway(angle))],
            integrator="rk4",
        )
        assert found(scenario).beside == pytest.approx(expected, rel=1e-9)


def test_rows_that_are_no_task_count_for_nothing_beside_the_path():
    rows = (True, False, False, False, False, False)
    arm = sr.arms.planar(1)
    away = sr.Scenario(
        arm=arm,
        start=[0.0],
        motion=sr.ConstantTwist(np.zeros(6), duration=1.0),
        task=sr.Task(rows=rows),
        faults=[sr.Fault("j1", kind=sr.Runaway(0.5))],
        integrator="rk4",
    )
    assert found(away).beside == pytest.approx(1.0 - np.cos(0.5), rel=1e-9)


def test_a_run_of_one_tick_has_a_summary():
    scenario = sr.Scenario(
        arm=rail(), start=[0.0], motion=sr.ConstantTwist([1.0, 0, 0, 0, 0, 0]), duration=0.001, task=SLIDE
    )
    assert len(sr.simulate(scenario)) == 1
    assert (found(scenario).beside, found(scenario).way) == (0.0, 0.0)


def test_a_fault_that_never_bites_is_not_what_limited_a_joint():
    """A derated joint that its position limit stops: the reason was guessed from the fault."""
    arm = rail(velocity_limit=1.0, position_limits=(-1.0, 0.25))
    scenario = along(0.4, arm=arm, faults=[sr.Fault("j1", kind=sr.Derated(0.5))])
    assert found(scenario).held.keys() == {"j1"}
    assert found(scenario).held["j1"].keys() == {"position"}


def test_a_joint_without_any_rate_is_limited_by_its_rate_limit():
    told = found(along(0.4, arm=rail(velocity_limit=0.0)))
    assert told.held == {"j1": {"rate": pytest.approx(1.01)}}
    assert set(told.statuses) >= {"SATURATED"}
    assert not {"OK", "NO_WORKING_JOINT"} & set(told.statuses)


def test_lost_directions_are_judged_by_gain():
    """Two links whose elbow is bent by a rounding error: the rank is whole, and nothing moves along the arm."""
    for bend, rate, lost in ((4e-6, 1.0, True), (4e-6, 1e4, False), (0.01, 1.0, False), (0.01, 0.01, True)):
        scenario = sr.Scenario(
            arm=sr.arms.planar(2).with_limits(velocity=rate),
            start=[0.0, bend],
            motion=sr.ConstantTwist(np.zeros(6), duration=0.1),
            task=sr.Task(rows=(True, True, False, False, False, False)),
        )
        run = sr.simulate(scenario)
        told = run.summary()
        assert len(told.singular_values) == 2
        assert np.min(told.singular_values) > 0.0
        assert len(told.lost) == lost
        J = scenario.arm.jacobian(run.q[-1])[:2]
        for direction in told.lost:
            most = linprog(-(direction @ J), bounds=[(-rate, rate)] * 2)
            assert -most.fun < 1e-3
            assert abs(direction[0]) == pytest.approx(1.0, abs=1e-2)


def test_acceleration_limits_of_one_tick_lose_no_direction():
    arm = sr.arms.planar(2).with_limits(velocity=1.0, acceleration=0.01)
    task = sr.Task(rows=(True, True, False, False, False, False))
    motion = sr.ConstantTwist(np.zeros(6), duration=0.01)
    scenario = sr.Scenario(arm=arm, start=[0.3, 0.9], motion=motion, task=task, period=0.001)
    assert len(found(scenario).lost) == 0
