"""Lines, circles, waypoints and tables of poses: where they lead and how fast, by hand and by SciPy."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation, Slerp

import stillreach as sr
from stillreach.simulation.commanded import commanded
from stillreach.simulation.profile import PROFILES, progress
from tests.refusals import refused
from tests.unit.simulation.scenarios import eight_joints, eight_joints_start


def scenario(motion, **settings):
    return sr.Scenario(
        arm=eight_joints(), start=eight_joints_start(), motion=motion, **{"period": 0.01, "loop": "closed", **settings}
    )


def path(motion, **settings):
    """Start of the tool, and where the motion leads it at each tick."""
    it = scenario(motion, **settings)
    return it.task_pose(it.start), commanded(it).poses


def sampled(course, T_start, times):
    return course.plan(T_start).at(np.asarray(times, dtype=float))


def some_pose(seed=5):
    T = np.eye(4)
    rng = np.random.default_rng(seed)
    T[:3, :3], T[:3, 3] = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)
    return T


COURSES = [
    sr.Line([0.3, -0.2, 0.5], orientation=[0.2, 1.0, -0.4], duration=2.0, profile="minimum-jerk"),
    sr.Line([0.3, -0.2, 0.5], duration=2.0, profile="trapezoidal", ramp=0.1, relative=True),
    sr.Circle(centre=[0, 0.2, 0.1], axis=[1, 2, -1], duration=2.0, angle=4.0, attitude="follow", relative=True),
    sr.Circle(centre=[0, 0.2, 0.1], axis=[0, 0, 1], duration=2.0, profile="minimum-jerk"),
    sr.Waypoints([[1, 0, 0], [1, 2, 0]], orientations=[[0, 0, 3.0], None], times=[0.5, 2.0], profile="minimum-jerk"),
    sr.PoseTable([0.4, 2.0], [[1, 0, 0], [0, 1, 0]], orientations=Rotation.random(2, rng=1).as_matrix()),
]


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("ramp", [0.01, 0.25, 0.5])
def test_a_profile_goes_all_the_way_and_its_speed_is_the_slope_of_its_way(profile, ramp):
    ends, _ = progress(profile, ramp, np.array([0.0, 0.5, 1.0]))
    np.testing.assert_allclose(ends, [0.0, 0.5, 1.0], atol=1e-15)
    for u in (0.004, 0.2, 0.25, 0.7, 0.995, 1.0):
        way = quad(lambda x: progress(profile, ramp, np.array([x]))[1][0], 0.0, u, points=[ramp, 1 - ramp], limit=200)
        assert way[0] == pytest.approx(progress(profile, ramp, np.array([u]))[0][0], abs=1e-7)


def test_a_trapezoid_has_the_speed_of_its_area_and_even_ramps():
    _, slope = progress("trapezoidal", 0.2, np.array([0.0, 0.1, 0.2, 0.5, 0.8, 0.9, 1.0]))
    np.testing.assert_allclose(slope, np.array([0, 0.5, 1, 1, 1, 0.5, 0]) * 1.25, atol=1e-15)


def test_minimum_jerk_starts_and_ends_without_speed_or_acceleration_and_peaks_at_15_eighths():
    _, slope = progress("minimum-jerk", 0.25, np.array([0.0, 1e-4, 0.5, 1 - 1e-4, 1.0]))
    assert slope[0] == slope[-1] == 0.0
    assert max(slope[1], slope[3]) < 1e-4 * 1e-2
    assert slope[2] == pytest.approx(15 / 8)


@pytest.mark.parametrize("course", COURSES, ids=lambda course: type(course).__name__)
def test_the_twist_of_a_course_is_the_derivative_of_its_pose(course):
    T, h = some_pose(), 1e-6
    times = np.array([0.11, 0.7, 1.3, 1.91])
    poses, twists = sampled(course, T, times)
    (early, _), (late, _) = sampled(course, T, times - h), sampled(course, T, times + h)
    np.testing.assert_allclose((late[:, :3, 3] - early[:, :3, 3]) / (2 * h), twists[:, :3], atol=1e-8)
    turns = Rotation.from_matrix(late[:, :3, :3]) * Rotation.from_matrix(early[:, :3, :3]).inv()
    np.testing.assert_allclose(turns.as_rotvec() / (2 * h), twists[:, 3:], atol=1e-8)
    assert np.max(np.abs(poses[:, :3, :3] @ np.swapaxes(poses[:, :3, :3], 1, 2) - np.eye(3))) < 1e-14


@pytest.mark.parametrize("course", COURSES, ids=lambda course: type(course).__name__)
def test_a_course_begins_where_the_tool_is_and_is_continuous(course):
    T = some_pose()
    poses, _ = sampled(course, T, np.linspace(0, course.duration, 20_001))
    np.testing.assert_allclose(poses[0], T, atol=1e-15)
    assert np.max(np.abs(np.diff(poses, axis=0))) < 1e-3


def test_a_line_is_straight_and_ends_at_its_point_with_its_attitude():
    T, turn = some_pose(), Rotation.from_rotvec([0.4, -1.0, 2.0])
    line = sr.Line([1.0, 2.0, 3.0], orientation=turn.as_matrix(), duration=4.0)
    poses, twists = sampled(line, T, [0.0, 1.0, 4.0])
    np.testing.assert_allclose(poses[1, :3, 3], T[:3, 3] + ([1, 2, 3] - T[:3, 3]) / 4, atol=1e-15)
    np.testing.assert_allclose(poses[2, :3, 3], [1, 2, 3], atol=1e-15)
    slerp = Slerp([0, 4], Rotation.concatenate([Rotation.from_matrix(T[:3, :3]), turn]))
    np.testing.assert_allclose(poses[:, :3, :3], slerp([0.0, 1.0, 4.0]).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(twists, np.tile(twists[0], (3, 1)), atol=1e-14)


def test_a_relative_line_shifts_and_turns_along_base_axes():
    T, turn = some_pose(), Rotation.from_rotvec([0.0, 0.0, 0.5])
    line = sr.Line([0.1, 0, 0], orientation=[0, 0, 0.5], duration=1.0, relative=True)
    end = sampled(line, T, [1.0])[0][0]
    np.testing.assert_allclose(end[:3, 3], T[:3, 3] + [0.1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(end[:3, :3], turn.as_matrix() @ T[:3, :3], atol=1e-15)


def test_a_quarter_circle_by_hand():
    T = np.eye(4)
    T[:3, 3] = (2.0, 0.0, 5.0)
    circle = sr.Circle(centre=[0, 0, 0], axis=[0, 0, 3], angle=np.pi / 2, duration=2.0, attitude="follow")
    poses, twists = sampled(circle, T, [0.0, 1.0, 2.0])
    half = np.sqrt(0.5)
    np.testing.assert_allclose(poses[:, :3, 3], [[2, 0, 5], [2 * half, 2 * half, 5], [0, 2, 5]], atol=1e-14)
    np.testing.assert_allclose(poses[2, :3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-14)
    np.testing.assert_allclose(twists[0], [0, np.pi / 2, 0, 0, 0, np.pi / 4], atol=1e-14)
    kept = sampled(sr.Circle(centre=[0, 0, 0], axis=[0, 0, 3], angle=-np.pi / 2, duration=2.0), T, [2.0])
    np.testing.assert_allclose(kept[0][0, :3, 3], [0, -2, 5], atol=1e-14)
    np.testing.assert_array_equal(kept[0][0, :3, :3], np.eye(3))
    np.testing.assert_array_equal(kept[1][0, 3:], 0.0)


def test_a_circle_around_a_point_off_its_plane_keeps_its_height():
    T = some_pose()
    poses, _ = sampled(sr.Circle(centre=[1, 2, 3], axis=[0, 1, 0], duration=1.0), T, np.linspace(0, 1, 9))
    radius = np.hypot(poses[:, 0, 3] - 1, poses[:, 2, 3] - 3)
    np.testing.assert_allclose(radius, radius[0], rtol=1e-14)
    np.testing.assert_allclose(poses[:, 1, 3], T[1, 3], atol=1e-14)
    np.testing.assert_allclose(poses[-1], T, atol=1e-14)


def test_waypoints_share_their_time_by_the_length_of_the_legs():
    points = np.array([[3.0, 0, 0], [3, 1, 0], [3, 1, 4]])
    course = sr.Waypoints(points, duration=16.0)
    poses, twists = sampled(course, np.eye(4), [0, 3, 6, 7, 8, 12, 16.0])
    expected = [[0, 0, 0], [1.5, 0, 0], [3, 0, 0], [3, 0.5, 0], [3, 1, 0], [3, 1, 2], [3, 1, 4]]
    np.testing.assert_allclose(poses[:, :3, 3], expected, atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(twists, axis=1), 0.5, atol=1e-8)


def test_waypoints_are_reached_at_their_times_with_their_attitudes():
    turns = Rotation.random(3, rng=2)
    course = sr.Waypoints(
        np.eye(3), orientations=[turns[0].as_matrix(), None, turns[2].as_rotvec()], times=[1.0, 1.5, 4.0]
    )
    poses, _ = sampled(course, some_pose(), [1.0, 1.5, 4.0])
    np.testing.assert_allclose(poses[:, :3, 3], np.eye(3), atol=1e-14)
    wanted = Rotation.concatenate([turns[0], turns[0], turns[2]]).as_matrix()
    np.testing.assert_allclose(poses[:, :3, :3], wanted, atol=1e-14)


def test_points_where_nothing_is_to_be_done_take_no_time_and_do_no_harm():
    poses, twists = sampled(sr.Waypoints([[0, 0, 0], [1, 0, 0], [1, 0, 0]], duration=2.0), np.eye(4), [0.0, 1.0, 2.0])
    np.testing.assert_allclose(poses[:, 0, 3], [0, 0.5, 1.0], atol=1e-8)
    assert np.all(np.isfinite(twists))
    still, none = sampled(sr.Waypoints([[0, 0, 0]], duration=2.0), np.eye(4), [0.0, 2.0])
    np.testing.assert_array_equal(still, [np.eye(4)] * 2)
    np.testing.assert_array_equal(none, np.zeros((2, 6)))


def test_a_table_must_begin_where_the_tool_is_or_have_time_to_get_there():
    T = some_pose()
    table = sr.PoseTable([0.0, 1.0], [[9, 9, 9], [9, 9, 8]])
    with refused("times", "0 rad"):
        table.plan(T)
    with pytest.raises(sr.InputError, match=r"motion\[1\]\.times"):
        scenario([sr.ConstantTwist(np.zeros(6), 1.0), table])
    reached, _ = sampled(sr.PoseTable([1.0, 2.0], [[9, 9, 9], [9, 9, 8]]), T, [0.0, 0.5, 1.0, 2.0])
    np.testing.assert_allclose(reached[:, :3, 3], [T[:3, 3], (T[:3, 3] + 9) / 2, [9, 9, 9], [9, 9, 8]], atol=1e-14)
    shifted, _ = sampled(sr.PoseTable([0.0, 1.0], [[0, 0, 0], [0, 0, 8]], relative=True), T, [1.0])
    np.testing.assert_allclose(shifted[0, :3, 3], T[:3, 3] + [0, 0, 8], atol=1e-14)


def test_parts_of_a_motion_follow_each_other_from_where_the_last_one_led():
    start, poses = path(
        [
            sr.ConstantTwist([0.1, 0, 0, 0, 0, 0.5], 0.5),
            sr.Line([0, 0.05, 0], relative=True, duration=0.4),
            sr.Line(start_point := [0.5, 0.4, 0.3], duration=0.6, profile="minimum-jerk"),
            sr.Line([0.0, 0.0, 0.1], relative=True, duration=0.5),
        ]
    )
    np.testing.assert_allclose(poses[50, :3, 3], start[:3, 3] + [0.05, 0, 0], atol=1e-14)
    np.testing.assert_allclose(poses[90, :3, 3], start[:3, 3] + [0.05, 0.05, 0], atol=1e-14)
    np.testing.assert_allclose(poses[150, :3, 3], start_point, atol=1e-14)
    np.testing.assert_allclose(poses[-1, :3, 3], np.add(start_point, [0, 0, 0.1]), atol=1e-14)
    turned = Rotation.from_rotvec([0, 0, 0.25]).as_matrix() @ start[:3, :3]
    np.testing.assert_allclose(poses[-1, :3, :3], turned, atol=1e-14)


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_a_course_ends_at_its_end_though_its_duration_is_no_whole_number_of_ticks(integrator):
    motion = [
        sr.Line([0.05, 0, 0], relative=True, duration=0.333),
        sr.Line([0, 0.05, 0], relative=True, duration=0.111),
    ]
    it = scenario(motion, integrator=integrator, track_gain=20.0, duration=2.0)
    run = sr.simulate(it)
    np.testing.assert_allclose(run.pose[-1, :3, 3] - run.pose[0, :3, 3], [0.05, 0.05, 0], atol=1e-9)


def test_a_course_shorter_than_a_tick_is_refused():
    with refused("motion[0].duration", "0.004 s"):
        scenario([sr.Line([0.1, 0, 0], relative=True, duration=0.004)], duration=1.0)


def test_in_an_open_loop_the_commanded_twists_lead_exactly_along_the_course():
    """Each held twist leads from one pose of the circle to the next: nothing is lost at the corners of the polygon."""
    course = sr.Circle(centre=[0, 0, 0.1], axis=[1, 0, 0], relative=True, duration=1.0, attitude="follow")
    run = sr.simulate(scenario([course], loop="open"))
    T = run.pose[0].copy()
    for k, twist in enumerate(run.command[:-1]):
        wanted = course.plan(run.pose[0]).at(np.array([0.01 * k]))[0][0]
        np.testing.assert_allclose(T, wanted, atol=1e-13)
        T[:3, 3] += twist[:3] * 0.01
        T[:3, :3] = Rotation.from_rotvec(twist[3:] * 0.01).as_matrix() @ T[:3, :3]


def test_runge_kutta_in_an_open_loop_follows_a_smooth_course_to_fourth_order():
    course = sr.Circle(centre=[0, 0, 0.1], axis=[1, 0.5, 0], angle=2.0, relative=True, duration=1.0)
    goal = None
    ends = []
    for period in (0.1, 0.05):
        run = sr.simulate(scenario([course], period=period, integrator="rk4", loop="open", velocity_limits=np.inf))
        goal = course.plan(run.pose[0]).at(np.array([1.0]))[0][0]
        ends.append(np.linalg.norm(run.pose[-1] - goal))
    assert ends[1] < ends[0] / 10
    assert ends[1] < 1e-5


def test_a_closed_loop_comes_back_from_a_runaway_and_an_open_one_does_not():
    motion = [sr.Line([0.05, 0.05, 0], relative=True, duration=1.0, profile="trapezoidal")]
    fault = sr.Fault("j1", at=0.3, kind=sr.Runaway(2.0), until=0.4)
    arm = eight_joints().with_limits(velocity=0.5)
    settings = {"arm": arm, "start": eight_joints_start(), "motion": motion, "faults": [fault], "duration": 4.0}
    runs = [sr.simulate(sr.Scenario(**settings, loop=loop, track_gain=4.0)) for loop in ("closed", "open")]
    off = [np.linalg.norm(run.pose[-1, :3, 3] - run.pose[0, :3, 3] - [0.05, 0.05, 0]) for run in runs]
    assert off[0] < 1e-4 < 5e-3 < off[1]


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: sr.Line([1, 2], duration=1.0), "to"),
        (lambda: sr.Line([1, 2, 3], duration=0.0), "duration"),
        (lambda: sr.Line([1, 2, 3], duration=1.0, profile="jerky"), "profile.*minimum-jerk"),
        (lambda: sr.Line([1, 2, 3], duration=1.0, profile="trapezoidal", ramp=0.6), "ramp: got 0.6"),
        (lambda: sr.Line([1, 2, 3], duration=1.0, orientation=np.ones((3, 3))), "orientation"),
        (lambda: sr.Line([1, 2, 3], duration=1.0, relative=1), "relative"),
        (lambda: sr.Circle(centre=[0, 0, 0], axis=[0, 0, 0], duration=1.0), "axis"),
        (lambda: sr.Circle(centre=[0, 0, np.nan], axis=[0, 0, 1], duration=1.0), "centre"),
        (lambda: sr.Circle(centre=[0, 0, 0], axis=[0, 0, 1], duration=1.0, attitude="turn"), "attitude"),
        (lambda: sr.Waypoints([[0, 0, 0]]), "times: got neither"),
        (lambda: sr.Waypoints([[0, 0, 0]], times=[1.0], duration=1.0), "times: got both"),
        (lambda: sr.Waypoints(np.zeros((0, 3)), duration=1.0), "points"),
        (lambda: sr.Waypoints([[0, 0, 0], [1, 0, 0]], times=[1.0, 1.0]), "times: got 1 at index 1"),
        (lambda: sr.Waypoints([[0, 0, 0]], times=[0.0]), "times"),
        (lambda: sr.Waypoints([[0, 0, 0]], orientations=[None, None], duration=1.0), "orientations"),
        (lambda: sr.PoseTable([1.0], [[0, 0, 0]], orientations=np.ones((1, 3, 3))), r"orientations\[0\]"),
        (lambda: scenario([sr.Line([1, 2, 3], duration=1.0)], loop="round"), "loop.*'open', 'closed'"),
        (lambda: scenario([sr.Line([1, 2, 3], duration=1.0)], track_gain=-1.0), "track_gain"),
        (lambda: scenario([sr.ConstantTwist(np.zeros(6))], duration=1e9, period=1e-9), "duration.*at most"),
        (lambda: scenario([sr.ConstantTwist(np.zeros(6))], duration=1e300, period=1e-300), "duration.*at most"),
    ],
)
def test_what_is_no_course_is_refused_with_its_argument(make, match):
    with pytest.raises(sr.InputError, match=match):
        make()


def test_a_circle_through_its_own_axis_is_refused_where_it_is_planned():
    with refused("motion[0].centre"):
        scenario([sr.Circle(centre=[0, 0, 1], axis=[0, 0, 2], relative=True, duration=1.0)])
