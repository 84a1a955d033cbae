"""What many configurations keep without joints, beside brute force, arms solved by hand, and the report of each."""

from itertools import combinations
from math import sqrt

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError
from stillreach.arm.limits import sampling_range
from stillreach.arm.relative import failure_sets
from stillreach.tolerance.losses import all_sets, least_everywhere, relative
from stillreach.tolerance.speeds import guaranteed, normals

PLANE = sr.Task(rows=(True, True, False, False, False, False))
SWEEP = (True, True, True, True, True, False)


def some_arm(n, rng):
    """Joints in random places about random axes, now and then sliding."""
    joints = []
    for k in range(n):
        axis, placement = rng.normal(size=3), np.eye(4)
        placement[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        placement[:3, :3] *= np.sign(np.linalg.det(placement[:3, :3]))
        placement[:3, 3] = rng.uniform(-0.4, 0.4, 3)
        kind = "prismatic" if k % 5 == 3 else "revolute"
        joints.append(sr.Joint(name=f"j{k + 1}", kind=kind, axis=axis / np.linalg.norm(axis), placement=placement))
    return sr.Arm(joints).with_limits(velocity=rng.uniform(0.5, 2.0, n))


def volume(J):
    return sqrt(max(np.linalg.det(J @ J.T), 0.0))


def task_rows(arm, q, task):
    J = arm.jacobian(q)
    if task.frame == "tool":
        R = arm.forward(q)[:3, :3]
        J = np.vstack([R.T @ J[:3], R.T @ J[3:]])
    return J[list(task.indices)]


@pytest.mark.parametrize("n", range(7, 15))
def test_relative_manipulability_is_that_of_brute_force(n):
    rng = np.random.default_rng(n)
    arm = some_arm(n, rng)
    q = rng.uniform(-2.0, 2.0, (5, n))  # lanes that are not full
    for task in (sr.Task(), sr.Task(rows="position"), sr.Task(rows=SWEEP, frame="tool")):
        k = min(4 if n > 12 else 5, n - task.m)
        found = relative(arm, q, k, task=task, every=True)
        for row in (0, 4):
            J = task_rows(arm, q[row], task)
            whole, at = volume(J), 0
            for size in range(1, k + 1):
                sets = list(combinations(range(n), size))
                expected = np.array([volume(np.delete(J, own, axis=1)) / whole for own in sets])
                got = found.every[row, at : at + len(sets)]
                np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-7)  # a Gram matrix has half the digits
                assert found.worst[row, size - 1] == got.min()
                assert found.which[row, size - 1] == np.argmin(got)
                at += len(sets)
            np.testing.assert_array_equal(found.joint[row], found.every[row, :n])
            assert np.sum(found.joint[row] ** 2) == pytest.approx(n - task.m, abs=1e-12)


def test_small_values_keep_their_digits():
    """Unit planar 3R at (0, turn, bend): without joint 3 what is left is the area of the first two columns."""
    arm = sr.arms.planar(3)
    for turn in (1e-3, 1e-8, 1e-11, 1e-14):
        theta = np.array([0.0, np.pi - turn, 2.0])
        angles = np.cumsum(theta.astype(np.longdouble))
        ends = np.stack([np.cos(angles), np.sin(angles)])
        columns = [np.array([-x[1], x[0]]) for x in (ends[:, j:].sum(axis=1) for j in range(3))]
        minors = [a[0] * b[1] - a[1] * b[0] for a, b in combinations(columns, 2)]  # without joint 3, 2, 1
        expected = [float(abs(minor) / np.sqrt(sum(m * m for m in minors))) for minor in minors[::-1]]
        found = relative(arm, theta[None], 1, task=PLANE).joint[0]
        np.testing.assert_allclose(found, expected, rtol=0, atol=4e-16)
    arm = sr.arms.snake(30)
    left = relative(arm, np.random.default_rng(0).uniform(-1, 1, (3, arm.n)), 2).worst
    assert np.all((left > 0.0) & (left <= 1.0))


def test_an_arm_solved_by_hand():
    """Unit planar 3R at (any, 60, 120) deg: every joint leaves 1 / sqrt(3), and rates of 1 give known speeds."""
    arm = sr.arms.planar(3).with_limits(velocity=1.0)
    q = np.deg2rad([[17.0, 60.0, 120.0]] * 9)
    np.testing.assert_allclose(relative(arm, q, 1, task=PLANE).joint, 1.0 / sqrt(3.0), atol=1e-15)
    found = least_everywhere(arm, q, 2, task=PLANE)
    np.testing.assert_allclose(found.whole, 1.7320508, atol=5e-8)
    np.testing.assert_allclose(found.joint, 0.8660254, atol=5e-8)
    np.testing.assert_array_equal(found.worst[:, 1], 0.0)


def test_sets_larger_than_the_redundancy_leave_nothing():
    arm, rng = sr.arms.panda(), np.random.default_rng(1)
    found = relative(arm, rng.uniform(-1, 1, (5, 7)), 3, every=True)
    np.testing.assert_array_equal(found.worst[:, 1:], 0.0)
    np.testing.assert_array_equal(found.every[:, 7:], 0.0)
    six = sr.Arm(arm.joints[:6])
    np.testing.assert_array_equal(relative(six, rng.uniform(-1, 1, (5, 6)), 1).joint, 0.0)


def test_an_arm_without_full_rank_has_no_relative_manipulability():
    straight = np.zeros((3, 3))
    assert np.isnan(relative(sr.arms.planar(3), straight, 1, task=PLANE).joint).all()
    assert np.isnan(relative(sr.arms.planar(3), straight + 1.0, 2, every=True).every).all()  # 3 joints, 6 rows


def test_joints_that_do_not_turn_do_not_count():
    limits = sr.arms.panda().velocity_limits * (np.arange(7) != 2)
    arm, q = sr.arms.panda().with_limits(velocity=limits), np.random.default_rng(2).uniform(-2, 2, (4, 7))
    found = relative(arm, q, 1).joint
    np.testing.assert_allclose(found[:, 2], 1.0, atol=1e-14)
    np.testing.assert_allclose(np.delete(found, 2, axis=1), 0.0, atol=1e-12)
    np.testing.assert_array_equal(least_everywhere(arm, q, 1).joint[:, 0], 0.0)


@pytest.mark.parametrize("n", [3, 7, 9, 12])
def test_guaranteed_speeds_are_those_of_one_configuration(n):
    """Which the tests of the report compare with convex hulls."""
    rng = np.random.default_rng(n)
    arm = some_arm(n, rng)
    weights = sr.Weights(length=0.3, angle=0.7)
    for rows in ("pose", "position", SWEEP):
        task = sr.Task(rows=rows, weights=weights)
        if task.m > n:
            continue
        q, k = rng.uniform(-2, 2, (5, n)), min(3, n)
        sets = all_sets(n, k)
        found = least_everywhere(arm, q, k, task=task, sets=sets)
        scales = np.array([1 / 0.3 if row < 3 else 1 / 0.7 for row in task.indices])
        for row in range(len(q)):
            J = task_rows(arm, q[row], task) * scales[:, None]
            facets, exact = normals(J)
            assert exact
            rates, at = arm.velocity_limits, 0
            assert found.whole[row] == pytest.approx(float(guaranteed(J, facets, -rates, rates)), rel=1e-9)
            for size in range(1, k + 1):
                own = failure_sets(range(n), size)
                moving = np.ones((len(own), n))
                np.put_along_axis(moving, own, 0.0, axis=1)
                expected = guaranteed(J, facets, -rates * moving, rates * moving)
                np.testing.assert_allclose(found.every[row, at : at + len(own)], expected, rtol=1e-9, atol=1e-11)
                assert found.worst[row, size - 1] == pytest.approx(expected.min(), rel=1e-9, abs=1e-11)
                at += len(own)


def test_an_arm_of_many_joints_is_exact_too():
    """17 joints have 6,188 facets, each across the singular vector of five columns; a report looks at some of them."""
    arm, q = sr.arms.snake(17), np.random.default_rng(6).uniform(-1.0, 1.0, (2, 17))
    found = least_everywhere(arm, q, 1)
    for row in range(2):
        J = task_rows(arm, q[row], sr.Task()) * arm.velocity_limits
        columns = np.array(list(combinations(range(17), 5)))
        across = np.linalg.svd(J.T[columns] / np.linalg.norm(J, axis=0)[columns][..., None])[2][:, -1]
        parts = np.abs(across @ J)
        assert found.whole[row] == pytest.approx(parts.sum(axis=1).min(), rel=1e-9)
        np.testing.assert_allclose(found.joint[row], (parts.sum(axis=1)[:, None] - parts).min(axis=0), rtol=1e-9)
        assert sr.tolerance.report(arm, q[row], k=1).speed >= found.whole[row] * (1.0 - 1e-9)


def test_a_lost_direction_of_the_report_is_one_here():
    """The report looks along singular directions, a survey along all: what the first finds lost is lost."""
    alike, count = 0, 30
    for arm, k in ((sr.arms.panda(), 1), (sr.arms.canadarm2(), 1), (sr.arms.nasa_modular(), 3)):
        random = np.random.default_rng(3)
        q = random.uniform(*sampling_range(arm.kinds, *arm.position_limits.T), (count // 3, arm.n))
        left = least_everywhere(arm, q, k, least=True)
        depth = np.cumprod(left.worst >= 1.0, axis=1).sum(axis=1)
        for row in range(len(q)):
            report = sr.tolerance.report(arm, q[row], k=k)
            assert depth[row] <= report.depth
            alike += depth[row] == report.depth
    assert alike >= 0.9 * count


def test_answers_do_not_depend_on_neighbours_or_threads():
    arm = sr.arms.nasa_modular()
    q = np.random.default_rng(4).uniform(-2, 2, (203, 11))
    for function in (relative, least_everywhere):
        all_at_once = function(arm, q, 3, threads=2)
        for part in (slice(0, 1), slice(5, 8), slice(100, 203)):
            alone = function(arm, np.ascontiguousarray(q[part]), 3, threads=1)
            for name in ("whole", "joint", "worst", "which"):
                np.testing.assert_array_equal(getattr(alone, name), getattr(all_at_once, name)[part])


def test_too_much_is_refused():
    with pytest.raises(InputError, match="k: got 5, which makes 174436 sets of 30 joints"):
        all_sets(30, 5)
    with pytest.raises(
        InputError, match="metrics: got speeds of an arm with 32 joints and 6 rows, expected at most 200"
    ):
        least_everywhere(sr.arms.snake(32), np.zeros((1, 32)), 1)
    with pytest.raises(InputError, match="sizes: got 8"):
        relative(sr.arms.panda(), np.zeros((1, 7)), 8)
