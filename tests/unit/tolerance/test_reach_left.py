"""The poses that are left after the loss of a joint."""

import math

import numpy as np
import pytest

import stillreach as sr


def test_two_links_that_lose_a_joint():
    """Of the disc of two unit links: without the first joint a circle around its end, without the second one around
    the base; a sample meets neither. With the first of three joints of no length, all is left."""
    planar = sr.Task(rows=[True, True, False, False, False, False])
    lost = sr.tolerance.reach(sr.arms.planar(2), [0.0, 0.5], task=planar, samples=50)
    assert np.array_equal(lost.shares, [0.0, 0.0])
    doubled = sr.Arm([sr.Joint(name="j0", axis=[0, 0, 1]), *sr.arms.planar(2).joints], tool=sr.arms.planar(2).tool)
    left = sr.tolerance.reach(doubled, [0.3, 0.0, 0.5], task=planar, samples=50)
    assert np.array_equal(left.shares, [1.0, 1.0, 0.0])
    assert left.verdict.startswith("The loss of j2 costs most: 0 % of the poses")


def test_a_share_by_geometry():
    """Three unit links, the last joint locked at 90°: the tool reaches the ring sqrt(2) - 1 ... sqrt(2) + 1."""
    planar = sr.Task(rows=[True, True, False, False, False, False])
    left = sr.tolerance.reach(sr.arms.planar(3), [0.0, 0.0, math.pi / 2], task=planar, samples=400)
    radius = np.linalg.norm(left.poses[:, :2, 3], axis=1)
    inside = (radius >= math.sqrt(2) - 1) & (radius <= math.sqrt(2) + 1)
    assert left.shares[2] == np.mean(inside)
    assert 0.5 < left.shares[2] < 1.0


def test_the_verdict_names_equal_losses_and_what_the_whole_arm_reaches():
    """Poses of a circle around the base, and one out of reach: the first of two links turns, the second does not."""
    planar = sr.Task(rows=[True, True, False, False, False, False])
    angles = np.linspace(-1.0, 1.0, 5)
    poses = sr.arms.planar(3).forward(np.stack([angles, 0 * angles, 0 * angles + 0.5], axis=1))
    poses[4, 0, 3] = 9.0
    left = sr.tolerance.reach(sr.arms.planar(3), [3.0, 0.0, 0.5], poses=poses, task=planar)
    assert left.shares.tolist() == [0.0, 0.8, 0.8]
    assert left.verdict == (
        "The loss of j1 costs most: 0 % of the poses stay within reach. Without j2 or j3 it is 80 %, with all joints "
        "80 %."
    )


def test_the_verdict_names_the_elbow_of_a_nearly_spherical_arm():
    arm = sr.arms.xarm7()
    left = sr.tolerance.reach(arm, arm.position_limits.mean(axis=1), samples=20, starts=2)
    assert "Without joint4 this arm is nearly singular in most configurations (at the median 4 %" in left.verdict
    assert left.verdict.count("nearly singular") == 1


def test_invalid_arguments():
    arm = sr.arms.panda()
    for arguments, name in (({"samples": 0}, "samples"), ({"seed": -1}, "seed"), ({"starts": 0}, "starts")):
        with pytest.raises(sr.InputError) as caught:
            sr.tolerance.reach(arm, np.zeros(7), **arguments)
        assert caught.value.argument == name
    with pytest.raises(sr.InputError):
        sr.tolerance.reach(arm, np.zeros(6))
