"""What the task leaves free goes where the null motion says; the task does not notice, nor do the bounds."""

import sys

import numpy as np
import pytest

import stillreach as sr
from oracles.box import nearest_same_motion
from tests.unit.control.robots import Q_PAPER, TWIST, configuration, mixed, null_projector, paper, refused

N = 11
POSTURE = np.linspace(-1.0, 1.0, N)
LIMITS = np.stack([np.full(N, -2.0), np.linspace(2.0, 5.0, N)], axis=1)
LAWS = [
    sr.LeastError(price=1e9),
    sr.LeastError(price=None),
    sr.KeepDirection(),
    sr.SingularityRobust(),
    sr.Pseudoinverse(),
]
EVERY_LAW = pytest.mark.parametrize("law", LAWS, ids=repr)
WANTED = {
    "posture": (sr.null_motions.Posture(q=POSTURE, gain=0.7), lambda q: 0.7 * (POSTURE - q)),
    "centring": (sr.null_motions.Centring(gain=0.4), lambda q: 0.4 * (LIMITS.mean(axis=1) - q)),
    "gradient": (
        sr.null_motions.Gradient(gradient=np.cos(np.arange(N)), gain=2.0),
        lambda q: 2.0 * np.cos(np.arange(N)),
    ),
    "callable": (sr.null_motions.Gradient(gradient=lambda q: np.sin(3 * q), gain=0.5), lambda q: 0.5 * np.sin(3 * q)),
    "list": (sr.null_motions.Gradient(gradient=lambda q: list(-q)), lambda q: -q),
    "rates": (sr.null_motions.Rates(rates=np.linspace(-0.3, 0.2, N)), lambda q: np.linspace(-0.3, 0.2, N)),
    "bare rates": (np.linspace(-0.3, 0.2, N), lambda q: np.linspace(-0.3, 0.2, N)),
}


@pytest.fixture(params=WANTED)
def wanted(request):
    """A null motion, and the rates (n,) that it means at q."""
    return WANTED[request.param]


@pytest.fixture(params=[(paper, Q_PAPER), (lambda: mixed(N), None)], ids=["paper", "mixed"])
def arm_at(request):
    make, q = request.param
    arm = make()
    return arm, configuration(arm) if q is None else q


@EVERY_LAW
@pytest.mark.parametrize("failed", [(), (1, 6), (0, 2, 3, 7)])
def test_the_part_that_moves_nothing_of_the_task_is_added(law, failed, wanted, arm_at):
    arm, q = arm_at
    motion, rates = wanted
    ctl, plain = (
        sr.Controller(arm, law=law, velocity_limits=1e3, position_limits=LIMITS * 100, null_motion=null)
        for null in (motion, None)
    )
    if isinstance(motion, sr.null_motions.Centring):
        ctl = sr.Controller(arm, law=law, velocity_limits=1e3, position_limits=LIMITS, null_motion=motion)
        q = np.clip(q, LIMITS[:, 0] + 0.1, LIMITS[:, 1] - 0.1)
    for joint in failed:
        ctl.fail(joint)
        plain.fail(joint)
    ctl.reset()  # no transition: as if the joints had failed long ago
    out = ctl.step(q, TWIST)
    working = ~np.isin(np.arange(N), failed)
    expected = plain.step(q, TWIST).rates + null_projector(arm.jacobian(q), working) @ rates(q)
    np.testing.assert_allclose(out.rates, expected, atol=1e-9)
    np.testing.assert_allclose(out.residual, 0.0, atol=1e-10)


@EVERY_LAW
def test_the_task_does_not_notice_even_where_bounds_bite(law, wanted, arm_at):
    arm, q = arm_at
    motion, _ = wanted
    settings = {"law": law, "velocity_limits": 0.15, "position_limits": LIMITS * 3}
    quiet, moved = (sr.Controller(arm, null_motion=null, **settings) for null in (None, motion))
    twist = 0.2 * TWIST
    for ctl in (quiet, moved):
        ctl.fail(5)
        ctl.reset()
    a, b = quiet.step(q, twist), moved.step(q, twist)
    if a.status & (sr.Status.DAMPED | sr.Status.SCALED):
        twist *= 0.2
        a, b = quiet.step(q, twist), moved.step(q, twist)
    if not isinstance(law, sr.Pseudoinverse):
        assert np.all((b.rates >= b.lower) & (b.rates <= b.upper))
    assert b.rates[5] == 0.0
    np.testing.assert_allclose(b.residual, a.residual, atol=1e-10)
    assert np.linalg.norm(b.rates - a.rates) > 1e-3


@pytest.mark.parametrize("law", [sr.LeastError(price=None), sr.KeepDirection()], ids=repr)
def test_inside_the_bounds_it_is_the_nearest_to_what_was_wanted(law, wanted, arm_at):
    arm, q = arm_at
    motion, rates = wanted
    if isinstance(motion, sr.null_motions.Centring):
        pytest.skip("its limits are bounds too")
    ctl = sr.Controller(arm, law=law, velocity_limits=0.3, null_motion=motion)
    ctl.fail(4)
    ctl.reset()
    out = ctl.step(q, 0.3 * TWIST)
    best = nearest_same_motion(arm.jacobian(q), out.rates, out.lower, out.upper, rates(q))
    assert best is not None
    distance = [np.linalg.norm(x - np.where(np.arange(N) == 4, 0, rates(q))) for x in (out.rates, best)]
    assert distance[0] <= distance[1] * (1 + 1e-8) + 1e-10


@pytest.mark.parametrize("seed", range(10))
def test_max_rate_scales_all_that_is_asked_by_one_factor(seed):
    arm = paper()
    rates = np.random.default_rng(seed).normal(size=N)
    asked = null_projector(arm.jacobian(Q_PAPER)) @ (rates * min(1.0, 0.05 / np.max(np.abs(rates))))
    out = sr.Controller(arm, null_motion=sr.null_motions.Rates(rates=rates, max_rate=0.05), velocity_limits=9.0).step(
        Q_PAPER, np.zeros(6)
    )
    np.testing.assert_allclose(out.rates, asked, atol=1e-12)


def test_a_failed_joint_does_not_count_for_max_rate():
    arm = paper()
    rates = np.where(np.arange(N) == 3, 100.0, 0.04)
    ctl = sr.Controller(arm, null_motion=sr.null_motions.Rates(rates=rates, max_rate=0.05), velocity_limits=9.0)
    ctl.fail(3)
    ctl.reset()
    working = np.arange(N) != 3
    expected = null_projector(arm.jacobian(Q_PAPER), working) @ np.where(working, 0.04, 0.0)
    np.testing.assert_allclose(ctl.step(Q_PAPER, np.zeros(6)).rates, expected, atol=1e-12)


def test_centring_leaves_joints_without_two_limits_alone():
    arm = paper()
    limits = LIMITS.copy()
    limits[2] = (-np.inf, 3.0)
    limits[5] = (-np.inf, np.inf)
    ctl = sr.Controller(arm, null_motion=sr.null_motions.Centring(), position_limits=limits, velocity_limits=99.0)
    with np.errstate(invalid="ignore"):
        wanted = np.where(np.all(np.isfinite(limits), axis=1), limits.mean(axis=1) - Q_PAPER, 0.0)
    np.testing.assert_allclose(
        ctl.step(Q_PAPER, np.zeros(6)).rates, null_projector(arm.jacobian(Q_PAPER)) @ wanted, atol=1e-12
    )


def test_a_posture_is_reached_as_far_as_the_task_allows():
    arm = paper()
    ctl = sr.Controller(
        arm, null_motion=sr.null_motions.Posture(q=Q_PAPER * 0.8, gain=2.0), period=0.02, velocity_limits=2.0
    )
    hold, q = arm.forward(Q_PAPER), Q_PAPER.copy()
    for _ in range(700):
        q = q + 0.02 * ctl.track(q, hold).rates
    np.testing.assert_allclose(arm.forward(q), hold, atol=1e-6)
    left = null_projector(arm.jacobian(q)) @ (Q_PAPER * 0.8 - q)
    assert np.linalg.norm(left) < 1e-5 < np.linalg.norm(null_projector(arm.jacobian(Q_PAPER)) @ (-0.2 * Q_PAPER))


def test_another_null_motion_takes_over_at_once_and_none_ends_it():
    arm = paper()
    ctl = sr.Controller(arm, null_motion=np.ones(N), velocity_limits=9.0)
    ctl.step(Q_PAPER, np.zeros(6))
    ctl.set_null_motion(sr.null_motions.Posture(q=POSTURE))
    expected = null_projector(arm.jacobian(Q_PAPER)) @ (POSTURE - Q_PAPER)
    np.testing.assert_allclose(ctl.step(Q_PAPER, np.zeros(6)).rates, expected, atol=1e-12)
    ctl.set_null_motion(None)
    np.testing.assert_allclose(ctl.step(Q_PAPER, np.zeros(6)).rates, 0.0, atol=1e-15)


class Broken(Exception):
    """The user's own error."""


def broken(q):
    raise Broken


BAD_GRADIENTS = {
    "raises": broken,
    "too short": lambda q: np.ones(N - 1),
    "nan": lambda q: np.full(N, np.nan),
    "a number": lambda q: 1.0,
    "nothing": lambda q: None,
    "text": lambda q: "up",
}


@pytest.mark.parametrize("kind", BAD_GRADIENTS)
def test_a_gradient_that_fails_propagates_from_step_and_changes_nothing(kind):
    ctl = sr.Controller(paper(), null_motion=np.ones(N))
    ctl.step(Q_PAPER, TWIST)
    before = ctl.last_rates.tolist()
    ctl.set_null_motion(sr.null_motions.Gradient(gradient=BAD_GRADIENTS[kind]))
    with pytest.raises(Broken if kind == "raises" else sr.InputError):
        ctl.step(Q_PAPER, -TWIST)
    with pytest.raises(Broken if kind == "raises" else sr.InputError):
        ctl.track(Q_PAPER, np.eye(4))
    assert ctl.last_rates.tolist() == before


@pytest.mark.parametrize("kind", BAD_GRADIENTS)
def test_a_gradient_that_fails_in_a_running_loop_is_off_for_that_tick(kind, monkeypatch):
    heard = []
    monkeypatch.setattr(sys, "unraisablehook", heard.append)
    arm, works = paper(), True
    gradient = lambda q: np.ones(N) if works else BAD_GRADIENTS[kind](q)  # noqa: E731
    ctl = sr.Controller(arm, null_motion=sr.null_motions.Gradient(gradient=gradient), velocity_limits=9.0)
    q, twist, rates = Q_PAPER.copy(), TWIST.copy(), np.zeros(N)
    tick = ctl.bind(q=q, twist=twist, rates=rates)
    assert not tick() & sr.Status.INVALID_INPUT
    moved = rates.copy()
    works = False
    assert tick() & sr.Status.INVALID_INPUT
    np.testing.assert_allclose(rates, sr.Controller(arm, velocity_limits=9.0).step(q, twist).rates, atol=1e-12)
    assert len(heard) == 1
    works = True
    assert not tick() & sr.Status.INVALID_INPUT
    np.testing.assert_allclose(rates, moved, atol=1e-12)


def test_a_gradient_sees_a_copy_of_where_the_joints_are():
    seen = []

    def gradient(q):
        seen.append(q.copy())
        q[:] = 99.0
        return np.zeros(N)

    q = Q_PAPER.copy()
    out = sr.Controller(paper(), null_motion=sr.null_motions.Gradient(gradient=gradient)).step(q, TWIST)
    np.testing.assert_array_equal(seen, [Q_PAPER])
    np.testing.assert_array_equal(q, Q_PAPER)
    np.testing.assert_array_equal(out.rates, sr.Controller(paper()).step(q, TWIST).rates)


@pytest.mark.parametrize(
    ("make", "argument"),
    [
        (lambda: sr.null_motions.Posture(q=np.zeros(N), max_rate=0.0), "max_rate"),
        (lambda: sr.null_motions.Posture(q=np.zeros(N), max_rate=np.nan), "max_rate"),
        (lambda: sr.null_motions.Posture(q=np.zeros(N - 1)), "q"),
        (lambda: sr.null_motions.Posture(q=np.full(N, np.nan)), "q"),
        (lambda: sr.null_motions.Posture(q=np.zeros(N), gain=-1.0), "gain"),
        (lambda: sr.null_motions.Centring(gain=np.inf), "gain"),
        (lambda: sr.null_motions.Manipulability(gain=0.0), "gain"),
        (lambda: sr.null_motions.Gradient(gradient=np.ones(3)), "gradient"),
        (lambda: sr.null_motions.Gradient(gradient="up"), "gradient"),
        (lambda: sr.null_motions.Rates(rates=np.full(N, np.inf)), "rates"),
        (lambda: np.full(N, np.nan), "null_motion"),
        (lambda: "home", "null_motion"),
        (lambda: sr.null_motions.Posture, "null_motion"),
    ],
    ids=range(13),
)
def test_a_null_motion_that_is_none_is_refused_and_the_old_one_stays(make, argument):
    refused(lambda: sr.Controller(paper(), null_motion=make()), argument)
    ctl = sr.Controller(paper(), null_motion=np.ones(N), velocity_limits=9.0)
    expected = ctl.step(Q_PAPER, TWIST).rates
    refused(lambda: ctl.set_null_motion(make()), argument)
    np.testing.assert_array_equal(ctl.step(Q_PAPER, TWIST).rates, expected)


def still(arm, q, posture, **settings):
    """Rates of a task that no joint of a planar arm can serve: those of the posture alone."""
    task = sr.Task(rows=(False, False, True, False, False, False))
    null_motion = sr.null_motions.Posture(q=posture, gain=1.0)
    return (
        sr.Controller(arm, task=task, null_motion=null_motion, velocity_limits=np.inf, **settings)
        .step(q, np.zeros(6))
        .rates
    )


@pytest.mark.parametrize("q", [3.1, -3.1, 0.5, 7.0, -40.0, np.pi, 1e6])
@pytest.mark.parametrize("posture", [-3.1, 3.1, 0.0, 20.0])
def test_a_joint_that_turns_without_end_takes_the_short_way(q, posture):
    way = still(sr.arms.planar(2), [q, 0.3], [posture, 0.3])
    np.testing.assert_allclose(np.exp(1j * (q + way[0])), np.exp(1j * posture), atol=1e-9)
    assert abs(way[0]) <= np.pi
    np.testing.assert_allclose(way[1], 0.0, atol=1e-12)
    if abs(posture - q) < np.pi:
        np.testing.assert_allclose(way[0], posture - q, rtol=1e-12)


def test_a_joint_with_a_limit_takes_the_way_that_it_has():
    for limits in ((-4.0, 4.0), (-4.0, np.inf), (-np.inf, 4.0)):
        way = still(sr.arms.planar(2), [3.1, 0.0], [-3.1, 0.0], position_limits=[limits, (-9, 9)])
        np.testing.assert_allclose(way[0], -6.2)
    ctl = sr.Controller(sr.arms.planar(2), null_motion=sr.null_motions.Posture(q=[-3.1, 0.0]), velocity_limits=np.inf)
    ctl.set_limits(position=(-4.0, 4.0))
    assert ctl.step([3.1, 0.0], np.zeros(6)).rates[0] <= 1e-12


def test_a_slide_takes_the_straight_way():
    slider = sr.Arm([sr.Joint(kind="prismatic")])
    task = sr.Task(rows="orientation")
    ctl = sr.Controller(slider, task=task, null_motion=sr.null_motions.Posture(q=[-3.1]))
    np.testing.assert_allclose(ctl.step([3.1], np.zeros(6)).rates, [-6.2])


@pytest.mark.parametrize(("multiplier", "way"), [(2.0, 2 * np.pi - 6.2), (-1.0, 2 * np.pi - 6.2), (0.5, -6.2)])
def test_a_whole_turn_leads_back_only_where_followers_come_back_too(multiplier, way):
    leader = sr.Joint(name="leader")
    follower = sr.Follower(sr.Joint(name="follower"), leader="leader", place=1, multiplier=multiplier)
    np.testing.assert_allclose(still(sr.Arm([leader], followers=[follower]), [3.1], [-3.1]), [way])
