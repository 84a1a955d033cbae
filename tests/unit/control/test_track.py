"""track(): from the error of the pose to a twist; geodesic in orientation, bounded, right through a half turn."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import stillreach as sr
from tests.unit.arm.odd_arms import placement
from tests.unit.control.robots import Q_PAPER, TWIST, configuration, mixed, paper, refused, skew

ANGLES = [
    0.0,
    1e-12,
    1e-9,
    1e-7,
    1e-3,
    0.0316,
    0.0317,
    1.0,
    2.0,
    np.pi - 1e-3,
    np.pi - 1e-7,
    np.pi - 1e-9,
    np.pi,
    np.pi + 1e-9,
    np.pi + 1e-6,
]
AXES = [*np.eye(3), *-np.eye(3), (1, 1, 0), (0, 1, -1), (1, 1, 1), (-3, 2, 0.1), (1e-9, 1, 0)]


def correction(arm, q, target, **settings):
    """The twist that is asked for, read from the answer."""
    return np.array(sr.Controller(arm, **{"track_limits": np.inf, **settings}).track(q, target).twist)


def rotation(R):
    """SciPy's rotation of a matrix, which must be its own to write to."""
    return Rotation.from_matrix(np.array(R))


def turned(T, turn, shift=(0, 0, 0)):
    """A pose turned about its own point by a rotation along base axes, and shifted."""
    out = np.array(T)
    out[:3, :3] = turn.as_matrix() @ T[:3, :3]
    out[:3, 3] += shift
    return out


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("axis", AXES, ids=str)
def test_the_correction_is_the_rotation_vector(angle, axis):
    arm, q = paper(), Q_PAPER
    axis = np.array(axis) / np.linalg.norm(axis)
    T = arm.forward(q)
    target = turned(T, Rotation.from_rotvec(angle * axis))
    w = correction(arm, q, target, track_gain=1.0)[3:]
    expected = rotation(target[:3, :3] @ T[:3, :3].T).as_rotvec()
    if angle < 3.0:
        np.testing.assert_allclose(w, angle * axis, atol=1e-14 + 1e-13 * angle)
    if abs(angle - np.pi) > 1e-6:
        np.testing.assert_allclose(w, expected, atol=1e-8)
    assert np.linalg.norm(w) <= np.pi + 1e-12
    ends = Rotation.from_rotvec(w) * rotation(T[:3, :3])
    np.testing.assert_allclose(ends.as_matrix(), target[:3, :3], atol=2e-8 if angle > 3.0 else 1e-14)


def test_random_rotations_are_reached_by_the_shortest_turn():
    arm = mixed()
    ctl = sr.Controller(arm, track_gain=1.0, track_limits=np.inf)
    rng = np.random.default_rng(41)
    for turn in Rotation.random(500, rng=rng):
        q = rng.uniform(-3, 3, arm.n)
        T = arm.forward(q)
        w = ctl.track(q, turned(T, turn)).twist[3:]
        np.testing.assert_allclose(w, turn.as_rotvec(), atol=1e-9)


@pytest.mark.parametrize("axis", AXES, ids=str)
def test_the_error_does_not_jump_in_size_at_half_a_turn(axis):
    arm, q = paper(), Q_PAPER
    T, axis = arm.forward(q), np.array(axis) / np.linalg.norm(axis)
    for angle in np.pi + np.array([-1e-5, -1e-8, -1e-12, 0, 1e-12, 1e-8, 1e-5]):
        w = correction(arm, q, turned(T, Rotation.from_rotvec(angle * axis)), track_gain=1.0)[3:]
        assert np.linalg.norm(w) == pytest.approx(np.pi - abs(angle - np.pi), abs=1e-8)
        np.testing.assert_allclose(np.abs(w @ axis), np.linalg.norm(w), atol=1e-7)


def test_the_gain_multiplies_the_error_and_the_feedforward_is_added():
    arm, q = paper(), Q_PAPER
    target = turned(arm.forward(q), Rotation.from_rotvec([0.1, -0.2, 0.05]), (0.01, 0.02, -0.03))
    error = np.array([0.01, 0.02, -0.03, 0.1, -0.2, 0.05])
    ctl = sr.Controller(arm, track_gain=3.5)
    np.testing.assert_allclose(ctl.track(q, target).twist, 3.5 * error, atol=1e-12)
    np.testing.assert_allclose(ctl.track(q, target, feedforward=TWIST).twist, 3.5 * error + TWIST, atol=1e-12)
    still = sr.Controller(arm, track_gain=0.0).track(q, target, feedforward=TWIST)
    np.testing.assert_allclose(still.twist, TWIST, atol=1e-15)


@pytest.mark.parametrize("limits", [(0.02, 0.1), (np.inf, 0.1), (0.02, np.inf), (0.0, 0.0)])
def test_the_correction_is_bounded_along_its_direction_and_the_feedforward_is_not(limits):
    arm, q = paper(), Q_PAPER
    shift, turn = np.array([0.5, -1.0, 0.2]), np.array([0.4, 1.2, -0.3])
    target = turned(arm.forward(q), Rotation.from_rotvec(turn), shift)
    twist = sr.Controller(arm, track_gain=2.0, track_limits=limits).track(q, target, feedforward=TWIST).twist - TWIST
    for part, error, limit in ((twist[:3], shift, limits[0]), (twist[3:], turn, limits[1])):
        wanted = 2.0 * error
        length = np.linalg.norm(wanted)
        np.testing.assert_allclose(part, wanted * min(1.0, limit / length), atol=1e-12)


def test_a_correction_within_its_bounds_is_left_alone():
    arm, q = paper(), Q_PAPER
    target = turned(arm.forward(q), Rotation.from_rotvec([0.01, 0, 0]), (0.01, 0, 0))
    a, b = (correction(arm, q, target, track_limits=limits) for limits in (np.inf, (1.0, 1.0)))
    np.testing.assert_array_equal(a, b)


def closed_loop(arm, q, target, steps, **settings):
    """Where the tool is after some ticks, and the answers of the last."""
    ctl = sr.Controller(arm, period=0.02, **settings)
    for _ in range(steps):
        out = ctl.track(q, target)
        q = q + 0.02 * out.rates
    return q, out


def pose_error(T, target):
    return np.linalg.norm(T[:3, 3] - target[:3, 3]), rotation(target[:3, :3] @ T[:3, :3].T).magnitude()


@pytest.mark.parametrize("failed", [(), ("j3",), ("j2", "j9")])
@pytest.mark.parametrize("law", [sr.LeastError(), sr.KeepDirection(), sr.SingularityRobust()], ids=repr)
def test_the_tool_arrives(law, failed):
    arm = paper()
    start, end = Q_PAPER, Q_PAPER + 0.15 * np.sin(np.arange(11))
    target = arm.forward(np.where(np.isin(arm.joint_names, failed), start, end))
    ctl = sr.Controller(arm, law=law, period=0.02)
    for joint in failed:
        ctl.fail(joint)
    q = start
    for _ in range(500):
        q = q + 0.02 * ctl.track(q, target).rates
    np.testing.assert_allclose(pose_error(arm.forward(q), target), 0.0, atol=1e-6)
    np.testing.assert_array_equal(q[np.isin(arm.joint_names, failed)], start[np.isin(arm.joint_names, failed)])


@pytest.mark.parametrize("angle", [2.8, np.pi - 1e-6, np.pi])
def test_it_arrives_from_half_a_turn_away(angle):
    """A wrist of three crossed axes on a gantry turns any way."""
    joints = [sr.Joint(kind="prismatic", axis=axis) for axis in np.eye(3)]
    joints += [sr.Joint(axis=axis) for axis in ((0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 0, 1))]
    arm = sr.Arm(joints, tool=placement((0.1, 0, 0.05)))
    q = np.array([0, 0, 0, 0.3, 0.4, -0.2, 0.5])
    T = arm.forward(q)
    target = turned(T, Rotation.from_rotvec(angle * np.array([0.6, 0.0, 0.8])), (0.1, 0, 0))
    q, _ = closed_loop(arm, q, target, 800, null_motion=sr.null_motions.Manipulability(), velocity_limits=3.0)
    np.testing.assert_allclose(pose_error(arm.forward(q), target), 0.0, atol=1e-5)


def test_five_axis_tracking_points_the_tool_and_lets_it_spin():
    arm = skew(8, seed=9)
    q = configuration(arm)
    target = turned(arm.forward(q), Rotation.from_rotvec([0.2, 0.3, -0.1]), (0.05, 0, 0.02))
    task = sr.Task(rows=(True, True, True, True, True, False), frame="tool")
    q, _ = closed_loop(arm, q, target, 600, task=task)
    T = arm.forward(q)
    np.testing.assert_allclose(T[:3, 2], target[:3, 2], atol=1e-6)
    np.testing.assert_allclose(T[:3, 3], target[:3, 3], atol=1e-6)


def test_feedforward_follows_a_moving_target_without_lag():
    arm, q = paper(), Q_PAPER
    target, ctl = np.array(arm.forward(q)), sr.Controller(arm, period=0.005)
    velocity = np.array([0.0, 0.05, 0.0, 0, 0, 0])
    lag = {}
    for name, feedforward in (("with", velocity), ("without", None)):
        at, goal = q, np.array(target)
        for _ in range(400):
            at = at + 0.005 * ctl.track(at, goal, feedforward=feedforward).rates
            goal[:3, 3] += 0.005 * velocity[:3]
        lag[name] = pose_error(arm.forward(at), goal)[0]
    assert lag["with"] < 1e-4
    assert lag["without"] > 0.01


def test_the_bound_tick_tracks_too():
    arm = paper()
    target = turned(arm.forward(Q_PAPER), Rotation.from_rotvec([0.1, 0.2, 0.3]), (0.01, 0, 0))
    one, other = sr.Controller(arm), sr.Controller(arm)
    rates = np.zeros(11)
    tick = one.bind(q=Q_PAPER, twist=TWIST, rates=rates, target=target)
    tick()
    np.testing.assert_array_equal(rates, other.track(Q_PAPER, target, feedforward=TWIST).rates)
    target[:] = arm.forward(Q_PAPER)
    tick()
    np.testing.assert_allclose(rates, sr.Controller(arm).step(Q_PAPER, TWIST).rates, atol=1e-12)


def lengths(arm, **settings):
    """Lengths of the two parts of the correction towards a pose that is far away in both, and the controller."""
    ctl = sr.Controller(arm, track_gain=10.0, **settings)
    for joint, kind in FAILURES.get(arm.name, {}).items():
        ctl.fail(joint, kind)
    far = turned(arm.forward(np.zeros(arm.n)), Rotation.from_rotvec([0, 0, 3.0]), (100, 0, 0))
    twist = ctl.track(np.zeros(arm.n), far).twist
    return np.linalg.norm(twist[:3]), np.linalg.norm(twist[3:])


FAILURES = {
    "one locked": {"j1": sr.Locked()},
    "runaway": {"j3": sr.Runaway(0.1)},
    "derated": {"j1": sr.Derated(0.5)},
    "all failed": {"j1": sr.Locked(), "j2": sr.Locked(), "j3": sr.Derated(0.0)},
}


@pytest.mark.parametrize(
    ("name", "linear", "angular"),
    [
        ("healthy", 3.0, 2.0),  # j1 at 1 rad/s, 3 m from the tool; j3 turns it at 2 rad/s
        ("one locked", 2.0, 2.0),  # j3, 1 m from the tool
        ("runaway", 3.0, 1.0),
        ("derated", 2.0, 2.0),  # j1 at 0.5 rad/s: 1.5 m/s
        ("all failed", 1000.0, 30.0),  # no bound: 10 times the errors
    ],
)
def test_by_default_the_correction_is_what_one_working_joint_can_do(name, linear, angular):
    three = sr.arms.planar(3).with_limits(velocity=(1.0, 0.5, 2.0))
    arm = sr.Arm(three.joints, tool=three.tool, name=name)
    np.testing.assert_allclose(lengths(arm), (linear, angular), rtol=1e-9)


def test_the_default_bound_follows_the_tool_of_the_task_slides_followers_and_new_limits():
    turn, slider = sr.Joint(name="a", velocity_limit=1.0), sr.Joint(name="b", kind="prismatic", axis=(1, 0, 0))
    slider = dataclasses.replace(slider, velocity_limit=0.2, position_limits=(-0.5, 0.3))
    arm = sr.Arm([turn, slider], tool=placement((1, 0, 0)))
    assert lengths(arm) == pytest.approx((1.5, 1.0))  # 1 m, and the slide's 0.5 m
    assert lengths(arm, task=sr.Task(tool=placement((2, 0, 0)))) == pytest.approx((3.5, 1.0))
    assert lengths(sr.Arm([slider])) == pytest.approx((0.2, 30.0))  # nothing turns: 10 times 3 rad
    free = dataclasses.replace(slider, position_limits=(-np.inf, np.inf))
    assert lengths(sr.Arm([turn, free])) == pytest.approx((1000.0, 1.0))
    follower = sr.Follower(sr.Joint(name="f", placement=placement((1, 0, 0))), leader="a", place=1, multiplier=-2.0)
    assert lengths(sr.Arm([turn], tool=placement((1, 0, 0)), followers=[follower])) == pytest.approx((4.0, 3.0))
    ctl = sr.Controller(arm, track_gain=10.0)
    ctl.set_limits(velocity=(2.0, 0.2))
    far = turned(arm.forward([0, 0]), Rotation.from_rotvec([0, 0, 3.0]), (100, 0, 0))
    np.testing.assert_allclose(np.linalg.norm(ctl.track([0, 0], far).twist[:3]), 3.0)


@pytest.mark.parametrize("limits", [np.inf, (np.inf, np.inf)])
def test_infinite_limits_leave_the_correction_as_it_is(limits):
    arm = sr.arms.planar(3).with_limits(velocity=0.1)
    assert lengths(arm, track_limits=limits) == pytest.approx((1000.0, 30.0))


@pytest.mark.parametrize("value", [-1.0, np.nan, (1.0,), (1.0, 1.0, 1.0), "none", (0.1, -0.1)])
def test_what_is_no_pair_of_limits_is_refused(value):
    refused(lambda: sr.Controller(paper(), track_limits=value), "track_limits")


PANDA = [(0, 0, 0.333), (0, -1, 0), (0, 1, 0.316), (0.0825, 1, 0), (-0.0825, -1, 0.384), (0, 1, 0), (0.088, 1, 0.107)]


@pytest.mark.parametrize("gain", [2.0, 10.0])
def test_a_target_out_of_reach_does_not_make_joints_flip(gain):
    """A Panda by its maker's table: without a bound a joint went from limit to limit in every tick, at a gain of 10."""
    rows = [sr.DHRow(a=a, alpha=turns * np.pi / 2, d=d) for a, turns, d in PANDA]
    arm = sr.Arm.from_dh(rows, "modified", velocity_limits=[2.175] * 4 + [2.61] * 3)
    q = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
    target = arm.forward(q)
    target[:3, 3] = (2.0, 0.1, 0.5)
    ctl, rates = sr.Controller(arm, period=0.01, track_gain=gain), []
    for _ in range(1200):
        rates.append(ctl.track(q, target).rates)
        q = q + 0.01 * rates[-1]
    assert np.abs(np.diff(rates[1000:], axis=0)).max() < 1e-3
