"""Kinematics of many configurations at once: poses, Jacobians, singular values, manipulability."""

import math

import numpy as np
import pytest

import stillreach as sr
from stillreach.errors import InputError, UnknownJointError
from tests.unit.arm.odd_arms import ODD_ARMS, configurations, placement

EVERY_ARM = pytest.mark.parametrize("arm", ODD_ARMS)
PAPER = sr.arms.nasa_modular()


def some(arm, count, seed=0):
    """(count, n) the bad places first, then others."""
    rng = np.random.default_rng(seed)
    return np.concatenate([configurations(arm.n), rng.uniform(-np.pi, np.pi, (count, arm.n))])[:count]


def equal(one, other):
    return one.shape == other.shape and np.array_equal(one.view(np.int64), other.view(np.int64))


@EVERY_ARM
def test_many_have_the_bits_of_one(arm):
    """A controller's tick has its Jacobian from the function for one configuration."""
    arm = ODD_ARMS[arm]()
    q = some(arm, 23)
    poses, jacobians = arm.forward(q), arm.jacobian(q)
    controller = sr.Controller(arm, velocity_limits=1.0)
    for i in range(len(q)):
        answer = controller.step(q[i], np.zeros(6))
        assert np.array_equal(jacobians[i], answer.jacobian)
        assert equal(arm.jacobian(q[i]), jacobians[i])
        assert equal(arm.forward(q[i]), poses[i])


@pytest.mark.parametrize("count", [0, 1, 3, 4, 5, 63, 64, 65, 511, 513, 1000])
def test_any_number_on_any_number_of_threads(count, monkeypatch):
    q = some(PAPER, count, seed=count)
    task = sr.Task(rows="position")
    answers = []
    for threads in ("1", "2", "5"):
        monkeypatch.setenv("STILLREACH_THREADS", threads)
        answers.append((PAPER.forward(q), PAPER.jacobian(q), PAPER.singular_values(q, task), PAPER.manipulability(q)))
    for one, *others in zip(*answers, strict=True):
        assert len(one) == count
        assert all(equal(one, other) for other in others)
    if count:
        assert equal(answers[0][0][-1], PAPER.forward(q[-1]))
        assert equal(answers[0][2][-1], PAPER.singular_values(q[-1], task))


@pytest.mark.parametrize("leading", [(), (0,), (1,), (2, 3), (2, 0, 4), (1, 1, 1, 5)])
def test_leading_axes_stay(leading):
    q = np.random.default_rng(1).normal(size=(*leading, 11))
    assert PAPER.forward(q).shape == (*leading, 4, 4)
    assert PAPER.jacobian(q).shape == (*leading, 6, 11)
    assert PAPER.singular_values(q).shape == (*leading, 6)
    assert PAPER.singular_values(q, sr.Task(rows="position"), joints=[0, 5]).shape == (*leading, 2)
    assert PAPER.manipulability(q).shape == leading
    assert isinstance(PAPER.manipulability(q), np.ndarray)


def svd(J):
    return np.linalg.svd(J, compute_uv=False)


@EVERY_ARM
@pytest.mark.parametrize("rows", ["pose", "position", "orientation", (True, False, True, False, False, True)])
def test_singular_values_are_numpys(arm, rows):
    arm, task = ODD_ARMS[arm](), sr.Task(rows=rows)
    q = some(arm, 30)
    J = arm.jacobian(q)[:, list(task.indices)]
    expected = svd(J)
    got = arm.singular_values(q, task)
    assert got.shape == expected.shape == (30, min(task.m, arm.n))
    assert np.all(np.diff(got) <= 0.0)
    assert np.all(np.abs(got - expected) <= 1e-13 * np.maximum(expected[:, :1], 1e-300))
    assert np.array_equal(got, arm.singular_values(q, task, joints=arm.joint_names))


@EVERY_ARM
def test_manipulability_is_the_root_of_the_determinant(arm):
    arm = ODD_ARMS[arm]()
    q = np.random.default_rng(2).uniform(-2, 2, (30, arm.n))
    for rows in ("pose", "position"):
        task = sr.Task(rows=rows)
        J = arm.jacobian(q)[:, list(task.indices)]
        gram = np.linalg.det(J @ np.swapaxes(J, 1, 2))
        size = np.prod(np.maximum(np.sum(J * J, axis=2), 1e-300), axis=1)  # Hadamard: the determinant is at most this
        assert np.all(np.abs(arm.manipulability(q, task) ** 2 - gram) <= 1e-13 * size)


def test_a_small_value_keeps_its_digits():
    """Two unit links: det J = sin(q2), so the product of the singular values is its magnitude, however small."""
    arm, task = sr.arms.planar(2), sr.Task(rows=(True, True, False, False, False, False))
    for angle in 10.0 ** np.arange(-14.0, 0.0):
        q = np.array([0.7, angle])
        x, y = math.cos(0.7) + math.cos(0.7 + angle), math.sin(0.7) + math.sin(0.7 + angle)
        largest = svd(np.array([[-y, -math.sin(0.7 + angle)], [x, math.cos(0.7 + angle)]]))[0]
        rounding = 1e-15 / angle  # two units in the last place of the largest value, √5
        assert abs(arm.manipulability(q, task) / math.sin(angle) - 1.0) <= rounding + 1e-14
        assert abs(arm.singular_values(q, task)[1] * largest / math.sin(angle) - 1.0) <= rounding + 1e-14


def full(size, seed):
    a = np.random.default_rng(seed).normal(size=(size, size))
    return a @ a.T + 0.3 * np.eye(size)


WEIGHTS = {
    "units": {"length": 0.0254, "angle": np.deg2rad(1)},
    "W1": {"task": full(6, 1)},
    "W1 vector": {"task": [1.0, 2.0, 3.0, 0.1, 0.2, 0.5]},
    "W2 vector": {"joints": np.linspace(0.2, 3.0, 7)},
    "W2": {"joints": full(7, 2)},
    "all": {"length": 0.3, "angle": 2.0, "task": full(6, 3), "joints": full(7, 4)},
}


@pytest.mark.parametrize("joints", [None, (6, 0, 2, 3, 5, 4), (1, 3, 4)])
@pytest.mark.parametrize("weights", WEIGHTS)
def test_weights_units_joints_and_the_tools_axes(weights, joints):
    """W1^(1/2) J W2^(-1/2) of the working joints, in the units' multiples, along the axes of the tool."""
    rng = np.random.default_rng(3)
    slides = [sr.Joint(name="slide", kind="prismatic", axis=(1, 2, 3)), *sr.arms.canadarm2().joints[:6]]
    arm, given = sr.Arm(slides, tool=placement((0.1, 0.2, 0.3))), WEIGHTS[weights]
    point = placement((0.3, 0.0, -0.1), (1, 2, 3), 1.1)
    task = sr.Task(frame="tool", tool=point, weights=sr.Weights(**given))
    length, angle = given.get("length", 1.0), given.get("angle", 1.0)
    W1, W2 = (
        np.diag(w) if np.ndim(w) == 1 else np.asarray(w)
        for w in (given.get("task", np.ones(6)), given.get("joints", np.ones(7)))
    )
    working = list(range(7) if joints is None else joints)
    q = rng.uniform(-2, 2, (10, 7))
    values, product = arm.singular_values(q, task, joints=joints), arm.manipulability(q, task, joints=joints)
    moved = arm.with_tool(arm.tool @ point)
    for i in range(10):
        R = moved.forward(q[i])[:3, :3]
        J = np.kron(np.eye(2), R.T) @ moved.jacobian(q[i]) / np.repeat([length, angle], 3)[:, None]
        J = (J * np.where(np.arange(7) == 0, length, angle))[:, working]
        weighted = np.linalg.cholesky(W1).T @ J @ np.linalg.inv(np.linalg.cholesky(W2[np.ix_(working, working)])).T
        expected = svd(weighted)
        assert np.all(np.abs(values[i] - expected) <= 1e-12 * expected[0])
        assert abs(product[i] - (np.prod(expected) if len(working) >= 6 else 0.0)) <= 1e-12 * expected[0] ** 6


def test_failed_joints_are_left_out():
    q = np.random.default_rng(4).uniform(-2, 2, (20, 11))
    J = PAPER.jacobian(q)
    names = [name for i, name in enumerate(PAPER.joint_names) if i not in (1, 3, 6)]
    kept = np.delete(J, [1, 3, 6], axis=2)
    assert np.allclose(PAPER.singular_values(q, joints=names), svd(kept), rtol=1e-12, atol=1e-13)
    assert np.allclose(PAPER.manipulability(q, joints=names), np.prod(svd(kept), axis=1), rtol=1e-10, atol=1e-14)
    assert np.all(PAPER.manipulability(q, joints=names) <= PAPER.manipulability(q) * (1 + 1e-12))
    assert np.all(PAPER.manipulability(q, joints=names[:5]) == 0.0)
    assert PAPER.singular_values(q, joints=[]).shape == (20, 0)
    assert np.all(PAPER.manipulability(q, joints=[]) == 0.0)


def test_huge_and_tiny_units():
    q = np.random.default_rng(5).uniform(-2, 2, (5, 11))
    one = PAPER.singular_values(q)
    for unit in (1e-90, 1e90):
        same = PAPER.singular_values(q, sr.Task(weights=sr.Weights(task=np.full(6, unit**2))))
        assert np.allclose(same / unit, one, rtol=1e-12)


WRONG = [
    ("q", np.zeros(10), {}),
    ("q", np.full(11, np.nan), {}),
    ("q", "0.1", {}),
    ("q", np.full((2, 11), True), {}),
    ("q", 1.0, {}),
    ("task", np.zeros(11), {"task": "pose"}),
    ("task", np.zeros(11), {"task": (True,) * 6}),
    ("joints", np.zeros(11), {"joints": "j1"}),
    ("joints", np.zeros(11), {"joints": 3}),
    ("joints", np.zeros(11), {"joints": [0, "j1"]}),
    ("weights.joints", np.zeros(11), {"task": sr.Task(weights=sr.Weights(joints=np.ones(3)))}),
]


@pytest.mark.parametrize("ask", [PAPER.singular_values, PAPER.manipulability])
@pytest.mark.parametrize(("argument", "q", "others"), WRONG)
def test_a_wrong_argument_is_named(ask, argument, q, others):
    with pytest.raises(InputError) as caught:
        ask(q, **others)
    assert caught.value.argument == argument
    for joints in ([11], ["j12"], [-1], [1.5]):
        with pytest.raises(UnknownJointError):
            ask(np.zeros(11), joints=joints)
