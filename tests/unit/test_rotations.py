"""Rotations in every form that people write them, against SciPy."""

import numpy as np
from scipy.spatial.transform import Rotation

from stillreach._rotations import exp, from_pitch_yaw_roll, from_quaternions, from_rpy, log

ANGLES = [0.0, 1e-300, 1e-12, 1e-7, 0.3, 2.0, np.pi - 1e-7, np.pi]


def test_rotations_in_all_forms_are_those_of_scipy():
    rng = np.random.default_rng(8)
    axes = rng.normal(size=(len(ANGLES) * 20, 3))
    vectors = axes / np.linalg.norm(axes, axis=1)[:, None] * np.repeat(ANGLES, 20)[:, None]
    R = Rotation.from_rotvec(vectors).as_matrix()
    np.testing.assert_allclose(exp(vectors), R, atol=2e-15)
    np.testing.assert_allclose(exp(log(R)), R, atol=4e-15)
    np.testing.assert_allclose(np.linalg.norm(log(R), axis=1), np.linalg.norm(vectors, axis=1), rtol=1e-12, atol=1e-15)
    xyzw = rng.normal(size=(50, 4)) * 10.0 ** rng.integers(-200, 200, (50, 1))
    wanted = Rotation.from_quat(xyzw / np.max(np.abs(xyzw), axis=1, keepdims=True)).as_matrix()
    np.testing.assert_allclose(from_quaternions("q", xyzw[:, [3, 0, 1, 2]]), wanted, atol=1e-14)
    angles = rng.uniform(-4, 4, (50, 3))
    np.testing.assert_allclose(from_rpy(angles), Rotation.from_euler("xyz", angles).as_matrix(), atol=1e-14)
    pitch_yaw_roll = Rotation.from_euler("YZX", angles).as_matrix()  # about moving axes: R_y R_z R_x
    np.testing.assert_allclose(from_pitch_yaw_roll(angles), pitch_yaw_roll, atol=1e-14)
