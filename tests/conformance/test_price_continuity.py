"""How far the default law's rates move with what it is asked: the moduli of continuity, and what changes nothing.

10,000 pairs of neighbouring problems, 1,000,000 with STILLREACH_FULL=1.
"""

import itertools
import os

import numpy as np
import pytest

import stillreach as sr
from oracles.price import EPS, PriceCase, price_case, price_cases, typical_rate
from stillreach import _core
from tests.robots.catalogue import ROBOTS

PAIRS = 1_000_000 if os.environ.get("STILLREACH_FULL") else 10_000
NEIGHBOURS = 50
"""Of each problem, a kind."""
TIGHT = 1e-9
PARTS = {
    "one part": ((tuple(range(6)), 80.0),),
    "two parts": (((0, 1, 2), 80.0), ((3, 4, 5), 8.0)),
    "three parts": (((0, 1, 2), 80.0), ((3, 4), 8.0), ((5,), 500.0)),
}
NAMES = ("vx", "vy", "vz", "wx", "wy", "wz")


def core(parts):
    """The law of these parts, for a length of 1 m."""
    price = 80.0 if len(parts) == 1 else {" ".join(NAMES[r] for r in rows): price for rows, price in parts}
    return sr.LeastError(price=price).core(reach=1.0)


def norms(rows):
    return np.linalg.norm(np.atleast_2d(rows), axis=1)


class Problem:
    """A problem whose typical rate stays while one of its numbers moves; answers from cold."""

    def __init__(self, case: PriceCase, parts):
        self.case, self.law = case, core(parts)
        b = typical_rate(case.lower, case.upper)
        self.typical, self.prices = b, [(list(rows), b * price) for rows, price in parts]
        self.metric = sr.Weights().metric([True] * 3 + [False] * 3, [False] * len(case.lower))

    def ask(self, **change):
        j, x, lower, upper, reference = (
            change.get(name, getattr(self.case, name)) for name in ("j", "x", "lower", "upper", "reference")
        )
        return _core.solve(self.law, self.metric, j, x, lower, upper, reference, None, self.typical).rates

    def rounding(self, rates):
        """Of sum Y_g |e_g|, for rates (k, n) each."""
        j, x = self.case.j, self.case.x
        sizes = ((y, np.linalg.norm(x[r]), np.linalg.norm(j[r], 2)) for r, y in self.prices)
        return 64.0 * EPS * sum(y * (a + b * norms(rates)) for y, a, b in sizes)


def of_twist(problem, rng):
    """Neighbours' rates, and the squares of the moduli."""
    x, size = problem.case.x, np.linalg.norm(problem.case.x) + 1e-300
    moves = rng.normal(size=(NEIGHBOURS, 6)) * size * 10.0 ** rng.uniform(-9.0, 0.0, (NEIGHBOURS, 1))
    rates = np.array([problem.ask(x=x + move) for move in moves])
    return rates, 2.0 * sum(y * norms(moves[:, r]) for r, y in problem.prices)


def of_jacobian(problem, rng):
    j, here = problem.case.j, np.linalg.norm(problem.ask())
    moves = rng.normal(size=(NEIGHBOURS, *j.shape)) * np.linalg.norm(j) / np.sqrt(j.size)
    moves *= 10.0 ** rng.uniform(-9.0, -0.5, (NEIGHBOURS, 1, 1))
    rates = np.array([problem.ask(j=j + move) for move in moves])
    most = np.maximum(norms(rates), here)
    return rates, 2.0 * sum(y * np.linalg.norm(moves[:, r], 2, axis=(1, 2)) * most for r, y in problem.prices)


def of_reference(problem, rng):
    reference = problem.case.reference
    moves = rng.normal(size=(NEIGHBOURS, len(reference))) * 10.0 ** rng.uniform(-9.0, 0.5, (NEIGHBOURS, 1))
    rates = np.array([problem.ask(reference=reference + move) for move in moves])
    return rates, norms(moves) ** 2


def of_bounds(problem, rng):
    """Bounds that move, also until joints are shut, or opened."""
    case, rates, squares = problem.case, [], []
    lipschitz = sum(y * np.linalg.norm(case.j[r], 2) for r, y in problem.prices)
    here = np.linalg.norm(problem.ask() - case.reference)
    for size in 10.0 ** rng.uniform(-9.0, 0.0, NEIGHBOURS):
        sides = rng.normal(size=(2, len(case.lower))) * size * (rng.random(len(case.lower)) < rng.choice([0.2, 1.0]))
        lower, upper = np.sort([case.lower + sides[0], case.upper + sides[1]], axis=0)
        shut = rng.random(len(lower)) < 0.2
        near = shut & (case.upper - case.lower < 10.0 * size)
        upper[near] = lower[near]
        ends = [np.where(a == b, 0.0, a - b) for a, b in ((lower, case.lower), (upper, case.upper))]
        move = np.linalg.norm(np.max(np.abs(ends), axis=0))
        rates.append(problem.ask(lower=lower, upper=upper))
        most = lipschitz + max(here, np.linalg.norm(rates[-1] - case.reference)) + move
        squares.append((move + np.sqrt(2.0 * most * move)) ** 2)
    return np.array(rates), np.array(squares)


KINDS = {"twist": of_twist, "Jacobian": of_jacobian, "reference": of_reference, "bounds": of_bounds}


@pytest.mark.timeout(3600)
@pytest.mark.filterwarnings("ignore:invalid value encountered in subtract")  # infinite bounds that do not move
@pytest.mark.parametrize("parts", PARTS)
@pytest.mark.parametrize("kind", KINDS)
def test_rates_move_no_further_than_the_modulus(kind, parts, capsys):
    rng = np.random.default_rng([17, list(KINDS).index(kind), len(PARTS[parts])])
    wanted, largest, pairs = PAIRS / (len(KINDS) * len(PARTS)), 0.0, 0
    for number in itertools.count():
        case = price_case(18, number, hostile=number % 2 == 1)
        if pairs >= wanted:
            break
        if not typical_rate(case.lower, case.upper) > 0.0:
            continue
        problem = Problem(case, PARTS[parts])
        here = problem.ask()
        there, square = KINDS[kind](problem, rng)
        moved, noise = norms(there - here) ** 2, 4.0 * (problem.rounding(there) + problem.rounding(here))
        over = moved > square * (1.0 + TIGHT) ** 2 + noise
        assert not np.any(over), (case.label, number, np.flatnonzero(over), moved[over], square[over], noise[over])
        clear = square > 1e6 * noise
        pairs += len(moved)
        if np.any(clear):
            largest = max(largest, np.sqrt(np.max(moved[clear] / square[clear])))
    with capsys.disabled():
        print(f"\n  {kind}, {parts}: {pairs} pairs, at most {largest:.4f} of the modulus", end="")
    assert 0.01 < largest <= 1.0 + TIGHT


@pytest.mark.parametrize("weak", [1.0, 1e-2, 1e-4])
def test_the_modulus_in_the_twist_is_attained(weak):
    """One joint at the twist that it does for its price, and at the opposite: 2 weak Y apart, for 2 weak^2 Y."""
    price = 80.0 * 2.0
    ask = lambda x: sr.LeastError().solve([[weak]], [x], sr.Bounds([-np.inf], [np.inf]), row_kinds="w").rates[0]  # noqa: E731
    x = weak**2 * price
    assert ask(x) - ask(-x) == pytest.approx(np.sqrt(2.0 * price * 2.0 * x), rel=1e-12)
    assert ask(3.0 * x) == pytest.approx(ask(x), rel=1e-12)


def test_the_weakest_direction_attains_it_too():
    for case in price_cases(40, 19, hostile=False):
        n = len(case.lower)
        left, sigma, _ = np.linalg.svd(case.j)
        most = 80.0 * 2.0
        x = sigma[-1] ** 2 * most * left[:, -1]
        rates = [sr.LeastError().solve(case.j, s * x, sr.Bounds.symmetric(np.inf, n=n)).rates for s in (1.0, -1.0)]
        modulus = np.sqrt(2.0 * most * 2.0 * np.linalg.norm(x))
        assert np.linalg.norm(rates[0] - rates[1]) <= modulus * (1.0 + TIGHT)
        assert np.linalg.norm(rates[0] - rates[1]) == pytest.approx(modulus, rel=1e-6), case.label


@pytest.mark.parametrize("price", [80.0, (80.0, 8.0)])
@pytest.mark.parametrize("factor", [1e-6, 0.3, 1e4])
def test_twist_bounds_and_reference_times_a_number(price, factor):
    """Where all limits are finite; what an infinite one counts as does not grow with the others."""
    law, used = sr.LeastError(price=price), 0
    for case in price_cases(150, 20, hostile=False):
        if not (np.all(np.isfinite(case.lower)) and np.all(np.isfinite(case.upper))):
            continue
        ask = lambda s, case=case: law.solve(  # noqa: E731
            case.j, s * case.x, sr.Bounds(s * case.lower, s * case.upper), reference=s * case.reference, length=1.0
        )
        one, many = ask(1.0), ask(factor)
        size = np.linalg.norm(one.rates) + 1e-300
        noise = 128.0 * EPS * 80.0 * typical_rate(case.lower, case.upper)
        noise *= np.linalg.norm(case.x) + np.linalg.norm(case.j) * size
        assert np.linalg.norm(many.rates / factor - one.rates) <= np.sqrt(noise) + 1e-12 * size, case.label
        used += 1
    assert used > 60


def test_parts_do_not_depend_on_the_unit_of_length():
    """A Jacobian in millimetres, a length in millimetres; and the same said by the weights."""
    law, milli = sr.LeastError(price=(80.0, 8.0)), np.array([1e3, 1e3, 1e3, 1.0, 1.0, 1.0])
    for case in price_cases(40, 21, hostile=False):
        bounds, near = sr.Bounds(case.lower, case.upper), case.reference
        metres = law.solve(case.j, case.x, bounds, reference=near, length=0.9)
        small = law.solve(milli[:, None] * case.j, milli * case.x, bounds, reference=near, length=900.0)
        weights = sr.LeastError(price=(80.0, 8.0), weights=sr.Weights(length=1e-3))
        told = weights.solve(case.j, case.x, bounds, reference=near, length=0.9)
        size = np.linalg.norm(metres.rates) + 1e-300
        noise = 128.0 * EPS * 80.0 * typical_rate(case.lower, case.upper) / 0.9
        noise *= np.linalg.norm(case.x) + np.linalg.norm(case.j) * size
        for other in (small, told):
            assert np.linalg.norm(other.rates - metres.rates) <= np.sqrt(noise) + 1e-12 * size, case.label


TYPICAL = {
    "Panda": (ROBOTS["Panda"].make, 2.61, 2.61),  # 2.175 four times, 2.61 three times
    "iiwa 14": (ROBOTS["iiwa 14"].make, np.deg2rad(135.0), 2.36),  # 85, 85, 100, 75, 130, 135, 135 deg/s
    "paper": (sr.arms.nasa_modular, np.deg2rad(50.0), 0.873),
    "Canadarm2": (sr.arms.canadarm2, np.deg2rad(4.0), 0.0698),
}


@pytest.mark.parametrize("name", TYPICAL)
def test_what_a_rate_is_worth(name):
    """An unreachable twist has the multiplier at its price: 80 b."""
    make, exact, printed = TYPICAL[name]
    arm = make()
    limits = {"velocity_limits": np.deg2rad(50.0)} if name == "paper" else {}
    b = worth(arm, **limits)
    assert b == pytest.approx(exact, rel=2e-3)
    assert float(f"{b:.3g}") == printed


def worth(arm, prepare=lambda ctl: None, q=None, **settings):
    """b, as the first tick of a controller counts it."""
    ctl = sr.Controller(arm, transition_rate=0.0, **settings)
    prepare(ctl)
    out = ctl.step(np.full(arm.n, 0.1) if q is None else q, 1e3 * np.ones(6))
    assert sr.Status.DAMPED in out.status
    return np.linalg.norm(out.multiplier) / 80.0


def test_b_is_the_second_largest_limit_of_the_working_joints():
    arm = sr.arms.nasa_modular()
    limits = np.array([1.0, 0.2, 3.0, 0.3, 0.4, 0.5, 2.0, 0.1, 0.6, 0.7, 0.8])
    assert worth(arm, velocity_limits=limits) == pytest.approx(2.0)
    limits[4] = 1e4
    assert worth(arm, velocity_limits=limits) == pytest.approx(3.0)
    limits[4] = 0.4
    assert worth(arm, lambda ctl: ctl.fail("j7"), velocity_limits=limits) == pytest.approx(1.0)
    assert worth(arm, lambda ctl: ctl.fail("j3", sr.Derated(0.5)), velocity_limits=limits) == pytest.approx(1.5)
    assert worth(arm, lambda ctl: ctl.fail("j3", sr.Runaway(0.5)), velocity_limits=limits) == pytest.approx(1.0)

    def all_but_two(ctl, last="j2"):
        for joint in set(arm.joint_names) - {"j8", last}:
            ctl.fail(joint)

    def all_but_one(ctl):
        all_but_two(ctl)
        ctl.fail("j2")

    assert worth(arm, all_but_two, velocity_limits=limits) == pytest.approx(0.1)
    assert worth(arm, all_but_one, velocity_limits=limits) == pytest.approx(0.1)
    limits[[2, 6]] = np.inf
    assert worth(arm, velocity_limits=limits) == pytest.approx(2.0)


def test_the_windows_of_a_tick_do_not_say_what_a_rate_is_worth():
    arm = sr.arms.nasa_modular()
    settings = {"velocity_limits": 0.8, "period": 0.002}
    assert worth(arm, acceleration_limits=10.0, **settings) == pytest.approx(0.8)
    assert worth(arm, position_limits=(-0.1 - 1e-5, 0.1 + 1e-5), **settings) == pytest.approx(0.8)


def test_one_generous_joint_does_not_switch_the_damping_off():
    arm, twist, q = sr.arms.nasa_modular(), np.array([3.0, 1.0, 2.0, 0.5, -1.0, 2.0]), np.linspace(-1.0, 1.0, 11)
    limits = np.full(11, np.deg2rad(50.0))
    usual = sr.Controller(arm, velocity_limits=limits).step(q, twist)
    still = int(np.flatnonzero(np.abs(usual.rates) < 0.9 * limits)[0])
    limits[still] = 1e4
    generous = sr.Controller(arm, velocity_limits=limits).step(q, twist)
    np.testing.assert_allclose(generous.rates, usual.rates, atol=1e-12)
    assert generous.damping == pytest.approx(usual.damping, rel=1e-9)
    assert usual.damping > 0.0


@pytest.mark.parametrize("make", [sr.arms.nasa_modular, sr.arms.canadarm2, ROBOTS["Panda"].make])
def test_an_arm_with_one_working_joint_moves(make):
    """It goes as fast as the twist wants: the best of one joint, by hand."""
    arm = make()
    q = np.linspace(-0.5, 0.7, arm.n)
    for working in range(arm.n):
        ctl = sr.Controller(arm, transition_rate=0.0, velocity_limits=0.5, position_limits=(-np.inf, np.inf))
        for joint in set(range(arm.n)) - {working}:
            ctl.fail(joint)
        column = arm.jacobian(q)[:, working]
        out = ctl.step(q, 0.2 * column)
        assert out.rates[working] == pytest.approx(0.2, rel=1e-12)
        other = np.linalg.svd(column[:, None])[0][:, 1]
        out = ctl.step(q, 5.0 * column + 0.1 * other)
        assert out.rates[working] == pytest.approx(0.5)
