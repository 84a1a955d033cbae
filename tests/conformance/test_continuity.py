"""Rates do not jump: straight lines in twist, configuration and bounds, and a closer look where they change most.

Halving a step halves the change of a function that is continuous there; a jump stays, however small the step.
"""

from dataclasses import dataclass

import numpy as np
import pytest

import stillreach as sr
from oracles.price import typical_rate
from stillreach import _core
from tests.conformance.registry import ARMS

PRICED, BARE = sr.LeastError(), sr.LeastError(price=None)
STEPS, LOOKS, HALVINGS = 2000, 5, 34
LIMIT = np.deg2rad(50.0)


@dataclass(frozen=True)
class Walk:
    """Answers along a line of length 1.

    Attributes:
        slope: steepest change of the rates per length that was seen.
        jump: largest change left between points 3e-14 apart.
        share: largest change of the rates as a share of sqrt(2 Y |change of the twist|); 0 where the twist stays.
        sets: number of different sets of active bounds.
    """

    slope: float
    jump: float
    share: float
    sets: int


def walk(law, question):
    """question(t) -> J, twist, lower, upper for t from 0 to 1, each asked from cold, past the door's checks."""
    j, *_ = question(0.0)
    settings, metric = law.core(), sr.Weights().metric([True] * j.shape[0], [False] * j.shape[1])
    ask = lambda t: _core.solve(settings, metric, *question(t), None, None, -1.0)  # noqa: E731
    times = np.linspace(0.0, 1.0, STEPS + 1)
    answers = [ask(t) for t in times]
    moves = np.linalg.norm(np.diff([answer.rates for answer in answers], axis=0), axis=1)
    moved = np.linalg.norm(np.diff([answer.twist for answer in answers], axis=0), axis=1)
    shares = moves[moved > 0.0] / np.sqrt(2.0 * price(question(0.0)) * moved[moved > 0.0])
    looks = [closer(ask, times[k], times[k + 1]) for k in np.argsort(moves)[-LOOKS:]]
    slope, jump = np.max(looks, axis=0)
    sets = {answer.active.tobytes() for answer in answers}
    return Walk(slope, jump, np.max(shares, initial=0.0), len(sets))


def price(question):
    """Y of the default law."""
    _, _, lower, upper = question
    return 80.0 * typical_rate(lower, upper)


def closer(ask, a, b):
    """Halves the step from a to b again and again, to the side where more changes: steepest slope, change left."""
    here, there, slope = ask(a).rates, ask(b).rates, 0.0
    for _ in range(HALVINGS):
        slope = max(slope, np.linalg.norm(there - here) / (b - a))
        middle = (a + b) / 2.0
        between_them = ask(middle).rates
        if np.linalg.norm(between_them - here) > np.linalg.norm(there - between_them):
            b, there = middle, between_them
        else:
            a, here = middle, between_them
    return slope, np.linalg.norm(there - here)


def between(a, b):
    return lambda t: (1.0 - t) * np.asarray(a) + t * np.asarray(b)


def line(seed, kind, arm_name="paper"):
    """A line in one of twist, configuration ("q": through the straight pose), bounds, and a window, the rest held."""
    rng = np.random.default_rng([7, seed])
    subject = ARMS[arm_name]
    arm, rows = subject.make(), list(subject.rows)
    here, there = rng.uniform(-1.5, 1.5, (2, arm.n))
    twist = rng.normal(size=len(rows)) * 1.5
    limits = LIMIT * 10.0 ** rng.uniform(-0.5, 0.5, (2, arm.n))
    failed = rng.permutation(arm.n) < arm.n // 5
    q, x, scale = between(here, here), between(twist, twist), between(1.0, 1.0)
    if kind == "twist":
        x = between(0.1 * twist, 2.0 * twist + rng.normal(size=len(rows)))
    elif kind == "q":
        q = between(here, -here)
    elif kind == "bounds":
        scale = between(np.full((2, arm.n), 0.02), 10.0 ** rng.uniform(0.0, 1.0, (2, arm.n)))
    elif kind == "a window":  # of one or two joints, which closes at a rate that is not 0
        some, ends = rng.permutation(np.flatnonzero(~failed))[: 1 + seed % 2], between(1.0, 0.0)
        shut = 0.3 * rng.uniform(-1.0, 1.0, len(some)) * limits[0, some]
    else:
        q = between(here, there)

    def question(t):
        low, high = limits * scale(t) * ~failed
        low = -low
        if kind == "a window":
            width = 0.02 * ends(t) * limits[:, some] * np.arange(1, len(some) + 1)
            low[some], high[some] = shut - width[0], shut + width[1]
        return arm.jacobian(q(t))[rows], x(t), low, high

    return question


SEEDS = (0, 1, 3)
KINDS = ("twist", "q", "bounds", "a window", "pose to pose")
LINES = [("least error", PRICED, kind, seed) for kind in KINDS for seed in SEEDS]
LINES += [("keep direction", sr.KeepDirection(), "twist", seed) for seed in SEEDS]


@pytest.mark.parametrize(("name", "law", "kind", "seed"), LINES, ids=[f"{n}, {k} {s}" for n, _, k, s in LINES])
@pytest.mark.parametrize("arm", ["paper", "planar, position"])
def test_no_jump(name, law, kind, seed, arm, capsys):
    found = walk(law, line(seed, kind, arm))
    text = f"{name}, line in {kind}, {arm}: {found.sets} sets of active bounds, Lipschitz {found.slope:.4g}"
    priced_twist = kind == "twist" and name == "least error"
    if priced_twist:
        text += f", {found.share:.4f} of sqrt(2 Y |change of the twist|)"
    with capsys.disabled():
        print("\n  " + text, end="")
    assert found.sets > 1
    assert found.jump <= 1e-5
    if priced_twist:
        assert found.share <= 1.0 + 1e-9


def tilted(law, tilt):
    """Rates in the start of example 2 with all rolls tilted."""
    q = np.deg2rad([0.0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0])
    q[::2] += tilt
    J = sr.arms.nasa_modular().jacobian(q)
    return law.solve(J, np.array([0.0, 6, 0, 0, 0, 0]), sr.Bounds.symmetric(LIMIT, n=11))


def test_the_bare_optimum_flips_a_joint_for_next_to_nothing_and_a_price_cures_it(capsys):
    bare = [tilted(BARE, tilt) for tilt in (-1e-6, 1e-6)]
    damped = [tilted(PRICED, tilt) for tilt in (-1e-6, 1e-6)]
    j4 = np.rad2deg([[answer.rates[3] for answer in pair] for pair in (bare, damped)])
    with capsys.disabled():
        print(f"\n  j4 at rolls of -1e-6 and 1e-6 rad [deg/s]: bare {j4[0].round(3)}, with a price {j4[1].round(3)}")
    assert np.allclose(np.sort(j4[0]), [-50.0, 50.0])
    assert abs(bare[0].task_error - bare[1].task_error) < 1e-5
    assert np.max(np.abs(damped[0].rates - damped[1].rates)) < 1e-3


def test_a_walk_sees_a_jump():
    arm = sr.arms.nasa_modular()

    def across_the_flip(t):
        q = np.deg2rad([0.0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0])
        q[::2] += 2e-3 * (t - 0.4999)
        return arm.jacobian(q), np.array([0.0, 6, 0, 0, 0, 0]), np.full(11, -LIMIT), np.full(11, LIMIT)

    assert walk(BARE, across_the_flip).jump > 1.0
    assert walk(PRICED, across_the_flip).jump < 1e-6
