"""The manipulability gradient is the derivative that it claims to be, for every arm, task, weight and failure."""

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.coupled_arms import coupled
from tests.unit.arm.odd_arms import placement
from tests.unit.control.robots import Q_PAPER, configuration, mixed, null_projector, paper, skew

MASK = (True, False, True, True, True, False)
TASKS = {
    "pose": {"rows": "pose"},
    "position": {"rows": "position"},
    "orientation": {"rows": "orientation"},
    "mask": {"rows": MASK},
    "pose in tool axes": {"rows": "pose", "frame": "tool"},
    "five-axis": {"rows": (True, True, True, True, True, False), "frame": "tool"},
    "mask in tool axes": {"rows": MASK, "frame": "tool"},
    "tool offset": {"rows": MASK, "frame": "tool", "tool": placement((0.3, -0.2, 0.1), (1, 2, 0), 1.1)},
}
ARMS = {"paper": paper, "coupled": coupled, "mixed": lambda: mixed(9, seed=6), "skew": lambda: skew(8)}


def task_jacobian(arm, q, task, C, units, working):
    """The weighted task Jacobian over the working joints, at q."""
    arm = arm if task.tool is None else arm.with_tool(arm.tool @ task.tool)
    turn = np.kron(np.eye(2), arm.forward(q)[:3, :3].T) if task.frame == "tool" else np.eye(6)
    rows = list(task.indices)
    return (C[np.ix_(rows, rows)] @ (turn @ arm.jacobian(q))[rows] * units)[:, working]


def log_volume(j):
    return np.sum(np.log(np.linalg.svd(j, compute_uv=False)))


def gradient_by_differences(f, q, step=1e-5):
    """Central differences of fourth order."""
    out = []
    for e in np.eye(len(q)):
        near, far = f(q + step * e) - f(q - step * e), f(q + 2 * step * e) - f(q - 2 * step * e)
        out.append((8 * near - far) / (12 * step))
    return np.array(out)


def weights_of(arm, kind):
    """Weights, the root of W1 (6, 6) over the row units, and the column units."""
    if kind == "unit":
        return sr.Weights(), np.eye(6), np.ones(arm.n)
    rng = np.random.default_rng(51)
    length, angle = 0.2, 1.7
    rows = np.array([length] * 3 + [angle] * 3)
    units = np.where(arm.kinds == 1, length, angle)
    if kind == "units":
        return sr.Weights(length=length, angle=angle), np.diag(1 / rows), units
    a = rng.normal(size=(6, 6))
    W1, W2 = (a @ a.T + np.eye(6)) if kind == "full task" else rng.uniform(0.2, 4, 6), rng.uniform(0.2, 4, arm.n)
    full = W1 if np.ndim(W1) == 2 else np.diag(W1)
    return (
        sr.Weights(length=length, angle=angle, task=W1, joints=W2),
        np.linalg.cholesky(full).T / rows,
        units / np.sqrt(W2),
    )


def controller(arm, failed, **settings):
    """A controller without limits whose joints failed long ago."""
    ctl = sr.Controller(arm, law=sr.LeastError(price=None), velocity_limits=np.inf, **settings)
    for joint in failed:
        ctl.fail(joint)
    ctl.reset()
    return ctl


@pytest.mark.parametrize("failed", [(), (2,), (0, 4)], ids=str)
@pytest.mark.parametrize("weighted", ["unit", "units", "diagonal", "full task"])
@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("make", ARMS)
def test_the_null_motion_is_the_projected_gradient(make, name, weighted, failed):
    arm = ARMS[make]()
    if arm.n - len(failed) <= len(sr.Task(**TASKS[name]).indices):
        pytest.skip("nothing is left free")
    weights, C, units = weights_of(arm, weighted)
    if weighted == "full task" and TASKS[name]["rows"] != "pose":
        pytest.skip("the rows of a full weight are covered by the pose")
    task = sr.Task(weights=weights, **TASKS[name])
    # what is added to leave saddles is the same for both gains: the difference is the gradient's
    one, two = (
        controller(arm, failed, task=task, null_motion=sr.null_motions.Manipulability(gain=gain, max_rate=1e3))
        for gain in (1.0, 2.0)
    )
    working = ~np.isin(np.arange(arm.n), failed)
    compared = 0
    for seed in range(8):
        q = configuration(arm, seed) if make != "paper" else Q_PAPER + 0.3 * configuration(arm, seed)
        at = lambda x: task_jacobian(arm, x, task, C, units, working)  # noqa: E731
        if np.linalg.cond(at(q)) > 2000:
            continue
        compared += 1
        gradient = np.where(working, gradient_by_differences(lambda x: log_volume(at(x)), q), 0.0)  # noqa: B023
        rates = two.step(q, np.zeros(6)).rates - one.step(q, np.zeros(6)).rates
        expected = np.zeros(arm.n)
        expected[working] = units[working] * (null_projector(at(q)) @ (gradient[working] / units[working]))
        np.testing.assert_allclose(rates, expected, atol=1e-6 * (1 + np.linalg.norm(gradient)))
    assert compared >= 2


def test_following_it_moves_away_from_a_singularity_while_the_tool_stands_still():
    arm = paper()
    q = np.where(np.arange(11) % 2 == 1, 0.25, 0.1) * np.cos(np.arange(11))
    hold, before = arm.forward(q), log_volume(arm.jacobian(q))
    ctl = sr.Controller(arm, null_motion=sr.null_motions.Manipulability(gain=0.5), period=0.02)
    for _ in range(300):
        out = ctl.track(q, hold)
        assert np.max(np.abs(out.rates)) <= np.max(arm.velocity_limits)
        q = q + 0.02 * out.rates
    np.testing.assert_allclose(arm.forward(q), hold, atol=1e-3)
    assert log_volume(arm.jacobian(q)) > before + 1.0


def test_an_exactly_planar_arm_leaves_its_plane_by_itself_and_every_run_is_the_same():
    """The start of the paper's second example: rolls at zero, where the gradient out of the plane is zero."""
    arm = paper()
    start = np.deg2rad([0, 30, 0, 45, 0, 30, 0, -60, 0, -45, 0.0])
    runs = []
    for _ in range(2):
        q = start.copy()
        ctl = sr.Controller(arm, null_motion=sr.null_motions.Manipulability(), period=0.02)
        for joint in ("j2", "j4", "j7"):
            ctl.fail(joint)
        for _ in range(500):
            q = q + 0.02 * ctl.track(q, arm.forward(start)).rates
        runs.append(q)
    np.testing.assert_array_equal(runs[0], runs[1])
    assert np.max(np.abs(runs[0][::2])) > 0.03
    np.testing.assert_allclose(arm.forward(runs[0]), arm.forward(start), atol=1e-3)


@pytest.mark.parametrize(
    "q", [np.zeros(11), np.full(11, 1e-9), 1e-4 * np.cos(np.arange(11))], ids=["zero", "1e-9", "1e-4"]
)
def test_at_and_near_a_singularity_it_is_finite_and_at_most_max_rate(q):
    arm = paper()
    ctl = sr.Controller(arm, null_motion=sr.null_motions.Manipulability(max_rate=0.1), velocity_limits=2.0)
    out = ctl.step(q, np.zeros(6))
    assert np.all(np.isfinite(out.rates))
    assert np.linalg.norm(out.rates) <= 0.1 * np.sqrt(11)
    # standing still would cost half the reference's square, so that the error costs no more
    assert 80.0 * 2.0 * np.linalg.norm(out.residual) <= 0.5 * 0.1**2 * 11


def near_singular():
    """A redundant arm in poses where its smallest singular value is 0.3 to 0.0003: damping is on."""
    arm = paper()
    return arm, [size * np.cos(np.arange(11.0)) for size in (0.3, 0.1, 0.03, 0.01)]


@pytest.mark.parametrize(
    "null", [sr.null_motions.Manipulability(max_rate=0.2), np.full(11, 0.2)], ids=["manipulability", "rates"]
)
@pytest.mark.parametrize("price", [80.0, 8.0, None])
def test_near_a_singularity_it_moves_a_tool_at_rest_no_more_than_the_price_allows(price, null):
    arm, poses = near_singular()
    law = sr.LeastError(price=price)
    for q in poses:
        out = sr.Controller(arm, law=law, null_motion=null, velocity_limits=9.0).step(q, np.zeros(6))
        allowed = 1e-9 if price is None else 0.5 * 0.2**2 * 11 / (9.0 * price)
        assert np.linalg.norm(out.residual) <= allowed


def test_keep_direction_does_not_move_a_tool_at_rest_near_a_singularity():
    arm, poses = near_singular()
    for q in poses:
        ctl = sr.Controller(arm, law=sr.KeepDirection(), null_motion=np.full(11, 0.2), velocity_limits=9.0)
        np.testing.assert_allclose(ctl.step(q, np.zeros(6)).residual, 0.0, atol=1e-9)


def test_with_no_freedom_left_there_is_no_null_motion():
    arm = skew(6, seed=8)
    q = configuration(arm)
    for law in (sr.LeastError(), sr.LeastError(price=None), sr.KeepDirection()):
        out = sr.Controller(arm, law=law, null_motion=sr.null_motions.Manipulability(), velocity_limits=9.0).step(
            q, np.zeros(6)
        )
        np.testing.assert_allclose(out.rates, 0.0, atol=1e-9)
