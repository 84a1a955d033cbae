import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import stillreach as sr
from stillreach._rotations import pitch_yaw_roll
from tests.refusals import refused
from tests.unit.simulation.scenarios import eight_joints, eight_joints_start, followed

UP, ALONG = (0, 0, 0.1, 0, 0, 0), (0.1, 0, 0, 0, 0.2, 0)


def commanded(motion, **settings):
    """Times and commands of a run."""
    scenario = sr.Scenario(
        arm=eight_joints(), start=eight_joints_start(), motion=motion, **{"period": 0.1, "duration": 1.0, **settings}
    )
    run = sr.simulate(scenario)
    return run.time, run.command


def test_a_twist_is_held_for_its_duration_and_the_next_one_begins_at_the_first_tick_not_before_its_end():
    time, command = commanded([sr.ConstantTwist(UP, 0.3), sr.ConstantTwist(ALONG, 0.25)])
    assert np.array_equal(command[time < 0.299], np.tile(UP, (3, 1)))
    assert np.array_equal(command[3:6], np.tile(ALONG, (3, 1)))
    assert np.array_equal(command[6:], np.zeros((5, 6)))


def test_an_end_that_rounding_puts_just_after_a_tick_is_at_that_tick():
    _, command = commanded([sr.ConstantTwist(UP, 0.1), sr.ConstantTwist(UP, 0.2), sr.ConstantTwist(ALONG)])
    assert 0.1 + 0.2 > 0.3
    assert np.array_equal(command[2:4], [UP, ALONG])


def test_a_function_of_time_is_asked_at_every_tick():
    time, command = commanded(lambda t: [t, t * t, 1.0, 0.0, -t, 0.0])
    assert np.array_equal(command, np.transpose([time, time**2, time**0, 0 * time, -time, 0 * time]))


def test_a_function_may_follow_held_twists_and_sees_the_time_since_the_start():
    time, command = commanded([sr.ConstantTwist(UP, 0.5), lambda t: [t, 0, 0, 0, 0, 0]])
    assert np.array_equal(command[:5], np.tile(UP, (5, 1)))
    assert np.array_equal(command[5:, 0], time[5:])


def test_a_scenario_without_a_duration_lasts_as_long_as_its_motion():
    time, _ = commanded([sr.ConstantTwist(UP, 0.3), sr.ConstantTwist(ALONG, 0.4)], duration=None)
    assert len(time) == 8
    with refused("duration"):
        commanded([sr.ConstantTwist(UP, 0.3), sr.ConstantTwist(ALONG)], duration=None)


@pytest.mark.parametrize("answer", [1.0, [1, 2, 3], [np.nan] * 6, "up", None])
def test_a_function_that_answers_with_no_twist_is_refused_with_its_time(answer):
    with pytest.raises(sr.InputError, match=r"motion\(0\.3"):
        commanded(lambda t: answer if t > 0.25 else UP)


def test_what_a_function_raises_comes_through_with_a_note_of_the_time():
    def broken(t):
        return [1 / (0.2 - round(t, 9)), 0, 0, 0, 0, 0]

    with pytest.raises(ZeroDivisionError) as caught:
        commanded(broken)
    assert "t = 0.2 s" in caught.value.__notes__[0]


@pytest.mark.parametrize(
    "motion",
    [
        "up",
        UP,
        [UP],
        3.0,
        [sr.ConstantTwist(UP), sr.ConstantTwist(ALONG, 1.0)],
        [lambda t: UP, sr.ConstantTwist(UP)],
        None,
    ],
)
def test_what_is_no_motion_is_refused(motion):
    with pytest.raises(sr.InputError, match="motion"):
        commanded(motion)


def test_a_held_twist_moves_the_point_on_a_line_and_turns_about_a_fixed_axis():
    rng = np.random.default_rng(5)
    twists = np.array([*rng.normal(size=(4, 6)), [0, 0, 0, 1e-9, 0, 0], [1, 0, 0, 0, 0, 0], [0, 0, 0, 0, np.pi, 0]])
    durations = np.array([0.1, 1.0, 2.0, 0.01, 1.0, 1.0, 1.0])
    motion = [sr.ConstantTwist(twist, duration) for twist, duration in zip(twists, durations, strict=True)]
    scenario = sr.Scenario(arm=eight_joints(), start=eight_joints_start(), motion=motion, period=0.01)
    start = eight_joints().forward(eight_joints_start())
    poses = scenario.schedule.poses(np.concatenate([[0.0], np.cumsum(durations)]) / 0.01)
    np.testing.assert_allclose(poses, followed(start, twists, durations), atol=1e-12)


def test_an_arm_without_faults_follows_the_commanded_line_and_turn():
    scenario = sr.Scenario(
        arm=sr.arms.nasa_modular(),
        start=np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 0, 0]),
        motion=sr.ConstantTwist([-0.1, -0.05, 0.04, 0.02, -0.05, 0.03]),
        law=sr.Pseudoinverse(),
        period=0.05,
        duration=4.0,
        integrator="rk4",
    )
    run = sr.simulate(scenario)
    np.testing.assert_allclose(run.pose, followed(run.pose[0], run.command[:-1], scenario.period), atol=1e-7)


@pytest.mark.parametrize("yaw", [0.0, 0.7, -1.5, np.pi / 2, -np.pi / 2])
def test_pitch_yaw_roll_are_the_angles_of_ry_rz_rx(yaw):
    rng = np.random.default_rng(8)
    for pitch, roll in rng.uniform(-np.pi, np.pi, (20, 2)):
        turn = Rotation.from_euler("YZX", [pitch, yaw, roll])
        angles = pitch_yaw_roll(turn.as_matrix())
        np.testing.assert_allclose(Rotation.from_euler("YZX", angles).as_matrix(), turn.as_matrix(), atol=1e-12)
        if abs(yaw) < 1.57:
            np.testing.assert_allclose(angles, [pitch, yaw, roll], atol=1e-12)
