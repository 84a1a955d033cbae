"""Tasks: which rows, along whose axes, at which point, in which weights."""

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.odd_arms import placement
from tests.unit.control.robots import Q_PAPER, TWIST, configuration, mixed, paper, refused, skew

FIVE_AXIS = (True, True, True, True, True, False)
ROWS = {
    "pose": [0, 1, 2, 3, 4, 5],
    "position": [0, 1, 2],
    "orientation": [3, 4, 5],
    FIVE_AXIS: [0, 1, 2, 3, 4],
    (False, True, False, True, False, True): [1, 3, 5],
    (False, False, False, False, False, True): [5],
}
EXACT = sr.LeastError(price=None)
TOOL = placement((0.05, -0.3, 0.2), (1, -1, 2), 0.9)


def rows_by_hand(arm, q, twist, rows, frame):
    """J and twist (m,) of a task: rotated into the tool's axes by hand, then the rows."""
    turn = np.eye(6)
    if frame == "tool":
        turn = np.kron(np.eye(2), arm.forward(q)[:3, :3].T)
    return (turn @ arm.jacobian(q))[ROWS[rows]], (turn @ twist)[ROWS[rows]]


@pytest.fixture(params=[(paper, Q_PAPER), (mixed, None), (skew, None)], ids=["paper", "mixed", "skew"])
def arm_at(request):
    make, q = request.param
    arm = make()
    return arm, configuration(arm) if q is None else q


@pytest.mark.parametrize("frame", ["base", "tool"])
@pytest.mark.parametrize("rows", ROWS, ids=str)
@pytest.mark.parametrize("tool", [None, TOOL], ids=["arm's tool", "tool offset"])
def test_the_rates_are_the_pseudoinverse_of_the_rows_asked_for(rows, frame, tool, arm_at):
    arm, q = arm_at
    task = sr.Task(rows=rows, frame=frame, tool=tool)
    out = sr.Controller(arm, law=EXACT, task=task, velocity_limits=np.inf).step(q, TWIST)
    moved = arm if tool is None else arm.with_tool(arm.tool @ tool)
    j, x = rows_by_hand(moved, q, TWIST, rows, frame)
    np.testing.assert_allclose(out.jacobian, j, atol=1e-12)
    np.testing.assert_allclose(out.twist, x, atol=1e-14)
    np.testing.assert_allclose(out.rates, np.linalg.pinv(j) @ x, rtol=1e-9, atol=1e-12)
    assert out.residual.shape == (len(ROWS[rows]),)
    np.testing.assert_allclose(out.residual, x - j @ out.rates, atol=1e-13)
    assert task.m == len(ROWS[rows])


@pytest.mark.parametrize("frame", ["base", "tool"])
def test_a_locked_joint_changes_nothing_of_that(frame, arm_at):
    arm, q = arm_at
    ctl = sr.Controller(arm, law=EXACT, task=sr.Task(rows=FIVE_AXIS, frame=frame), velocity_limits=np.inf)
    ctl.fail(2)
    out = ctl.step(q, TWIST)
    j, x = rows_by_hand(arm, q, TWIST, FIVE_AXIS, frame)
    j[:, 2] = 0.0
    np.testing.assert_allclose(out.rates, np.linalg.pinv(j, rcond=1e-12) @ x, rtol=1e-8, atol=1e-12)


def test_five_axis_work_leaves_the_turn_about_the_tool_free_and_keeps_the_rest():
    arm = skew(6, seed=8)
    q = configuration(arm)
    ctl = sr.Controller(arm, law=EXACT, task=sr.Task(rows=FIVE_AXIS, frame="tool"), velocity_limits=np.inf)
    rates = ctl.step(q, TWIST).rates
    R = arm.forward(q)[:3, :3]
    missing = TWIST - arm.jacobian(q) @ rates
    np.testing.assert_allclose(missing[:3], 0.0, atol=1e-10)
    np.testing.assert_allclose(np.cross(missing[3:], R[:, 2]), 0.0, atol=1e-10)
    assert abs(missing[3:] @ R[:, 2]) > 1e-3


def test_a_tool_offset_is_the_tasks_point_and_the_arm_keeps_its_own():
    arm = paper()
    task = sr.Task(tool=TOOL)
    one = sr.Controller(arm, task=task)
    other = sr.Controller(arm.with_tool(arm.tool @ TOOL))
    np.testing.assert_array_equal(one.step(Q_PAPER, TWIST).rates, other.step(Q_PAPER, TWIST).rates)
    assert one.arm is arm
    target = (arm.forward(Q_PAPER) @ TOOL) @ placement((0.01, 0, 0))
    np.testing.assert_array_equal(one.track(Q_PAPER, target).rates, other.track(Q_PAPER, target).rates)


@pytest.mark.parametrize("frame", ["base", "tool"])
@pytest.mark.parametrize("where", ["law", "task"])
def test_weights_say_what_counts(frame, where):
    """Too little freedom for the task: the residual is the weighted least-squares one; then the rates are."""
    arm = mixed(5, seed=14)
    q = configuration(arm)
    rng = np.random.default_rng(12)
    a = rng.normal(size=(6, 6))
    W1, W2 = a @ a.T + np.eye(6), rng.uniform(0.1, 5, 5)
    weights = sr.Weights(length=0.2, angle=1.5, task=W1, joints=W2)
    law = sr.LeastError(price=None, weights=weights if where == "law" else None)
    task = sr.Task(rows="pose", frame=frame, weights=weights if where == "task" else None)
    out = sr.Controller(arm, law=law, task=task, velocity_limits=np.inf).step(q, TWIST)
    j, x = rows_by_hand(arm, q, TWIST, "pose", frame)
    C = np.linalg.cholesky(W1).T / np.array([0.2] * 3 + [1.5] * 3)
    D = np.where(arm.kinds == 1, 0.2, 1.5) / np.sqrt(W2)
    expected = D * (np.linalg.pinv(C @ j * D) @ (C @ x))
    np.testing.assert_allclose(out.rates, expected, rtol=1e-9)
    assert out.task_error == pytest.approx(np.linalg.norm(C @ (x - j @ expected)), rel=1e-9)


def test_six_task_weights_serve_any_rows():
    arm = mixed()
    q = configuration(arm)
    W1 = np.array([1.0, 4.0, 9.0, 16.0, 25.0, 36.0])
    ctl = sr.Controller(arm, task=sr.Task(rows="orientation", weights=sr.Weights(task=W1)), velocity_limits=0.0)
    out = ctl.step(q, TWIST)
    assert out.task_error == pytest.approx(np.sqrt(np.sum(W1[3:] * TWIST[3:] ** 2)), rel=1e-12)


def test_weights_in_both_places_are_refused():
    law, task = sr.LeastError(weights=sr.Weights(length=2.0)), sr.Task(weights=sr.Weights())
    refused(lambda: sr.Controller(mixed(), law=law, task=task), "weights")


def test_joint_weights_of_another_arm_are_refused():
    refused(lambda: sr.Controller(mixed(), task=sr.Task(weights=sr.Weights(joints=np.ones(7)))), "weights.joints", "8")


@pytest.mark.parametrize("rows", ["poses", "", (True,) * 5, (False,) * 6, (1, 1, 1, 0, 0, 0), None, 3], ids=str)
def test_rows_that_are_none_are_refused(rows):
    refused(lambda: sr.Task(rows=rows), "rows", "position")


def test_a_frame_or_tool_that_is_none_is_refused():
    refused(lambda: sr.Task(frame="world"), "frame", "base", "tool")
    refused(lambda: sr.Task(tool=np.ones((4, 4))), "tool")
    refused(lambda: sr.Task(weights={"length": 1}), "weights")
