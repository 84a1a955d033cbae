"""Poses that no configuration reaches are never claimed, judged by the closed form of a spherical arm."""

import os

import numpy as np
import pytest

import stillreach as sr
from tests.oracles import spherical_arm as exact

COUNT = 5000 if os.environ.get("STILLREACH_FULL") else 100
ARM = sr.arms.iiwa14()
NARROW = ARM.with_limits(position=0.5 * ARM.position_limits)


def test_the_closed_form_describes_the_arm():
    """Its configurations reach the pose, and one of them is near the configuration that the pose was made from."""
    random = np.random.default_rng(3)
    for q in random.uniform(*ARM.position_limits.T, (20, 7)):
        pose = ARM.forward(q)
        found = exact.all_configurations(pose, 720)
        assert np.abs(ARM.forward(found) - pose).max() < 1e-9
        apart = np.abs((found - q + np.pi) % (2 * np.pi) - np.pi).max(axis=1)
        assert apart.min() < 0.2  # 720 places of the elbow are half a degree apart, its joints may turn faster
        assert exact.violation(pose[None], *ARM.position_limits.T)[0] < 0.2


def beyond_reach():
    """The wrist's centre farther from the shoulder than the links are long; half of the tools are within reach."""
    random = np.random.default_rng(4)
    near = exact.random_poses(random, COUNT, exact.UPPER + exact.LOWER + 1e-4, 0.93)
    return np.concatenate([near, exact.random_poses(random, COUNT, 0.93, 2.0)])


def below_the_elbow():
    """The wrist's centre closer to the shoulder than the elbow's limit of 120 deg leaves it."""
    closest = exact.distance_at(ARM.position_limits[3, 1])
    return exact.random_poses(np.random.default_rng(5), COUNT, 0.0, closest - 1e-4)


@pytest.mark.parametrize("arm", [ARM, NARROW], ids=["its limits", "half of them"])
def test_beyond_reach(arm):
    poses = beyond_reach()
    result = arm.inverse(poses, starts=30)
    assert not result.reached.any()
    assert 0.3 < result.too_far.mean() < 1.0  # the bound of the stretched arm sees some of them
    off = exact.wrist_distance(poses) - (exact.UPPER + exact.LOWER)
    assert (result.residual >= off / 2).all()  # entries e: the wrist is off by at most sqrt(3) (1 + 0.126) e


def test_excluded_by_the_limit_of_the_elbow():
    result = ARM.inverse(below_the_elbow(), starts=30)
    assert not result.reached.any()
    assert not result.too_far.any()
    assert (result.starts == 30).all()
    assert (result.steps <= 30 * 41).all()


def test_excluded_by_all_limits_together():
    poses = exact.excluded_poses(COUNT, *NARROW.position_limits.T)
    assert not NARROW.inverse(poses, starts=30).reached.any()
    wide = ARM.with_limits(position=np.tile([-10.0, 10.0], (7, 1)))
    assert wide.inverse(poses, starts=100).reached.all()
