"""The failure-tolerant workspace of a planar arm, solved by hand."""

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError

PLANE = sr.Task(rows=(True, True, False, False, False, False))
ARM = sr.arms.planar(3)
LIMITS = {"j2": np.deg2rad([90.0, 120.0]), "j3": np.deg2rad([90.0, 120.0])}
INNER = np.sqrt(2.0) - 1.0


def disc(count, radius, seed=0):
    rng = np.random.default_rng(seed)
    r, a = radius * np.sqrt(rng.uniform(0, 1, count)), rng.uniform(-np.pi, np.pi, count)
    return np.column_stack([r * np.cos(a), r * np.sin(a), np.zeros(count)]), r


def test_it_is_the_annulus_that_is_known():
    """Unit links, joint 1 free, joints 2 and 3 within 90 to 120 deg before the failure: sqrt(2) - 1 <= r <= 1."""
    points, r = disc(4000, 1.3)
    found = sr.tolerance.workspace(ARM, points, LIMITS, joints=["j2", "j3"], task=PLANE)
    clear = np.minimum(np.abs(r - INNER), np.abs(r - 1.0)) > 1e-3
    np.testing.assert_array_equal(found.tolerant[clear], ((r > INNER) & (r < 1.0))[clear])
    area = found.share * np.pi * 1.3**2
    assert area == pytest.approx(2.602581, rel=0.04)  # of 4,000 random points
    assert found.joints == (1, 2)
    assert found.after[:, 0].sum() == found.before.sum()


def test_before_a_failure_only_the_artificial_limits_count():
    points, r = disc(2000, 2.2, seed=1)
    found = sr.tolerance.workspace(ARM, points, LIMITS, joints=["j2", "j3"], task=PLANE)
    bends = np.deg2rad(np.linspace(90, 120, 200))
    two, three = np.meshgrid(bends, bends)
    reach = np.abs(1.0 + np.exp(1j * two) + np.exp(1j * (two + three)))
    clear = np.minimum(np.abs(r - reach.min()), np.abs(r - reach.max())) > 0.01
    np.testing.assert_array_equal(found.before[clear], ((r > reach.min()) & (r < reach.max()))[clear])


def test_better_limits_are_found():
    points, _ = disc(120, 1.3, seed=2)
    given = sr.tolerance.workspace(ARM, points, LIMITS, joints=["j2", "j3"], task=PLANE, angles=5)
    found = sr.tolerance.best_limits(ARM, points, joints=["j2", "j3"], task=PLANE, steps=6, rounds=2)
    assert found.share >= given.share - 0.05
    wide = sr.tolerance.workspace(ARM, points, np.full((3, 2), [-np.pi, np.pi]), task=PLANE, angles=5)
    assert found.share > wide.share
    assert np.isfinite(found.limits[1:]).all()


def test_poses_of_a_panda():
    arm = sr.arms.panda()
    rng = np.random.default_rng(3)
    q = rng.uniform(*(0.4 * arm.position_limits.T + 0.6 * arm.position_limits.mean(axis=1)), (40, 7))
    found = sr.tolerance.workspace(arm, arm.forward(q), joints=["panda_joint1"], angles=3)
    assert found.before.all()
    assert not found.after[:, 0].all()
    for place in range(5):
        for at in np.linspace(*arm.position_limits[0], 3):
            one = arm.inverse(arm.forward(q[place]), locked={"panda_joint1": at}, starts=30, seed=1994)
            if not one.reached:
                assert not found.after[place, 0]


def test_the_annulus_on_a_grid():
    """The same annulus, sampled every 50 mm: its area is right up to cells at its two edges."""
    found = sr.tolerance.workspace(ARM, None, LIMITS, joints=["j2", "j3"], task=PLANE, spacing=0.05, angles=3)
    r = np.linalg.norm(found.poses[:, :2, 3], axis=1)
    clear = np.minimum(np.abs(r - INNER), np.abs(r - 1.0)) > 1e-6
    np.testing.assert_array_equal(found.tolerant[clear], ((r > INNER) & (r < 1.0))[clear])
    edge = 2 * np.pi * (1.0 + INNER)
    assert abs(found.size - 2.602581) < 0.25 * edge * 0.05
    steps = found.poses[:, :2, 3] / 0.05
    np.testing.assert_allclose(steps, steps.round(), atol=1e-9)
    assert len(np.unique(steps.round(), axis=0)) == len(steps)
    assert "on a grid of 50 mm" in str(found)


def test_two_failures_of_four_links():
    """Unit links, joint 1 free, the others within 60 to 90 deg: exactly 1 <= r <= sqrt(3).

    Before, r is largest with all at 60 deg. With joints 3 and 4 locked, or 2 and 3, a link of 1 and one of
    L = |1 + exp(ia) + exp(i(a + b))| from 1 to 2 are left: |1 - L| <= r <= 1 + L. With 2 and 4, two of sqrt(2) to
    sqrt(3). After one failure alone, smaller distances are reached as well.
    """
    arm, limits = sr.arms.planar(4), {name: np.deg2rad([60.0, 90.0]) for name in ("j2", "j3", "j4")}
    a, b, c = np.meshgrid(*[np.deg2rad(np.linspace(60, 90, 31))] * 3)
    before = np.abs(1 + np.exp(1j * a) + np.exp(1j * (a + b)) + np.exp(1j * (a + b + c)))
    assert (before.min(), before.max()) == (pytest.approx(0.0, abs=1e-12), pytest.approx(np.sqrt(3.0)))
    given = {"joints": list(limits), "task": PLANE, "spacing": 0.11, "angles": 3}
    found = sr.tolerance.workspace(arm, None, limits, failures=2, **given)
    r = np.linalg.norm(found.poses[:, :2, 3], axis=1)
    clear = np.minimum(np.abs(r - 1.0), np.abs(r - np.sqrt(3.0))) > 1e-6
    np.testing.assert_array_equal(found.tolerant[clear], ((r > 1.0) & (r < np.sqrt(3.0)))[clear])
    one = sr.tolerance.workspace(arm, None, limits, **given)
    assert one.pairs is None
    np.testing.assert_array_equal(one.after, found.after)
    assert (one.tolerant >= found.tolerant).all()
    assert one.tolerant.sum() > found.tolerant.sum()
    assert found.pairs is not None
    np.testing.assert_array_equal(found.pairs, np.swapaxes(found.pairs, 1, 2))
    assert "any two joints" in str(found)


def test_two_failures_leave_less_than_both_alone():
    """A Panda's poses, each pair judged by its own inverse kinematics."""
    arm = sr.arms.panda()
    limits = arm.position_limits.mean(axis=1)[:, None] + np.array([-0.3, 0.3])
    q = np.random.default_rng(3).uniform(*limits.T, (30, 7))
    chosen = ["panda_joint3", "panda_joint5"]
    place = sr.Task(rows="position")
    found = sr.tolerance.workspace(arm, arm.forward(q), limits, joints=chosen, task=place, failures=2, angles=2)
    for row, pose in enumerate(arm.forward(q)):
        both = [
            arm.inverse(pose, locked={2: x, 4: y}, task=place, starts=100, seed=7).reached
            for x in limits[2]
            for y in limits[4]
        ]
        assert found.pairs[row, 2, 4] == (found.before[row] and all(both))


def column_arm(J):
    """The arm with the columns (v, w) of revolute joints at zero, its tool at the origin."""
    v, w = J[:3].T, J[3:].T
    places = np.vstack([np.zeros(3), np.cross(w, v), np.zeros(3)])
    moves = np.tile(np.eye(4), (8, 1, 1))
    moves[:, :3, 3] = np.diff(places, axis=0)
    return sr.Arm([sr.Joint(placement=T, axis=axis) for T, axis in zip(moves[:7], w, strict=True)], tool=moves[7])


def test_columns_in_another_order():
    """Arms of the same columns lose the same at zero; the reverse order has the workspace mirrored at the origin."""
    random = np.random.default_rng(2)
    w = random.normal(size=(3, 7))
    w /= np.linalg.norm(w, axis=0)
    J = np.vstack([np.cross(random.normal(size=(7, 3)), w.T).T, w])
    order = random.permutation(7)
    arm, reverse = column_arm(J[:, order]), column_arm(J[:, order[::-1]])
    np.testing.assert_allclose(arm.jacobian(np.zeros(7)), J[:, order], atol=1e-12)
    null = np.linalg.svd(J)[2][6]
    for each, columns in ((arm, order), (reverse, order[::-1])):
        local = sr.tolerance.report(each, np.zeros(7), k=1).relative[0]
        np.testing.assert_allclose(local, np.abs(null[columns]), atol=1e-9)
    poses = np.tile(np.eye(4), (25, 1, 1))
    poses[:, :3, 3] = random.uniform(-0.8, 0.8, (25, 3))
    mirrored = poses.copy()
    mirrored[:, :3, 3] *= -1.0
    given = {"limits": np.tile([-0.7, 0.7], (7, 1)), "angles": 2, "starts": 100}
    found = sr.tolerance.workspace(arm, poses, **given).tolerant
    np.testing.assert_array_equal(sr.tolerance.workspace(reverse, mirrored, **given).tolerant, found)
    assert 0 < found.sum() < 25


def test_a_picture():
    pytest.importorskip("matplotlib").use("agg")
    points, _ = disc(50, 1.3)
    figure = sr.tolerance.workspace(ARM, points, LIMITS, joints=["j2"], task=PLANE, angles=2).plot()
    assert len(figure.axes) == 2
    assert "tolerant" in figure._suptitle.get_text()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"poses": [[1.0, 2.0]]}, "poses: got"),
        ({"limits": [[0.0, 1.0]]}, "limits: got"),
        ({"limits": {"j2": (1.0, 0.0)}}, r"limits: got \[1.0, 0.0\] for j2"),
        ({"joints": ["j1"]}, "joints: got j1, whose limits are endless"),
        ({"angles": 0}, "angles: got 0"),
        ({"failures": 3}, "failures: got 3, expected 1 or 2"),
        ({"spacing": 0.1}, "spacing: got poses, too"),
        ({"spacing": 0.0, "poses": None}, "spacing: got 0.0"),
        ({"spacing": 1e-9, "poses": None}, "spacing: got 1e-09 m, "),
        ({"spacing": 0.1, "poses": None, "task": sr.Task()}, "task: got rows"),
        ({"poses": None}, "poses: got None"),
        ({"joints": ["x"]}, "joint: got 'x'"),
    ],
)
def test_mistakes(options, said):
    with pytest.raises(InputError, match=said):
        sr.tolerance.workspace(**{"arm": ARM, "poses": [[1.0, 0.0, 0.0]], "limits": LIMITS, "task": PLANE, **options})
