"""Poses that are rigid up to single precision or a few decimals count as the nearest rigid transform, at every door."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import stillreach as sr
from tests.unit.control.robots import TWIST, configuration, paper, refused, skew

ROUNDED = {
    "float32": lambda T: np.float32(T),
    "six decimals": lambda T: T.round(6),
    "five decimals": lambda T: T.round(5),
    "list of six decimals": lambda T: T.round(6).tolist(),
    "last row": lambda T: T + np.diag([0, 0, 0, 1e-12]) + np.outer([0, 0, 0, 1], [1e-12, 0, 0, 0]),
}
EVERY_ROUNDING = pytest.mark.parametrize("rounding", ROUNDED.values(), ids=ROUNDED)


def poses(count, seed=0):
    """Random poses within a metre."""
    rng = np.random.default_rng(seed)
    out = np.tile(np.eye(4), (count, 1, 1))
    out[:, :3, :3] = Rotation.random(count, rng=rng).as_matrix()
    out[:, :3, 3] = rng.uniform(-1, 1, (count, 3))
    return out


def nearest(T):
    """The nearest rigid transform (Schönemann, 1966): R = U V' of the singular value decomposition."""
    T = np.array(T, dtype=float)
    U, _, V = np.linalg.svd(T[:3, :3])
    T[:3, :3] = U @ V
    T[3] = (0, 0, 0, 1)
    return T


DOORS = {
    "placement of a joint": lambda T: sr.Joint(placement=T).placement,
    "tool of an arm": lambda T: sr.Arm([sr.Joint()], tool=T).tool,
    "with_tool": lambda T: paper().with_tool(T).tool,
    "base of a table": lambda T: sr.Arm.from_dh([sr.DHRow(a=0, alpha=0, d=0)], base=T).forward([0.0]),
    "tool of a table": lambda T: sr.Arm.from_dh([sr.DHRow(a=0, alpha=0, d=0)], tool=T).forward([0.0]),
    "tool of a task": lambda T: sr.Task(tool=T).tool,
    "line": lambda T: turn_of(T, sr.Line(orientation=np.array(T)[:3, :3], duration=1.0).orientation),
    "waypoints": lambda T: turn_of(
        T, sr.Waypoints([[0, 0, 0]], orientations=[np.array(T)[:3, :3]], times=[1]).orientations[0]
    ),
    "pose table": lambda T: turn_of(
        T, sr.PoseTable([1], [[0, 0, 0]], orientations=np.array(T)[None, :3, :3]).orientations[0]
    ),
}


def turn_of(T, R):
    """The translation of a given pose with the rotation that came of it."""
    out = nearest(T)
    out[:3, :3] = R
    return out


@EVERY_ROUNDING
@pytest.mark.parametrize("door", DOORS)
def test_a_rounded_pose_is_taken_as_the_nearest_rigid_one(door, rounding):
    for T in poses(20):
        got = DOORS[door](rounding(T))
        np.testing.assert_allclose(got, nearest(rounding(T)), rtol=0, atol=2e-14)
        np.testing.assert_allclose(got[:3, :3] @ got[:3, :3].T, np.eye(3), rtol=0, atol=2e-14)


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize(
    "spoil", [lambda T: T + 1e-4 * np.diag([1, 0, 0, 0]), lambda T: T * [1, 1, -1, 1], lambda T: T.round(3)]
)
def test_what_is_no_rotation_is_refused(door, spoil):
    for T in poses(5, seed=1):
        with pytest.raises(sr.InputError):
            DOORS[door](spoil(T))


@EVERY_ROUNDING
def test_a_rounded_target_is_tracked_like_the_nearest_rigid_one(rounding):
    arm = paper()
    for T in poses(20, seed=2):
        a, b, c = (sr.Controller(arm) for _ in range(3))
        expected = a.track(np.zeros(11), nearest(rounding(T)), feedforward=TWIST)
        np.testing.assert_allclose(
            b.track(np.zeros(11), rounding(T), feedforward=TWIST).twist, expected.twist, atol=1e-13
        )
        rates = np.zeros(11)
        target = np.array(rounding(T), dtype=float)
        status = c.bind(q=np.zeros(11), twist=TWIST, rates=rates, target=target)()
        assert status == expected.status
        np.testing.assert_allclose(rates, expected.rates, atol=1e-9)


def test_a_pose_that_is_rigid_keeps_its_bits():
    arm = skew()
    for seed in range(20):
        T = arm.forward(configuration(arm, seed))
        np.testing.assert_array_equal(sr.Task(tool=T).tool, T)


@pytest.mark.parametrize("spoil", [1e-4, np.nan, np.inf, 1e200])
def test_a_bound_loop_brakes_where_its_target_is_no_pose(spoil):
    rates, target = np.zeros(11), np.eye(4)
    tick = sr.Controller(paper()).bind(q=np.zeros(11), twist=TWIST, rates=rates, target=target)
    assert not tick() & sr.Status.INVALID_INPUT
    target[0, 0] += spoil
    assert tick() & sr.Status.INVALID_INPUT
    assert not rates.any()


def test_an_array_and_a_list_of_one_pose_have_one_answer():
    T = np.eye(4)
    for off in (1e-12, 1e-6, 0.99e-5, 1.01e-5, 1e-3):
        T[3, 2] = off
        for form in (np.array, np.ndarray.tolist):
            if off > 1e-5:
                refused(
                    lambda form=form: sr.Controller(paper()).track(np.zeros(11), form(T)), "target_pose", "last row"
                )
            else:
                sr.Controller(paper()).track(np.zeros(11), form(T))


def test_a_rounded_table_of_targets_runs():
    arm = paper()
    start = np.deg2rad([0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0])
    goal = np.float32(arm.forward(start + 0.02))
    table = sr.PoseTable([1.0], goal[None, :3, 3], orientations=goal[None, :3, :3])
    run = sr.simulate(sr.Scenario(arm=arm, start=start, motion=table, loop="closed", duration=3.0))
    np.testing.assert_allclose(run.pose[-1], nearest(goal), atol=1e-5)
