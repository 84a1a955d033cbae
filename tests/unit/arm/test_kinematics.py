"""Pose and Jacobian against the literal product of transforms, and what they accept and refuse."""

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm import literal_kinematics as literal
from tests.unit.arm.odd_arms import configurations, scale


def test_forward_is_the_product_of_the_transforms(arm):
    for q in configurations(arm.n):
        error = np.abs(arm.forward(q) - literal.forward(arm.joints, arm.tool, q))
        assert np.max(error) <= 1e-13 * scale(arm, q)


def test_jacobian_is_the_geometric_one(arm):
    for q in configurations(arm.n):
        error = np.abs(arm.jacobian(q) - literal.jacobian(arm.joints, arm.tool, q))
        assert np.max(error) <= 1e-13 * scale(arm, q)


def test_jacobian_is_the_derivative_of_the_pose(arm):
    for q in configurations(arm.n):
        J = arm.jacobian(q)
        for i in range(arm.n):
            plus, minus = q.copy(), q.copy()
            plus[i] += 1e-5
            minus[i] -= 1e-5
            step = plus[i] - minus[i]
            ahead, behind = arm.forward(plus), arm.forward(minus)
            turn = literal.small_rotation_vector(ahead[:3, :3] @ behind[:3, :3].T)
            twist = np.concatenate((ahead[:3, 3] - behind[:3, 3], turn)) / step
            np.testing.assert_allclose(J[:, i], twist, rtol=0, atol=2e-10 * scale(arm, q))


def test_the_tool_stays_a_rigid_body(arm):
    for q, T in zip(configurations(arm.n), arm.forward(configurations(arm.n)), strict=True):
        R = T[:3, :3]
        np.testing.assert_allclose(R @ R.T, np.eye(3), rtol=0, atol=1e-13)
        assert np.linalg.det(R) > 0, q
        assert T[3].tolist() == [0, 0, 0, 1]


def test_a_slide_does_not_turn_the_tool(arm):
    J = arm.jacobian(configurations(arm.n))
    assert np.all(J[:, 3:, arm.kinds == 1] == 0.0)
    np.testing.assert_allclose(np.linalg.norm(J[:, :3, arm.kinds == 1], axis=1), 1.0, rtol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(J[:, 3:, arm.kinds == 0], axis=1), 1.0, rtol=1e-13)


def test_many_configurations_are_each_what_one_is(arm):
    q = configurations(arm.n)
    T, J = arm.forward(q), arm.jacobian(q)
    assert T.shape == (len(q), 4, 4)
    assert J.shape == (len(q), 6, arm.n)
    for k in range(len(q)):
        np.testing.assert_allclose(T[k], arm.forward(q[k]), rtol=0, atol=1e-13 * scale(arm, q[k]))
        np.testing.assert_allclose(J[k], arm.jacobian(q[k]), rtol=0, atol=1e-13 * scale(arm, q[k]))


def test_turning_the_base_turns_pose_and_jacobian(arm):
    turn = np.eye(4)
    turn[:3, :3] = literal.rotation(np.array([2.0, -1.0, 2.0]) / 3.0, 0.7)
    first = sr.Joint(kind=arm.joints[0].kind, placement=turn @ arm.joints[0].placement, axis=arm.joints[0].axis)
    turned = sr.Arm([first, *arm.joints[1:]], tool=arm.tool)
    both = np.kron(np.eye(2), turn[:3, :3])
    for q in configurations(arm.n):
        np.testing.assert_allclose(turned.forward(q), turn @ arm.forward(q), rtol=0, atol=1e-13 * scale(arm, q))
        np.testing.assert_allclose(turned.jacobian(q), both @ arm.jacobian(q), rtol=0, atol=1e-13 * scale(arm, q))


@pytest.mark.parametrize("lead", [(), (0,), (1,), (3,), (9,), (2, 3), (0, 3), (2, 1, 2)])
def test_any_leading_shape(lead):
    arm = sr.arms.canadarm2()
    q = np.random.default_rng(3).uniform(-3, 3, (*lead, 7))
    T, J = arm.forward(q), arm.jacobian(q)
    assert T.shape == (*lead, 4, 4)
    assert J.shape == (*lead, 6, 7)
    assert T.dtype == J.dtype == np.float64
    for index in np.ndindex(*lead):
        np.testing.assert_allclose(T[index], literal.forward(arm.joints, arm.tool, q[index]), atol=1e-12)
        np.testing.assert_allclose(J[index], literal.jacobian(arm.joints, arm.tool, q[index]), atol=1e-12)


def test_lists_integers_and_other_layouts_give_the_same():
    arm = sr.arms.planar(3)
    q = np.arange(12.0).reshape(4, 3)
    wide = np.zeros((4, 6))
    wide[:, ::2] = q
    backwards = np.ascontiguousarray(q[::-1])
    same = {
        "list": q.tolist(),
        "integers": q.astype(int),
        "unsigned": q.astype(np.uint8),
        "float32": q.astype(np.float32),
        "Fortran order": np.asfortranarray(q),
        "strided": wide[:, ::2],
        "reversed": backwards[::-1],
        "other byte order": q.astype(">f8"),
        "tuple of arrays": tuple(q),
    }
    for what, value in same.items():
        np.testing.assert_array_equal(arm.forward(value), arm.forward(q), err_msg=what)
        np.testing.assert_array_equal(arm.jacobian(value), arm.jacobian(q), err_msg=what)


def test_read_only_q_is_welcome_and_q_is_left_alone():
    arm = sr.arms.planar(2)
    q = np.array([0.1, 0.2])
    q.flags.writeable = False
    first = arm.forward(q)
    arm.jacobian(q)
    assert q.tolist() == [0.1, 0.2]
    first[:] = 0.0  # the answer belongs to the caller
    assert arm.forward(q)[3, 3] == 1.0


@pytest.mark.parametrize("function", ["forward", "jacobian"])
@pytest.mark.parametrize(
    ("q", "told"),
    [
        ([0.0, np.nan, 0.0], "q: got nan at index 1, expected finite numbers in an array (..., 3)"),
        ([[0, 0, 0], [0, 0, np.inf]], "inf at index (1, 2)"),
        ([0.0, 1.0], "[0.0, 1.0] of shape (2,)"),
        (np.zeros((3, 4)), "float64 array of shape (3, 4)"),
        (np.zeros((0, 4)), "shape (0, 4)"),
        (0.5, "0.5"),
        ([], "[] of shape (0,)"),
        ([True, False, True], "[True, False, True]"),
        ([0.0, True, 0.0], "[0.0, True, 0.0]"),
        (np.zeros(3, dtype=bool), "bool array of shape (3,)"),
        ([0, 0, 1j], "1j"),
        (np.zeros(3, dtype=complex), "complex128 array"),
        (["a", "b", "c"], "'a'"),
        ("abc", "'abc'"),
        (None, "None"),
        ([[0, 0, 0], [0, 0]], "a ragged list"),
        (np.array([0, 0, None]), "object array"),
    ],
)
def test_anything_else_is_refused(function, q, told):
    with pytest.raises(sr.InputError) as caught:
        getattr(sr.arms.planar(3), function)(q)
    assert caught.value.argument == "q"
    assert told in str(caught.value)
    assert "(..., 3)" in caught.value.expected
