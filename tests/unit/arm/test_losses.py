"""What the loss of a joint costs an arm, against plain linear algebra."""

import numpy as np
import pytest

import stillreach as sr
from stillreach._words import direction


def manipulability(J):
    return np.prod(np.linalg.svd(J, compute_uv=False))


@pytest.mark.parametrize("name", ["canadarm2", "nasa_modular", "snake9"])
def test_what_is_left_without_a_joint_is_the_ratio_of_manipulabilities(name):
    arm = sr.arms.by_name(name).with_limits(velocity=1.0)
    for q in np.random.default_rng(3).uniform(-2.0, 2.0, (20, arm.n)):
        J = arm.jacobian(q)
        for i, loss in enumerate(arm.losses(q).by_joint.values()):
            rest = np.delete(J, i, axis=1)
            assert loss.remaining == pytest.approx(manipulability(rest) / manipulability(J), abs=1e-9)
            np.testing.assert_allclose(loss.singular_values, np.linalg.svd(rest, compute_uv=False), atol=1e-12)
            assert len(loss.lost) == 0


def test_a_planar_arm_of_three_joints_loses_a_direction_with_each():
    arm = sr.arms.planar(3)
    q = np.deg2rad([10.0, 60.0, 120.0])
    J = arm.jacobian(q)
    for i, loss in enumerate(arm.losses(q).by_joint.values()):
        assert loss.remaining == 0.0
        assert loss.lost.shape == (1, 6)
        lost = loss.lost[0]
        assert np.linalg.norm(lost) == pytest.approx(1.0)
        np.testing.assert_allclose(lost @ np.delete(J, i, axis=1), 0.0, atol=1e-12)
        assert abs(lost @ J[:, i]) > 1e-3  # the whole arm served it


def elbow_arm(right_angle=np.pi / 2):
    """Spherical shoulder, elbow, spherical wrist, with right angles as a file writes them."""
    shoulder = [sr.DHRow(alpha=-right_angle), sr.DHRow(alpha=right_angle), sr.DHRow(d=0.4, alpha=-right_angle)]
    wrist = [sr.DHRow(d=0.4, alpha=right_angle), sr.DHRow(alpha=-right_angle), sr.DHRow()]
    return sr.Arm.from_dh([*shoulder, sr.DHRow(alpha=right_angle), *wrist])


RIGHT_ANGLES = pytest.mark.parametrize("right_angle", [np.pi / 2, 1.5708, 1.571])
Q = [0.3, -0.9, 0.5, 1.4, -0.7, 1.1, 0.2]


@RIGHT_ANGLES
def test_an_arm_with_a_spherical_shoulder_and_wrist_never_has_its_elbow_to_spare(right_angle):
    left = elbow_arm(right_angle).losses().typical
    assert left[3] == 0.0
    assert np.all(np.delete(left, 3) > 0.01)


@RIGHT_ANGLES
def test_rounding_in_a_file_is_not_motion(right_angle):
    """The direction is that of the exact arm: the forces through shoulder and wrist, along the line between them."""
    lost = elbow_arm(right_angle).losses(Q)["j4"].lost
    wrist = elbow_arm().forward(Q)[:3, 3]
    expected = np.concatenate([wrist / np.linalg.norm(wrist), np.zeros(3)])
    assert lost.shape == (1, 6)
    assert abs(lost[0] @ expected) == pytest.approx(1.0, abs=1e-4)


def test_what_counts_as_lost_is_what_full_rates_give():
    """Two slides along x: without the faster one the slower one is left."""
    slides = [
        sr.Joint(name="fast", kind="prismatic", axis=[1, 0, 0]),
        sr.Joint(name="slow", kind="prismatic", axis=[1, 0, 0]),
    ]
    for slow, lost in ((0.9e-3, 1), (1.1e-3, 0)):
        arm = sr.Arm(slides).with_limits(velocity=[0.5, slow])
        assert len(arm.losses(np.zeros(2))["fast"].lost) == lost
        assert len(arm.losses(np.zeros(2), lost_below=(slow / 2, 0.01))["fast"].lost) == 0
        assert len(arm.losses(np.zeros(2), lost_below=(2 * slow, 0.01))["fast"].lost) == 1
        assert len(arm.losses(np.zeros(2))[1].lost) == 0


@pytest.mark.parametrize(("limit", "lost"), [(0.09, 1), (0.11, 0), (np.inf, 0)])
def test_a_turn_counts_from_a_tenth_of_a_degree_a_second(limit, lost):
    turns = [sr.Joint(name="a", axis=[0, 0, 1]), sr.Joint(name="b", axis=[0, 0, 1])]
    arm = sr.Arm(turns).with_limits(velocity=[1.0, np.deg2rad(limit)])
    found = arm.losses(np.zeros(2), sr.Task(rows="orientation"))
    assert [len(loss.lost) for loss in found.by_joint.values()] == [lost, 0]


def test_a_joint_that_cannot_move_takes_nothing_away():
    arm = sr.arms.planar(4).with_limits(velocity=[1.0, 1.0, 1.0, 0.0])
    task, q = sr.Task(rows="position"), [0.3, 0.8, -0.5, 0.9]
    found, whole = arm.losses(q, task), sr.arms.planar(4).losses(q, task)
    assert found["j4"].remaining == pytest.approx(1.0)
    assert found["j1"].remaining < whole["j1"].remaining


@pytest.mark.parametrize("frame", ["base", "tool"])
def test_a_task_of_fewer_rows_loses_less(frame):
    arm, q = sr.arms.canadarm2(), np.array([0.3, 0.8, -0.5, 0.9, 0.4, -0.7, 0.2])
    R = arm.forward(q)[:3, :3] if frame == "tool" else np.eye(3)
    J = (R.T @ arm.jacobian(q)[:3])[[0, 2]]
    task = sr.Task(rows=[True, False, True, False, False, False], frame=frame)
    for i, loss in enumerate(arm.losses(q, task).by_joint.values()):
        rest = np.delete(J, i, axis=1)
        assert loss.remaining == pytest.approx(manipulability(rest) / manipulability(J), abs=1e-9)
        assert loss.rank == 2


def test_the_default_pose_is_the_most_dexterous_of_a_sample():
    arm = sr.arms.canadarm2()  # all joints have the same rate limit
    best = arm.losses().q
    lower, upper = arm.position_limits.T
    sample = np.random.default_rng(1994).uniform(lower, upper, (200, 7))
    np.testing.assert_array_equal(best, max(sample, key=lambda q: manipulability(arm.jacobian(q))))


def test_a_little_that_is_left_is_not_called_nothing():
    """2 mm/s of 20 m/s: not lost, and not 0 %."""
    slides = [sr.Joint(name="fast", kind="prismatic", axis=[1, 0, 0]), sr.Joint(name="turn", axis=[0, 0, 1])]
    tool = np.eye(4)
    tool[1, 3] = 1e-3
    arm = sr.Arm(slides, tool=tool).with_limits(velocity=[20.0, 2.0])
    found = arm.losses(np.zeros(2), sr.Task(rows=[True] + [False] * 5))
    assert len(found["fast"].lost) == 0
    assert 0.0 < found["fast"].remaining < 2e-3
    assert "lost" not in str(found).splitlines()[1]


def test_values_are_by_joint_and_in_words():
    arm = sr.arms.planar(3)
    found = arm.losses({"j3": 2.0, "j1": 0.1, "j2": 1.0}, sr.Task(rows="position"))
    assert list(found) == list(arm.joint_names)
    assert found["j2"] is found[1]
    assert [found[name].remaining for name in found] == found.remaining.tolist()
    assert not found.remaining.flags.writeable
    assert str(found).endswith(found.verdict)
    assert repr(found).startswith(f"<Losses of {arm.name}: j1 ")
    with pytest.raises(sr.errors.UnknownJointError):
        found["j9"]


@pytest.mark.parametrize(
    ("arguments", "argument"),
    [
        (((0.0, 1.0),), "q"),
        (([0.0, 1.0, 2.0], "position"), "task"),
        (([0.0, 1.0, 2.0], None, (0.0, 1.0)), "lost_below"),
    ],
)
def test_invalid_arguments_are_refused(arguments, argument):
    q, task, below = (*arguments, *(None, (1e-3, 1e-3))[len(arguments) - 1 :])[:3]
    with pytest.raises(sr.InputError, match=f"^{argument}: "):
        sr.arms.planar(3).losses(q, task, lost_below=below)


def test_a_direction_in_words():
    assert direction(np.array([0, 0, -1.0, 0, 0, 0.01]), range(6), signed=False) == "vz"
    assert direction(np.array([0, 0, -1.0, 0, 0, 0.01]), range(6)) == "-vz"
    assert direction(np.array([-0.6, 0, 0, 0, 0.8, 0]), range(6), signed=False) == "0.60 vx - 0.80 wy"
    assert direction(np.array([-0.6, 0, 0, 0, 0.8, 0]), range(6)) == "-0.60 vx + 0.80 wy"
    assert direction(np.array([0.0, 1.0]), (0, 5)) == "wz"
