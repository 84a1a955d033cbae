"""Distances between poses, beside SciPy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stillreach._core import frames, pose_distances
from stillreach.errors import InputError


def poses(rng, count, spread):
    T = np.tile(np.eye(4), (count, 1, 1))
    T[:, :3, :3] = Rotation.from_rotvec(rng.normal(size=(count, 3)) * spread).as_matrix()
    T[:, :3, 3] = rng.normal(size=(count, 3))
    return T


@pytest.mark.parametrize("spread", [1e-6, 0.1, 3.0])
@pytest.mark.parametrize("along_pose", [False, True])
def test_distance_and_angle_are_those_of_scipy(spread, along_pose):
    rng = np.random.default_rng(3)
    actual, turn = poses(rng, 500, 2.0), poses(rng, 500, spread)
    wanted = actual.copy()
    wanted[:, :3, :3] = turn[:, :3, :3] @ actual[:, :3, :3]
    wanted[:, :3, 3] += spread * rng.normal(size=(500, 3))
    R = Rotation.from_matrix(actual[:, :3, :3])
    shift = wanted[:, :3, 3] - actual[:, :3, 3]
    angle = (Rotation.from_matrix(wanted[:, :3, :3]) * R.inv()).as_rotvec()
    if along_pose:
        shift, angle = R.inv().apply(shift), R.inv().apply(angle)
    for asked in ([1, 1, 1, 1, 1, 1], [1, 0, 1, 0, 1, 0], [0, 1, 0, 0, 0, 0], [0, 0, 0, 1, 1, 0]):
        off = pose_distances(actual, wanted, np.array(asked, dtype=float), along_pose)
        expected = [np.linalg.norm(part * mask, axis=1) for part, mask in ((shift, asked[:3]), (angle, asked[3:]))]
        np.testing.assert_allclose(off, expected, rtol=1e-8, atol=1e-14)


def test_what_is_no_pose_has_no_distance():
    two = np.tile(np.eye(4), (2, 1, 1))
    bent = two.copy()
    bent[1, 0, 0] = 2.0
    off = pose_distances(bent, two, np.ones(6), False)
    assert off[:, 0].tolist() == [0.0, 0.0]
    assert np.isnan(off[:, 1]).all()
    with pytest.raises(InputError, match="poses: got row 1, expected rigid transforms"):
        frames(bent)


def test_frames_hold_the_axes_and_the_place():
    T = poses(np.random.default_rng(1), 5, 1.0)
    found = frames(T)
    np.testing.assert_allclose(found[:, :9], np.swapaxes(T[:, :3, :3], 1, 2).reshape(5, 9), atol=1e-15)
    np.testing.assert_array_equal(found[:, 9:], T[:, :3, 3])
