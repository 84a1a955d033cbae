"""The tolerance report, beside brute force, convex hulls, linear programs, and arms solved by hand."""

from itertools import combinations
from math import comb, sqrt

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

import stillreach as sr
from stillreach import InputError
from stillreach._words import direction
from stillreach.arm.relative import best_possible, failure_sets, null_basis, without
from stillreach.errors import UnknownJointError
from stillreach.tolerance.speeds import guaranteed, normals

PLANE = sr.Task(rows=(True, True, False, False, False, False))
TRIANGLE = np.deg2rad([17.0, 60.0, 120.0])
PANDA = sr.arms.panda()
BENT = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])


def three():
    return sr.arms.planar(3).with_limits(velocity=1.0)


def manipulability(J):
    return float(np.prod(np.linalg.svd(J, compute_uv=False)[: len(J)])) if J.shape[1] >= len(J) else 0.0


def columns(angles, length):
    angles = np.deg2rad(angles)
    return length * np.array([np.cos(angles), np.sin(angles)])


def relative(J, size):
    return without(null_basis(J), failure_sets(range(J.shape[1]), size))


@pytest.mark.parametrize("n", range(7, 15))
def test_relative_manipulability_is_that_of_brute_force(n):
    rng = np.random.default_rng(n)
    for m in (2, 3, 6):
        J = rng.normal(size=(m, n))
        whole = manipulability(J)
        for size in range(1, min(5, n - m) + 1):
            expected = [manipulability(np.delete(J, sets, axis=1)) / whole for sets in combinations(range(n), size)]
            np.testing.assert_allclose(relative(J, size), expected, rtol=0, atol=1e-10)
        assert np.sum(relative(J, 1) ** 2) == pytest.approx(n - m, abs=1e-12)


def test_it_does_not_depend_on_the_units_of_the_task():
    report = sr.tolerance.report(PANDA, BENT, k=1)
    J = PANDA.jacobian(BENT)
    scaled = np.diag([1000.0, 1000.0, 1000.0, 57.3, 57.3, 57.3]) @ J
    np.testing.assert_allclose(report.relative[0], relative(scaled, 1), atol=1e-12)
    weighted = sr.Task(weights=sr.Weights(length=0.01))
    np.testing.assert_allclose(sr.tolerance.report(PANDA, BENT, k=1, task=weighted).relative[0], report.relative[0])


def test_no_arm_beats_the_bound():
    for size, bound in enumerate((0.6742, 0.4264, 0.2462, 0.1231, 0.0465), start=1):
        assert best_possible(11, 6, size) == pytest.approx(bound, abs=5e-5)
        assert best_possible(11, 6, size) == sqrt(comb(5, size) / comb(11, size))
    rng = np.random.default_rng(0)
    for _ in range(200):
        J = rng.normal(size=(6, 11))
        for size in range(1, 6):
            assert relative(J, size).min() <= best_possible(11, 6, size) + 1e-12
    assert best_possible(7, 6, 2) == 0.0


def test_a_planar_arm_solved_by_hand():
    report = sr.tolerance.report(three(), TRIANGLE, task=PLANE)
    np.testing.assert_allclose(report.relative[0], 0.5773503, atol=5e-8)
    assert report.speed == pytest.approx(1.7320508, abs=5e-8)
    np.testing.assert_allclose(report.speeds[0], 0.8660254, atol=5e-8)
    np.testing.assert_array_equal(report.speeds[1], 0.0)
    assert report.speed_after({"j2": sr.Derated(0.5)}) == pytest.approx(1.2990381, abs=5e-8)
    assert report.depth == 1
    assert report.critical == ()
    assert report.relative_to(["j2"]) == pytest.approx(1.0 / sqrt(3.0))
    np.testing.assert_allclose(report.jump([1.0, 0.0, -2.0]), [sqrt(3.0), 0.0, 2.0 * sqrt(3.0)])


def test_columns_solved_by_hand():
    J = columns([0, 45, 90, 135], sqrt(0.5))
    pairs = relative(J, 2)
    assert pairs.min() == pytest.approx(0.353553, abs=5e-7)
    np.testing.assert_allclose(np.sort(pairs), [0.353553] * 4 + [0.5] * 2, atol=5e-7)
    golden = (1.0 + sqrt(5.0)) / 2.0
    diagonals = np.array(
        [[0, 1, golden], [0, -1, golden], [1, golden, 0], [-1, golden, 0], [golden, 0, 1], [golden, 0, -1]]
    )
    icosahedron = (diagonals / np.linalg.norm(diagonals, axis=1)[:, None]).T
    two = failure_sets(range(6), 2)
    whole = sqrt(np.linalg.det(icosahedron @ icosahedron.T))
    expected = [manipulability(np.delete(icosahedron, own, axis=1)) / whole for own in two]
    found = without(null_basis(icosahedron), two)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    np.testing.assert_allclose(found, 0.4472136, atol=5e-8)


def hull(J, lower, upper):
    """The distance from 0 to the nearest facet of the velocities, by their corners."""
    corners = np.array([J @ np.where(side, upper, lower) for side in np.ndindex(*[2] * J.shape[1])])
    return float(np.min(-ConvexHull(corners).equations[:, -1]))


@pytest.mark.parametrize(("m", "n"), [(2, 3), (2, 6), (3, 4), (3, 7), (4, 6)])
def test_the_guaranteed_speed_is_that_of_the_convex_hull(m, n):
    rng = np.random.default_rng(10 * m + n)
    for _ in range(10):
        J, lower, upper = rng.normal(size=(m, n)), -rng.uniform(0.2, 1, n), rng.uniform(0.2, 1, n)
        facets, exact = normals(J)
        assert exact
        assert guaranteed(J, facets, lower, upper) == pytest.approx(hull(J, lower, upper), rel=1e-9)
        for lost in range(n):  # the normals of all columns do for fewer
            moving = np.arange(n) != lost
            expected = hull(J[:, moving], lower[moving], upper[moving]) if n - 1 >= m else 0.0
            found = guaranteed(J, facets, lower * moving, upper * moving)
            assert found == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_long_arms_get_an_upper_bound_that_says_so():
    """Of 17 joints 5,000 normals are looked at; the distance to the nearest of all facets is no larger."""
    rng = np.random.default_rng(0)
    for _ in range(3):
        J, ones = rng.normal(size=(6, 17)), np.ones(17)
        facets, exact = normals(J)
        assert not exact
        subsets = np.array(list(combinations(range(17), 5)))
        every = np.linalg.svd(J.T[subsets], full_matrices=True)[2][:, -1]
        nearest = float(np.min(np.abs(every @ J).sum(axis=1)))
        bound = float(guaranteed(J, facets, -ones, ones))
        assert nearest <= bound * (1.0 + 1e-9)
        assert bound < 2.0 * nearest
    snake = sr.arms.snake(30)
    report = sr.tolerance.report(snake, np.full(snake.n, 0.1), k=1)
    assert not report.exact
    assert "an upper bound" in str(report)


def test_speed_along_a_direction_is_that_of_a_linear_program():
    report = sr.tolerance.report(PANDA, BENT, k=1)
    J, limits = PANDA.jacobian(BENT), PANDA.velocity_limits
    rng = np.random.default_rng(5)
    for _ in range(20):
        direction = rng.normal(size=6)
        direction /= np.linalg.norm(direction)
        for lost in (None, 0, 3):
            rates = limits * (np.arange(7) != lost)
            equal = np.hstack([J, -direction[:, None]])
            answer = linprog([*np.zeros(7), -1.0], A_eq=equal, b_eq=np.zeros(6),
                             bounds=[*zip(-rates, rates, strict=True), (0, None)])  # fmt: skip
            faults = {} if lost is None else {lost: sr.Locked()}
            assert report.speed_along(direction, faults) == pytest.approx(answer.x[-1], rel=1e-7, abs=1e-9)
    up = [0, 0, 1, 0, 0, 0]
    half = report.speed_along(up, dict.fromkeys(PANDA.joint_names, sr.Derated(0.5)))
    assert half == pytest.approx(0.5 * report.speed_along(up), rel=1e-9)
    forwards, backwards = (
        report.speed_along(up, dict.fromkeys(PANDA.joint_names, sr.OneWay(sign))) for sign in (1, -1)
    )
    assert max(forwards, backwards) <= report.speed_along(up)


def spherical_revolute_spherical():
    """An exact arm of three joints that meet, one, and three that meet."""
    axes = ["z", "y", "z", "y", "z", "y", "z"]
    offsets = [0.3, 0.0, 0.0, 0.4, 0.0, 0.4, 0.0]
    unit = {"y": [0, 1, 0], "z": [0, 0, 1]}
    joints = []
    for k, (axis, offset) in enumerate(zip(axes, offsets, strict=True)):
        placement = np.eye(4)
        placement[2, 3] = offset
        joints.append(sr.Joint(name=f"j{k + 1}", axis=unit[axis], placement=placement, velocity_limit=1.0))
    tool = np.eye(4)
    tool[2, 3] = 0.1
    return sr.Arm(joints, tool=tool)


def test_a_spherical_arm_cannot_lose_its_elbow_in_any_pose():
    arm, rng, singular = spherical_revolute_spherical(), np.random.default_rng(0), 0
    for q in rng.uniform(-2.5, 2.5, (1000, 7)):
        assert relative(arm.jacobian(q), 1)[3] < 1e-10
        report = sr.tolerance.report(arm, q, k=1)
        if report.rank < 6:  # by gain: some direction moves at less than 1 mm/s or 0.1 deg/s
            singular += 1
            assert report.verdict.startswith("The arm is already singular here")
            continue
        assert report.relative[0][3] < 1e-10
        assert "j4" in report.critical
        (lost,) = report.lost_directions(["j4"])
        weakest, left = report.weakest_direction(["j4"])
        assert abs(weakest @ lost) > 1.0 - 1e-9
        assert left < 1e-10
    assert singular < 5


@pytest.mark.parametrize("name", ["iiwa14", "xarm7", "gen3"])
def test_rounded_files_of_such_arms_get_the_same_verdict(name):
    arm = sr.arms.by_name(name)
    q = np.deg2rad([20, 40, 30, 80, 20, 60, 10])
    report = sr.tolerance.report(arm, q)
    elbow = arm.joint_names[3]
    assert elbow in report.critical
    assert report.worst()[0] == (elbow,)
    assert f"{elbow} (" in report.verdict
    assert report.worst()[1] < {"iiwa14": 1e-3, "xarm7": 0.1, "gen3": 0.02}[name]  # the offsets of their elbows
    weakest, left = report.weakest_direction([elbow])
    assert left == pytest.approx(report.worst()[1], rel=1e-6, abs=1e-12)
    J = arm.jacobian(q)
    assert np.linalg.norm(weakest @ np.delete(J, 3, axis=1)) == pytest.approx(
        left * np.linalg.norm(weakest @ J), abs=1e-9
    )
    word = "(" if name == "iiwa14" else "remaining, least of"
    assert f"{word} {direction(weakest, range(6), signed=False)}".replace("( ", "(") in report.verdict


@pytest.mark.parametrize("joints", [["j2"], ["j3", "j8"], ["j1", "j5", "j11"]])
def test_no_direction_suffers_more_than_the_weakest(joints):
    arm, q = sr.arms.nasa_modular(), np.linspace(0.1, 1.1, 11)
    weakest, left = sr.tolerance.report(arm, q, k=3).weakest_direction(joints)
    J = arm.jacobian(q)
    rest = np.delete(J, [arm.joint_index(joint) for joint in joints], axis=1)
    near = weakest + np.random.default_rng(2).normal(size=(2000, 6)) * np.logspace(-6, 1, 2000)[:, None]
    others = np.linalg.norm(near @ rest, axis=1) / np.linalg.norm(near @ J, axis=1)
    assert np.linalg.norm(weakest @ rest) / np.linalg.norm(weakest @ J) == pytest.approx(left, rel=1e-12)
    assert others.min() > left * (1.0 - 1e-12)


def test_canadarm2_with_joint_2_at_a_right_angle_is_singular_without_it():
    """Crane, Duffy and Carnahan, 1991."""
    arm, rng = sr.arms.canadarm2(), np.random.default_rng(0)
    for q in rng.uniform(-2.5, 2.5, (50, 7)):
        q[1] = np.pi / 2.0 * rng.choice([-1, 1])
        assert np.linalg.svd(np.delete(arm.jacobian(q), 1, axis=1), compute_uv=False)[-1] < 1e-12
        report = sr.tolerance.report(arm, q, k=1)
        assert report.rank < 6 or arm.joint_names[1] in report.critical


def test_what_is_lost_already_counts():
    first = sr.tolerance.report(PANDA, BENT, k=2)
    then = sr.tolerance.report(PANDA, BENT, k=1, failed=["panda_joint1"], task=sr.Task(rows="position"))
    assert then.working == (1, 2, 3, 4, 5, 6)
    J = PANDA.jacobian(BENT)[:3, 1:]
    np.testing.assert_allclose(then.relative[0], relative(J, 1), atol=1e-12)
    assert first.loses[1].all()  # seven joints, six rows: no two can go
    assert first.depth == 1
    assert "panda_joint1" not in then.critical
    assert str(first)
    assert repr(first).startswith("<Report of panda: panda_joint4 leaves 3 %")


def test_the_losses_of_an_arm_are_those_of_the_report():
    losses, report = PANDA.losses(BENT), sr.tolerance.report(PANDA, BENT, k=1)
    np.testing.assert_allclose(losses.remaining, report.relative[0], atol=1e-12)


def test_a_singular_pose_is_said():
    report = sr.tolerance.report(three(), [0.3, 0.0, 0.0], task=PLANE)
    assert report.rank == 1
    assert report.verdict.startswith("The arm is already singular here: it moves its tool in 1 of 2 directions")
    assert report.speed == 0.0


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"k": 0}, "k: got 0"),
        ({"k": 8}, "k: got 8, expected at most the 7 joints"),
        ({"q": [0.0]}, "q: got"),
        ({"arm": 3}, "arm: got 3"),
        ({"below": -1}, "below: got -1"),
        ({"failed": ["j1"]}, "joint: got 'j1'"),
    ],
)
def test_mistakes(options, said):
    with pytest.raises(InputError, match=said):
        sr.tolerance.report(**{"arm": PANDA, "q": BENT, **options})


def test_mistakes_of_the_questions():
    report = sr.tolerance.report(PANDA, BENT, k=2)
    with pytest.raises(InputError, match=r"joints: got .*expected 1 to 2 of the joints"):
        report.relative_to([0, 1, 2])
    with pytest.raises(InputError, match="size: got 3, expected at most 2"):
        report.worst(3)
    with pytest.raises(InputError, match=r"faults: got .*expected faults that leave 0"):
        report.speed_after({0: sr.Runaway(0.1)})
    with pytest.raises(InputError, match="faults: got"):
        report.speed_after({0: 3})
    with pytest.raises(InputError, match="twist: got"):
        report.speed_along([0.0] * 6)
    with pytest.raises(UnknownJointError):
        report.speed_after({"x": sr.Locked()})
