"""A solution looks at itself: what is lost, what is weak, and whether it kept its word. Judged by an SVD by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

import stillreach as sr
from stillreach.insight import check
from tests.unit.control.robots import EVERY_LAW, Q_PAPER, TWIST, configuration, mixed, paper


def left_null_space(j):
    u, s, _ = np.linalg.svd(j)
    return u[:, np.sum(s > 1e-10 * s[0]) :]


def same_span(a, b):
    """Both orthonormal, and projectors equal."""
    np.testing.assert_allclose(a.T @ a, np.eye(a.shape[1]), atol=1e-12)
    np.testing.assert_allclose(a @ a.T, b @ b.T, atol=1e-12)


@EVERY_LAW
def test_the_straight_arm_has_lost_exactly_its_left_null_space(law):
    arm = paper()
    out = sr.Controller(arm, law=law).step(np.zeros(11), 0.1 * np.ones(6))
    lost = out.lost_directions()
    assert lost.shape == (6, 3)
    same_span(lost, left_null_space(arm.jacobian(np.zeros(11))))
    assert out.status & sr.Status.SINGULAR
    if not isinstance(law, sr.Pseudoinverse):
        assert np.all((out.rates >= out.lower) & (out.rates <= out.upper))


@pytest.mark.parametrize("failed", [(), (2,), (0, 3, 5, 6, 8, 10), tuple(range(11))], ids=str)
def test_what_is_lost_is_lost_to_the_working_joints(failed):
    arm = paper()
    ctl = sr.Controller(arm, velocity_limits=1.0)
    for joint in failed:
        ctl.fail(joint)
    out = ctl.step(Q_PAPER, TWIST)
    j = np.delete(arm.jacobian(Q_PAPER), failed, axis=1)
    expected = left_null_space(j) if j.size else np.eye(6)
    same_span(out.lost_directions(), expected)
    np.testing.assert_allclose(out.lost_directions().T @ j, 0.0, atol=1e-12)
    sigma = np.linalg.svd(j, compute_uv=False) if j.size else np.zeros(0)
    np.testing.assert_allclose(out.singular_values(), sigma, atol=1e-12)


def test_a_joint_with_a_limit_of_zero_serves_nothing():
    arm = paper()
    limits = np.where(np.arange(11) < 6, 1.0, 0.0)
    out = sr.Controller(arm, velocity_limits=limits).step(Q_PAPER, TWIST)
    np.testing.assert_allclose(out.singular_values(), np.linalg.svd(arm.jacobian(Q_PAPER)[:, :6], compute_uv=False))


def test_weak_directions_are_those_below_the_threshold_weakest_first():
    arm = mixed(9)
    out = sr.Controller(arm).step(configuration(arm), TWIST)
    u, s, _ = np.linalg.svd(arm.jacobian(configuration(arm)))
    for count, threshold in ((0, s[5] * 0.9), (1, s[5] * 1.01), (3, (s[2] + s[3]) / 2), (6, 2 * s[0])):
        weak = out.weak_directions(threshold)
        assert weak.shape == (6, count)
        np.testing.assert_allclose(np.abs(np.sum(weak * u[:, ::-1][:, :count], axis=0)), 1.0, atol=1e-10)
        gains = np.linalg.norm(weak.T @ arm.jacobian(configuration(arm)), axis=1)
        np.testing.assert_allclose(gains, s[::-1][:count], rtol=1e-10)


def test_lost_directions_are_among_the_weak_ones():
    out = sr.Controller(paper()).step(np.zeros(11), np.zeros(6))
    assert out.weak_directions(0.0).shape == (6, 3)
    assert out.weak_directions(1e-3).shape == (6, 3)
    assert out.weak_directions(100.0).shape == (6, 6)


@pytest.mark.parametrize("threshold", [-1.0, np.nan, "weak", None])
def test_a_threshold_that_is_none_is_refused(threshold):
    out = sr.Controller(paper()).step(Q_PAPER, TWIST)
    with pytest.raises(sr.InputError, match="threshold"):
        out.weak_directions(threshold)


def test_they_are_in_weighted_units_and_task_rows():
    arm = mixed(9)
    q = configuration(arm)
    weights = sr.Weights(length=0.3, angle=2.0, joints=np.linspace(0.5, 2, 9))
    task = sr.Task(rows=(True, True, False, False, True, False), weights=weights)
    out = sr.Controller(arm, task=task).step(q, TWIST)
    units = np.where(arm.kinds == 1, 0.3, 2.0) / np.sqrt(np.linspace(0.5, 2, 9))
    j = arm.jacobian(q)[[0, 1, 4]] / np.array([[0.3], [0.3], [2.0]]) * units
    np.testing.assert_allclose(out.weighted_jacobian, j, atol=1e-12)
    np.testing.assert_allclose(out.singular_values(), np.linalg.svd(j, compute_uv=False), rtol=1e-10)
    assert out.lost_directions().shape == (3, 0)


@EVERY_LAW
@pytest.mark.parametrize("size", [0.0, 1e-6, 1.0, 1e6])
def test_every_promise_is_found_kept(law, size):
    arm = paper()
    ctl = sr.Controller(arm, law=law, acceleration_limits=30.0)
    ctl.fail(3)
    ctl.fail(5, sr.Runaway(0.01))
    for q in (Q_PAPER, np.zeros(11)):
        found = ctl.step(q, size * TWIST).check()
        if isinstance(law, sr.Pseudoinverse) and not found:
            assert not found.inside
            assert found.excess > 0.0
            assert found.residual
        else:
            assert found


def data(out, **changes):
    """What a solution holds, with lies."""
    names = ("rates", "lower", "upper", "twist", "jacobian", "residual")
    return SimpleNamespace(**{"status": out.status, **{n: np.array(getattr(out, n)) for n in names}, **changes})


def test_a_broken_promise_is_found():
    ctl = sr.Controller(paper())
    ctl.fail(3)
    out = ctl.step(Q_PAPER, TWIST)
    assert check(data(out))

    def bent(**at):
        rates = np.array(out.rates)
        for joint, value in at.items():
            rates[int(joint[1:])] = value
        return {"rates": rates, "residual": out.twist - out.jacobian @ rates}

    moved = check(data(out, **bent(j3=1e-300)))
    assert not moved
    assert not moved.fixed
    outside = check(data(out, **bent(j0=np.nextafter(out.upper[0], 9.0))))
    assert not outside
    assert not outside.inside
    assert 0.0 < outside.excess < 1e-12
    endless = check(data(out, **bent(j0=np.nan)))
    assert not endless
    assert not endless.finite
    lied = check(data(out, residual=out.residual + 1e-9))
    assert not lied
    assert not lied.residual
    assert lied.residual_error == pytest.approx(1e-9, rel=1e-3)
    assert lied.inside
    nothing = check(data(out, residual=np.full(6, np.nan)))
    assert not nothing


def test_out_that_was_written_over_since_is_found():
    ctl, out = sr.Controller(paper()), np.zeros(11)
    first = ctl.step(Q_PAPER, TWIST, out=out)
    assert first.check()
    ctl.step(Q_PAPER, -TWIST, out=out)
    assert not first.check()


def test_a_solution_prints_what_matters_on_one_line():
    ctl = sr.Controller(paper(), velocity_limits=0.01)
    text = repr(ctl.step(Q_PAPER, TWIST))
    assert text.startswith("Solution(")
    assert "\n" not in text
    for word in ("rates=", "SATURATED", "task_error=", "damping=", "scale="):
        assert word in text
    assert "\n" not in repr(sr.Controller(sr.arms.planar(40)).step(np.full(40, 0.1), np.ones(6)))


def test_what_a_solution_holds_cannot_be_changed_by_mistake():
    out = sr.Controller(paper()).step(Q_PAPER, TWIST)
    for name in ("residual", "twist", "lower", "upper", "jacobian", "active"):
        assert not getattr(out, name).flags.writeable, name
    with pytest.raises(AttributeError):
        out.damping = 1.0


def elbow_arm(right_angle):
    """Spherical shoulder, elbow, spherical wrist, with right angles as a robot file writes them."""
    signs = [-1, 1, -1, 1, 1, -1, 0]
    return sr.Arm.from_dh([sr.DHRow(alpha=s * right_angle, d=0.4 * (k in (2, 4))) for k, s in enumerate(signs)])


@pytest.mark.parametrize("right_angle", [np.pi / 2, 1.5708, 1.571])
@pytest.mark.parametrize("length", [1.0, 0.001])
def test_a_direction_that_only_rounding_serves_is_lost(right_angle, length):
    """Without its elbow the arm cannot move its wrist towards its shoulder: along the wrist's place."""
    arm, q = elbow_arm(right_angle), np.array([0.3, -0.9, 0.5, 1.4, -0.7, 1.1, 0.2])
    ctl = sr.Controller(arm, task=sr.Task(weights=sr.Weights(length=length, angle=length)))
    assert ctl.step(q, np.zeros(6)).lost_directions().shape == (6, 0)
    ctl.fail("j4")
    lost = ctl.step(q, np.zeros(6)).lost_directions()
    wrist = elbow_arm(np.pi / 2).forward(q)[:3, 3]
    assert lost.shape == (6, 1)
    assert abs(lost[:3, 0] @ wrist) == pytest.approx(np.linalg.norm(wrist), rel=1e-4)


def test_full_rates_and_least_speeds_are_arguments():
    slides = [sr.Joint(name=name, kind="prismatic", axis=axis) for name, axis in (("x", [1, 0, 0]), ("y", [0, 1, 0]))]
    ctl = sr.Controller(sr.Arm(slides), task=sr.Task(rows=[True, True, False, False, False, False]))
    out = ctl.step(np.zeros(2), np.zeros(6))
    assert out.lost_directions().shape == (2, 0)
    assert out.lost_directions(rates=[0.5, np.inf]).shape == (2, 0)
    same_span(out.lost_directions(rates=[0.9e-3, 1.0]), np.array([[1.0], [0.0]]))
    same_span(out.lost_directions(rates=[0.5, 0.2], least=0.3), np.array([[0.0], [1.0]]))
    same_span(out.lost_directions(rates=[0.5, 0.2], least=[0.6, 0.1]), np.array([[1.0], [0.0]]))
    same_span(out.lost_directions(rates=0.0), np.eye(2))


WEIGHTS = [None, sr.Weights(length=1e-3), sr.Weights(task=np.full(6, 1e-8)), sr.Weights(task=[1e8, 1, 1, 1, 1, 1])]


@pytest.mark.parametrize("weights", WEIGHTS)
@pytest.mark.parametrize(("bend", "lost"), [(0.5e-3, 1), (0.0, 1), (5e-3, 0)])
def test_weights_make_no_direction_more_or_less_lost(weights, bend, lost):
    """Two links of 1 m, nearly stretched out along x: full rates give about the bend in m/s along x."""
    out = sr.Controller(sr.arms.planar(2), task=sr.Task(rows="position", weights=weights)).step([0.0, bend], TWIST)
    told = out.lost_directions()
    assert told.shape == (3, 1 + lost)  # z as well
    np.testing.assert_allclose(told.T @ told, np.eye(1 + lost), atol=1e-12)
    np.testing.assert_allclose(out.row_weights @ out.twist, np.diag(out.row_weights) * TWIST[:3], rtol=1e-12)
    components = out.row_weights.T @ told  # of a twist, that no rates make: x and z, and nothing of y
    assert np.max(np.abs(components[1])) < 0.01 * np.max(np.abs(components))


@pytest.mark.parametrize(
    ("arguments", "name"),
    [({"rates": -1.0}, "rates"), ({"rates": [1.0]}, "rates"), ({"least": 0.0}, "least"), ({"least": [1, 2]}, "least")],
)
def test_rates_and_speeds_that_are_none_are_refused(arguments, name):
    out = sr.Controller(paper()).step(Q_PAPER, TWIST)
    with pytest.raises(sr.InputError, match=name):
        out.lost_directions(**arguments)
