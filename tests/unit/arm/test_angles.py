"""Sine and cosine of any joint angle, near multiples of a quarter turn and very large ones included."""

import math

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm import literal_kinematics as literal

NEAR_QUARTER_TURNS = [
    math.nextafter(k * math.pi / 2, way) for k in (*range(-9, 10), 1001, -4096, 499_999) for way in (-1e9, 1e9)
]
LARGE = [1e3, 1e5, 7.9e5, 8e5, math.nextafter(8e5, 1e9), 8.1e5, 1e6, 1e9, 1e15, 1e22, 1e300, 2.0**52]
SMALL = [0.0, 5e-324, 1e-300, 1e-160, 1e-20, 1e-8, 1e-7, 1e-3]


def angles():
    rng = np.random.default_rng(6)
    spread = [rng.uniform(-bound, bound, 200) for bound in (1.0, 10.0, 1e4, 8e5)]
    return np.concatenate([NEAR_QUARTER_TURNS, LARGE, SMALL, *spread])


def test_one_link_shows_sine_and_cosine_to_rounding():
    values = np.concatenate([angles(), -angles()])
    T = sr.arms.planar(1).forward(values[:, None])
    cosine = np.array([math.cos(value) for value in values])
    sine = np.array([math.sin(value) for value in values])
    np.testing.assert_allclose(T[:, 0, 3], cosine, rtol=0, atol=4e-16)
    np.testing.assert_allclose(T[:, 1, 3], sine, rtol=0, atol=4e-16)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 8, 9])
def test_a_very_large_angle_does_not_disturb_its_neighbours(n):
    arm = sr.arms.snake(n)
    for i in range(n):
        q = np.linspace(-3, 3, n)
        q[i] = 1e9
        np.testing.assert_allclose(arm.forward(q), literal.forward(arm.joints, arm.tool, q), rtol=0, atol=1e-14)


def test_a_slide_may_be_far_out():
    arm = sr.Arm([sr.Joint(kind="prismatic", axis=(1, 0, 0)), sr.Joint()])
    assert arm.forward([1e9, 0.0])[0, 3] == 1e9


def test_three_hundred_joints():
    arm = sr.arms.snake(300)
    q = np.random.default_rng(300).uniform(-0.3, 0.3, 300)
    np.testing.assert_allclose(arm.forward(q), literal.forward(arm.joints, arm.tool, q), rtol=0, atol=1e-12)
    np.testing.assert_allclose(arm.jacobian(q), literal.jacobian(arm.joints, arm.tool, q), rtol=0, atol=1e-12)
