"""Arms whose answers can be written down by hand."""

import numpy as np
import pytest

import stillreach as sr

INCH = 0.0254


def test_planar_two_links():
    arm = sr.arms.planar(2)
    for q1, q2 in np.random.default_rng(2).uniform(-np.pi, np.pi, (20, 2)):
        s1, c1, s12, c12 = np.sin(q1), np.cos(q1), np.sin(q1 + q2), np.cos(q1 + q2)
        T = [[c12, -s12, 0, c1 + c12], [s12, c12, 0, s1 + s12], [0, 0, 1, 0], [0, 0, 0, 1]]
        J = [[-s1 - s12, -s12], [c1 + c12, c12], [0, 0], [0, 0], [0, 0], [1, 1]]
        np.testing.assert_allclose(arm.forward([q1, q2]), T, rtol=0, atol=1e-15)
        np.testing.assert_allclose(arm.jacobian([q1, q2]), J, rtol=0, atol=1e-15)


def test_the_paper_arm_stands_straight_up():
    arm = sr.arms.nasa_modular()
    T = arm.forward(np.zeros(11))
    np.testing.assert_allclose(T[:3, 3], [0, 0, 15 * 12 * INCH], rtol=0, atol=1e-15)
    np.testing.assert_allclose(T[:3, :3], np.eye(3), rtol=0, atol=1e-15)
    assert np.linalg.matrix_rank(arm.jacobian(np.zeros(11))) == 3


def test_pitches_of_the_paper_arm_lean_towards_minus_x():
    arm = sr.arms.nasa_modular()
    for pitch, height in ((1, 1), (3, 2), (5, 3), (7, 4), (9, 5)):
        q = np.zeros(11)
        q[pitch] = np.pi / 2
        beyond = (6 - height) * 30 * INCH
        np.testing.assert_allclose(arm.forward(q)[:3, 3], [-beyond, 0, height * 30 * INCH], rtol=0, atol=1e-15)


def test_rolls_of_the_paper_arm_turn_about_the_link_left_handed_never():
    arm = sr.arms.nasa_modular()
    q = np.zeros(11)
    q[[0, 1]] = np.pi / 2  # lean towards -x, after a quarter turn about z: towards -y
    np.testing.assert_allclose(arm.forward(q)[:3, 3], [0, -5 * 30 * INCH, 30 * INCH], rtol=0, atol=1e-15)


def test_the_first_example_of_the_paper_starts_where_it_says():
    q = np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 0, 0])
    inches = sr.arms.nasa_modular().forward(q)[:3, 3] / INCH
    np.testing.assert_allclose(inches, [113.2, 53.2, 73.4], rtol=0, atol=0.05)


def test_rolls_of_the_paper_arm_sit_in_the_middle_of_their_segments():
    arm = sr.arms.nasa_modular(lengths=[1, 2, 3, 4, 5, 6])
    q = np.zeros(11)
    T = np.array([joint.placement for joint in arm.joints])
    heights = np.cumsum(T[:, 2, 3])
    np.testing.assert_allclose(heights, [0.5, 1, 2, 3, 4.5, 6, 8, 10, 12.5, 15, 18])
    np.testing.assert_allclose(arm.forward(q)[2, 3], 21)


def test_snake_pitches_about_y_and_yaws_about_z():
    arm = sr.arms.snake(4)
    quarter = np.pi / 2
    for q, end in (
        ([0, 0, 0, 0], [0.4, 0, 0]),
        ([quarter, 0, 0, 0], [0, 0, -0.4]),
        ([0, quarter, 0, 0], [0.1, 0.3, 0]),
        ([0, 0, quarter, 0], [0.2, 0, -0.2]),
        ([0, 0, 0, quarter], [0.3, 0.1, 0]),
    ):
        np.testing.assert_allclose(arm.forward(q)[:3, 3], end, rtol=0, atol=1e-15)


def test_canadarm2_from_its_published_geometry():
    arm = sr.arms.canadarm2()
    zero = arm.jacobian(np.zeros(7))
    columns = [  # axis x (tool - point on the axis), axis
        [0, 0, -1.6134, 1, 0, 0],
        [1.6134, 15.5789, 0, 0, 0, 1],
        [-0.7026, 0, -15.5789, 0, 1, 0],
        [-0.7026, 0, -8.4689, 0, 1, 0],
        [-0.7026, 0, -1.3589, 0, 1, 0],
        [0, 1.3589, 0, 0, 0, 1],
        [0, 0, 0, 1, 0, 0],
    ]
    np.testing.assert_allclose(arm.forward(np.zeros(7))[:3, 3], [16.9378, -1.6134, 0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(zero, np.transpose(columns), rtol=0, atol=1e-14)
    elbow = arm.forward([0, 0, 0, np.pi / 2, 0, 0, 0])
    np.testing.assert_allclose(elbow[:3, 3], [7.7663, -1.6134, -7.7663], rtol=0, atol=1e-14)
    np.testing.assert_allclose(elbow[:3, :3], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], rtol=0, atol=1e-14)


def test_canadarm2_limits():
    arm = sr.arms.canadarm2()
    np.testing.assert_allclose(np.rad2deg(arm.velocity_limits), 4.0)
    np.testing.assert_allclose(np.rad2deg(arm.position_limits), [[-270, 270]] * 7)


@pytest.mark.parametrize(
    ("arm", "rate"),
    [(sr.arms.nasa_modular(), np.deg2rad(50)), (sr.arms.planar(4), 1.0), (sr.arms.snake(6), 1.0)],
    ids=lambda value: getattr(value, "name", ""),
)
def test_catalogue_arms_have_a_rate_limit_and_no_position_limits(arm, rate):
    np.testing.assert_array_equal(arm.velocity_limits, np.full(arm.n, rate))
    np.testing.assert_array_equal(arm.position_limits, [[-np.inf, np.inf]] * arm.n)
    np.testing.assert_array_equal(arm.acceleration_limits, np.full(arm.n, np.inf))
    assert arm.joint_names == tuple(f"j{i + 1}" for i in range(arm.n))


@pytest.mark.parametrize("build", [sr.arms.planar, sr.arms.snake])
@pytest.mark.parametrize("n", [0, -1, 2.0, "3", True, None])
def test_a_number_of_joints_is_a_positive_integer(build, n):
    with pytest.raises(sr.InputError, match=r"n: got .*, expected an integer of at least 1"):
        build(n)


@pytest.mark.parametrize("lengths", [[1, 2, 3], [1] * 7, [1, 1, 1, 1, 1, -1], [1, 1, 1, 1, 1, np.inf], "six"])
def test_the_paper_arm_has_six_lengths(lengths):
    with pytest.raises(sr.InputError, match=r"lengths: got .*, expected 6 finite numbers"):
        sr.arms.nasa_modular(lengths=lengths)
