"""Copies and pickles of controllers and their answers: a what-if from the present state."""

import copy
import pickle

import numpy as np
import pytest

import stillreach as sr
from tests.unit.control.robots import Q_PAPER, TWIST, paper

WAYS = {"copy": copy.copy, "deepcopy": copy.deepcopy, "pickle": lambda thing: pickle.loads(pickle.dumps(thing))}
EVERY_WAY = pytest.mark.parametrize("way", WAYS)


def softly(q):
    return -0.1 * np.asarray(q)


SETTINGS = {
    "least error": {},
    "keep direction, five axes": {
        "law": sr.KeepDirection(),
        "task": sr.Task(rows=(True, True, True, True, True, False), frame="tool"),
        "null_motion": sr.null_motions.Posture(q=np.zeros(11), gain=0.5),
        "transition_rate": 0.7,
    },
    "weights, gradient": {
        "law": sr.SingularityRobust(weights=sr.Weights(length=0.0254, joints=np.diag(np.arange(1.0, 12.0)))),
        "null_motion": sr.null_motions.Gradient(gradient=softly),
        "return_rate": 0.1,
        "track_limits": (0.1, 0.2),
        "track_gain": 3.0,
    },
    "manipulability": {"null_motion": sr.null_motions.Manipulability(max_rate=0.2), "position_limits": (-2.0, 2.0)},
}


def lived(settings):
    """A controller in the middle of its life (moving, faults, a transition, limits closing in), and where it is."""
    ctl = sr.Controller(paper(), period=0.01, acceleration_limits=3.0, **settings)
    q = Q_PAPER
    for t in range(60):
        q = q + 0.01 * ctl.step(q, 5 * TWIST).rates
        if t == 20:
            ctl.fail("j3")
            ctl.fail("j5", sr.Derated(0.5))
        if t == 50:
            ctl.fail("j9", sr.Runaway(0.02))
            ctl.set_limits(velocity=0.1, position=(-1.5, 1.5))
            ctl.set_speed(0.8)
    return ctl, q


def future(ctl, q):
    """All rates and statuses of some ticks, with a restore among them."""
    target, rows = paper().forward(q + 0.05), []
    for t in range(40):
        out = ctl.track(q, target) if t % 2 else ctl.step(q, 5 * TWIST)
        rows.append([*out.rates, out.damping, int(out.status)])
        q = q + 0.01 * out.rates
        if t == 20:
            ctl.restore("j3")
    return np.array(rows)


@EVERY_WAY
@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
def test_a_copy_goes_on_from_the_present_state_to_the_last_bit(way, settings):
    ctl, q = lived(settings)
    twin = WAYS[way](ctl)
    assert type(twin) is sr.Controller
    assert twin.faults == ctl.faults == {"j3": sr.Locked(), "j5": sr.Derated(0.5), "j9": sr.Runaway(0.02)}
    np.testing.assert_array_equal(twin.health, ctl.health)
    np.testing.assert_array_equal(twin.last_rates, ctl.last_rates)
    assert (twin.period, twin.speed) == (0.01, 0.8)
    np.testing.assert_array_equal(twin.velocity_limits, ctl.velocity_limits)
    assert repr(twin.law) == repr(ctl.law)
    np.testing.assert_array_equal(future(twin, q), future(ctl, q))


@EVERY_WAY
def test_what_happens_to_a_copy_does_not_happen_to_its_original(way):
    ctl, q = lived({})
    twin, untouched = WAYS[way](ctl), WAYS[way](ctl)
    twin.fail("j1")
    twin.set_limits(velocity=0.0)
    twin.set_null_motion(sr.null_motions.Centring())
    twin.step(q, TWIST)
    assert "j1" not in ctl.faults
    np.testing.assert_array_equal(future(ctl, q), future(untouched, q))


@EVERY_WAY
def test_a_subclass_is_copied_with_its_own_attributes(way):
    twin = WAYS[way](Welder("left"))
    assert type(twin) is Welder
    assert twin.side == "left"
    assert twin.arm.n == 11


class Welder(sr.Controller):
    def __init__(self, side):
        super().__init__(paper())
        self.side = side


@EVERY_WAY
@pytest.mark.parametrize("settings", SETTINGS.values(), ids=SETTINGS)
def test_an_answer_is_copied_with_all_that_it_was_computed_from(way, settings):
    ctl, q = lived(settings)
    out = ctl.step(q, TWIST)
    twin = WAYS[way](out)
    for name in ("rates", "residual", "active", "twist", "lower", "upper", "jacobian", "weighted_jacobian"):
        np.testing.assert_array_equal(getattr(twin, name), getattr(out, name), err_msg=name)
    for name in ("status", "damping", "scale", "task_error", "iterations", "rank_tolerance"):
        assert getattr(twin, name) == getattr(out, name), name
    assert repr(twin) == repr(out)
    assert twin.check() == out.check()
    np.testing.assert_array_equal(twin.singular_values(), out.singular_values())
    np.testing.assert_array_equal(twin.lost_directions(), out.lost_directions())


@pytest.mark.parametrize("way", ["deepcopy", "pickle"])
def test_a_copied_answer_outlives_the_array_that_its_rates_were_written_to(way):
    rates = np.zeros(11)
    out = sr.Controller(paper()).step(Q_PAPER, TWIST, out=rates)
    twin, before = WAYS[way](out), rates.copy()
    rates[:] = 7.0
    np.testing.assert_array_equal(twin.rates, before)


def test_answers_of_laws_alone_are_copied_too():
    bounds = sr.Bounds.symmetric(0.1, n=11).lock([3])
    out = sr.LeastError().solve(paper().jacobian(Q_PAPER), TWIST, bounds)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(out)).residual, out.residual)


@pytest.mark.parametrize(
    "spoil", [lambda s: s[:-1], lambda s: (s[0], 0, *s[2:]), lambda s: (*s[:9], b"", *s[10:]), lambda s: ()]
)
def test_a_state_that_is_none_is_refused(spoil):
    out = sr.Controller(paper()).step(Q_PAPER, TWIST)
    with pytest.raises(sr.InputError):
        type(out).__new__(type(out)).__setstate__(spoil(out.__getstate__()))
    ctl = sr.Controller(paper())
    with pytest.raises(sr.InputError):
        ctl._set_state(b"short")
