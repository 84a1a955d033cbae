"""Rates do not jump: straight lines of ever finer steps in twist, configuration and bounds.

Where a function jumps, the largest step of a walk stays as large as the jump however fine the walk is; where it is
continuous it shrinks with the step.
"""

from dataclasses import dataclass

import numpy as np
import pytest

import stillreach as sr
from tests.conformance.registry import ARMS

GAIN = 10.0
DAMPED, BARE = sr.LeastError(max_gain=GAIN), sr.LeastError(max_gain=None)
STEPS = (4000, 8000, 16000)
LIMIT = np.deg2rad(50.0)


@dataclass(frozen=True)
class Walk:
    """Rates (K, n), twists (K, m) and damping (K,) along a line, and the number of active bounds at its points."""

    rates: np.ndarray
    twists: np.ndarray
    damping: np.ndarray
    active: np.ndarray

    def steepest(self):
        """Largest change of the rates per unit of the way, whose length is 1."""
        return np.max(np.linalg.norm(np.diff(self.rates, axis=0), axis=1)) * (len(self.rates) - 1)

    def gain(self):
        """Largest change of the rates per change of the twist, over the steps where the damping does not move."""
        still = np.diff(self.damping) == 0.0
        moves = np.linalg.norm(np.diff(self.rates, axis=0)[still], axis=1)
        return np.max(moves / np.linalg.norm(np.diff(self.twists, axis=0)[still], axis=1), initial=0.0)


def walk(law, steps, question):
    """question(t) -> J, twist, lower, upper for t from 0 to 1, each asked from cold."""
    rates, twists, damping, active = [], [], [], []
    for t in np.linspace(0.0, 1.0, steps + 1):
        j, twist, lower, upper = question(t)
        kinds = "vvvwww"[: len(twist)]
        answer = law.solve(j, twist, sr.Bounds(lower, upper), row_kinds=kinds)
        rates.append(answer.rates), twists.append(twist), damping.append(answer.damping)
        active.append(np.count_nonzero(answer.active))
    return Walk(np.array(rates), np.array(twists), np.array(damping), np.array(active))


def between(a, b):
    return lambda t: (1.0 - t) * np.asarray(a) + t * np.asarray(b)


def line(seed, kind, arm_name="paper"):
    """A line in one of twist, configuration ("q": through the straight pose) and bounds, the rest held."""
    rng = np.random.default_rng([7, seed])
    subject = ARMS[arm_name]
    arm, rows = subject.make(), list(subject.rows)
    here, there = rng.uniform(-1.5, 1.5, (2, arm.n))
    twist = rng.normal(size=len(rows)) * 1.5
    limits = LIMIT * 10.0 ** rng.uniform(-0.5, 0.5, (2, arm.n))
    failed = rng.random(arm.n) < 0.2
    q, x, scale = between(here, here), between(twist, twist), between(1.0, 1.0)
    if kind == "twist":
        x = between(-twist, twist + rng.normal(size=len(rows)))
    elif kind == "q":
        q = between(here, -here)
    elif kind == "bounds":
        scale = between(np.full((2, arm.n), 0.02), 10.0 ** rng.uniform(0.0, 1.0, (2, arm.n)))
    else:
        q = between(here, there)

    def question(t):
        low, high = limits * scale(t) * ~failed
        return arm.jacobian(q(t))[rows], x(t), -low, high

    return question


def shrinks(law, question, steps=STEPS):
    """The steepest slopes of ever finer walks; they settle where there is no jump, and double where there is one."""
    walks = [walk(law, number, question) for number in steps]
    return walks, [each.steepest() for each in walks]


LINES = [("least error", DAMPED, kind, seed) for kind in ("twist", "q", "bounds", "pose to pose") for seed in (0, 1)]
LINES += [("keep direction", sr.KeepDirection(), "twist", seed) for seed in (0, 1)]


@pytest.mark.parametrize(("name", "law", "kind", "seed"), LINES, ids=[f"{n}, {k} {s}" for n, _, k, s in LINES])
@pytest.mark.parametrize("arm", ["paper", "planar, position"])
def test_no_jump(name, law, kind, seed, arm, capsys):
    walks, slopes = shrinks(law, line(seed, kind, arm))
    with capsys.disabled():
        slope = ", ".join(f"{s:.4g}" for s in slopes)
        print(f"\n  {name}, line in {kind}, {arm}: slopes {slope}; gain {walks[-1].gain():.4g}", end="")
    assert len(np.unique(walks[-1].active)) > 1
    assert slopes[-1] <= 1.3 * slopes[-2]
    if name == "least error":
        assert walks[-1].gain() <= GAIN * (1.0 + 1e-6)


def tilted(law, tilt):
    """Rates in the start of example 2 with all rolls tilted."""
    q = np.deg2rad([0.0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0])
    q[::2] += tilt
    J = sr.arms.nasa_modular().jacobian(q)
    return law.solve(J, np.array([0.0, 6, 0, 0, 0, 0]), sr.Bounds.symmetric(LIMIT, n=11))


def test_the_bare_optimum_flips_a_joint_for_next_to_nothing_and_the_gain_cures_it(capsys):
    bare = [tilted(BARE, tilt) for tilt in (-1e-6, 1e-6)]
    damped = [tilted(DAMPED, tilt) for tilt in (-1e-6, 1e-6)]
    j4 = np.rad2deg([[answer.rates[3] for answer in pair] for pair in (bare, damped)])
    with capsys.disabled():
        print(f"\n  j4 at rolls of -1e-6 and 1e-6 rad [deg/s]: bare {j4[0].round(3)}, with max_gain {j4[1].round(3)}")
    assert np.allclose(np.sort(j4[0]), [-50.0, 50.0])
    assert abs(bare[0].task_error - bare[1].task_error) < 1e-5
    assert np.max(np.abs(damped[0].rates - damped[1].rates)) < 1e-3


def test_a_walk_sees_a_jump():
    _, slopes = shrinks(BARE, lambda t: _flip(t), steps=(1000, 2000))
    assert slopes[1] > 1.9 * slopes[0]


def _flip(t):
    q = np.deg2rad([0.0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0])
    q[::2] += 2e-3 * (t - 0.4999)
    return sr.arms.nasa_modular().jacobian(q), np.array([0.0, 6, 0, 0, 0, 0]), np.full(11, -LIMIT), np.full(11, LIMIT)
