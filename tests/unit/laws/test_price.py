"""LeastError with a price: a certificate in 50 digits, other solvers, one joint by hand, what a rate is worth.

STILLREACH_FULL=1 shows the certificate 20,000 cases of one part and 5,000 of several.
"""

import os

import numpy as np
import pytest

import stillreach as sr
from oracles.price import PriceCase, by_damping, by_reweighting, certificate, price_cases, typical_rate
from stillreach import Status
from tests.adversarial import change_faults
from tests.conformance.attack import SEGMENT, attack
from tests.unit.laws.priced import answer

FULL = bool(os.environ.get("STILLREACH_FULL"))
ONE_PART, SEVERAL_PARTS = (20_000, 5_000) if FULL else (300, 150)
ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")
WHOLE = range(6)


def judged(case, parts, out, law):
    """The certificate of an answer, after the facts that hold to the last digit."""
    assert np.all((case.lower <= out.rates) & (out.rates <= case.upper)), case.label
    assert Status.ITERATION_LIMIT not in out.status, case.label
    for rows, most in parts:
        assert np.linalg.norm(out.multiplier[list(rows)]) <= most * (1.0 + 1e-14), (case.label, law)
    return certificate(case, parts, out.rates, out.multiplier)


def share(found):
    return found.gap / (1e-12 * found.objective + 64.0 * found.rounding + 1e-300)


@pytest.mark.timeout(1200)
def test_the_gap_to_a_dual_point_is_rounding(capsys):
    worst, exact, damped = 0.0, 0, 0
    for number, case in enumerate(price_cases(ONE_PART, 1)):
        price = (80.0, 80.0, 8.0, 1000.0)[number % 4]
        out = answer(sr.LeastError(price=price), case)
        found = judged(case, [(WHOLE, price * typical_rate(case.lower, case.upper))], out, price)
        assert found.optimal, (case.label, price, found)
        worst = max(worst, share(found))
        damped += out.damping > 0.0
        exact += out.damping == 0.0
    with capsys.disabled():
        print(f"\n  {exact} exact, {damped} damped, largest gap {worst:.3f} of what is allowed", end="")
    assert min(exact, damped) > ONE_PART // 20


def partition(rng):
    """Two or three parts of the six rows as (price as the law takes it, rows and prices a part, length)."""
    length = float(10.0 ** rng.uniform(-0.5, 0.5))
    prices = 10.0 ** rng.uniform(-0.5, 3.0, 3)
    if rng.random() < 0.4:
        pair = (float(prices[0]), float(prices[1]))
        return pair, [((0, 1, 2), pair[0] / length), ((3, 4, 5), pair[1])], length
    count = int(rng.integers(2, 4))
    part = np.append(rng.permutation(count), rng.integers(0, count, 6 - count))[rng.permutation(6)]
    groups = [tuple(int(r) for r in np.flatnonzero(part == g)) for g in range(count)]
    mapping = {" ".join(ROWS[r] for r in g): float(y) for g, y in zip(groups, prices, strict=False)}
    return mapping, [(g, y / length if max(g) < 3 else y) for g, y in zip(groups, prices, strict=False)], length


@pytest.mark.timeout(1200)
def test_the_gap_of_several_parts_is_rounding(capsys):
    rng, worst, kinds = np.random.default_rng(3), 0.0, set()
    for case in price_cases(SEVERAL_PARTS, 2):
        price, parts, length = partition(rng)
        b = typical_rate(case.lower, case.upper)
        parts = [(rows, b * y) for rows, y in parts]
        out = answer(sr.LeastError(price=price), case, length=length)
        found = judged(case, parts, out, price)
        assert found.optimal, (case.label, price, length, found)
        worst = max(worst, share(found))
        size = [np.linalg.norm(case.x[list(rows)]) + np.linalg.norm(case.j[list(rows)]) for rows, _ in parts]
        done = [np.linalg.norm(out.residual[list(r)]) < 1e-9 * s for (r, _), s in zip(parts, size, strict=True)]
        kinds.add((len(parts), int(sum(done))))
    with capsys.disabled():
        print(f"\n  largest gap {worst:.3f} of what is allowed; (parts, of them exact): {sorted(kinds)}", end="")
    assert {(2, 0), (2, 1), (2, 2), (3, 0), (3, 1), (3, 2), (3, 3)} <= kinds


@pytest.mark.parametrize("price", [80.0, (100.0, 8.0)])
def test_a_search_that_starts_where_the_last_tick_ended_has_no_gap_either(price):
    arm, random, damped = sr.arms.nasa_modular(), np.random.default_rng(23), 0
    limit = np.deg2rad(50.0)
    for _ in range(4):
        ctl = sr.Controller(arm, law=sr.LeastError(price=price), velocity_limits=limit)
        q, along, twist = random.uniform(-1.5, 1.5, (2, 11)), random.uniform(-1.0, 1.0, 11), random.normal(size=6)
        for tick in range(60):
            out = ctl.step(q[0] + 0.02 * tick * along, 1.5 * np.sin(0.1 * tick) * twist)
            case = PriceCase(out.jacobian, out.twist, out.lower, out.upper, np.zeros(11), f"tick {tick}")
            pair = ((0, 1, 2), limit * 100.0 / arm.reach), ((3, 4, 5), limit * 8.0)
            parts = [(WHOLE, 80.0 * limit)] if price == 80.0 else pair
            assert judged(case, parts, out, price).optimal, case.label
            damped += out.damping > 0.0
    assert 40 < damped < 200


def test_a_worse_answer_has_a_gap():
    seen = 0
    for case in price_cases(20, 4, hostile=False):
        parts = [(WHOLE, 80.0 * typical_rate(case.lower, case.upper))]
        out = answer(sr.LeastError(), case)
        width = np.where(np.isfinite(case.upper), 1e-3 * (case.upper - out.rates), 1e-3)
        if np.max(width) == 0.0:
            continue
        assert certificate(case, parts, out.rates, out.multiplier).optimal
        assert not certificate(case, parts, out.rates + width, out.multiplier).optimal, case.label
        assert not certificate(case, parts, out.rates, 0.999 * out.multiplier).optimal, case.label
        seen += 1
    assert seen > 10


def test_other_solvers_have_the_same_rates(capsys):
    """Bounded least squares of SciPy with no damping below 1e-10 of |J|^2, which a weak direction may still feel."""
    apart = {"one part": [], "two parts": []}
    for number, case in enumerate(price_cases(260, 5, hostile=False)):
        b = typical_rate(case.lower, case.upper)
        if b == 0.0:
            assert np.array_equal(answer(sr.LeastError(), case).rates, case.lower)
        elif number < 200:
            theirs, ours = by_damping(case, 80.0 * b), answer(sr.LeastError(), case).rates
            apart["one part"].append(relative(case, ours, theirs))
        else:
            theirs = by_reweighting(case, [((0, 1, 2), 40.0 * b), ((3, 4, 5), 8.0 * b)])
            ours = answer(sr.LeastError(price=(80.0, 8.0)), case, length=2.0).rates
            if theirs is not None:
                apart["two parts"].append(relative(case, ours, theirs))
    with capsys.disabled():
        for name, values in apart.items():
            print(
                f"\n  {name}: {len(values)} compared, median {np.median(values):.1e}, worst {max(values):.1e}", end=""
            )
    assert len(apart["one part"]) > 180
    assert len(apart["two parts"]) > 40
    assert max(apart["one part"]) <= 1e-4
    assert max(apart["two parts"]) <= 1e-3
    assert all(np.quantile(values, 0.7) <= 1e-6 for values in apart.values())


def relative(case, ours, theirs):
    return np.linalg.norm(ours - theirs) / (np.linalg.norm(theirs) + np.linalg.norm(theirs - case.reference))


def test_an_answer_of_another_law_has_no_multiplier():
    for law in (sr.LeastError(price=None), sr.Pseudoinverse(), sr.KeepDirection()):
        out = law.solve(np.eye(6, 7), np.ones(6), sr.Bounds.symmetric(0.5, n=7))
        assert np.array_equal(out.multiplier, np.zeros(6))


def by_hand(j, twist, limit, most):
    """One row and one joint: argmin of most |twist - j r| + r^2 / 2 with |r| <= limit, twist and j above 0."""
    return min(twist / j, most * j, limit)


@pytest.mark.parametrize("j", [1e-3, 0.05, 1.0])
@pytest.mark.parametrize("twist", [1e-6, 0.01, 3.0])
def test_one_joint_by_hand(j, twist):
    for price in (2.0, 80.0):
        out = sr.LeastError(price=price).solve([[j]], [twist], sr.Bounds([-0.5], [0.5]), row_kinds="w")
        rate = by_hand(j, twist, 0.5, price * 0.5)
        assert out.rates[0] == pytest.approx(rate, rel=1e-14)
        damped = 0.0 if rate == twist / j else (twist - j * rate) / (price * 0.5)
        assert out.damping == pytest.approx(damped, rel=1e-9, abs=1e-15)
        assert (Status.DAMPED in out.status) == (damped > 0.0)


def test_velocity_limits_say_what_a_rate_is_worth():
    """The bounds of a tick, narrowed by acceleration limits, do not."""
    rng = np.random.default_rng(6)
    j, x = rng.normal(size=(6, 7)), 3.0 * rng.normal(size=6)
    narrow, limits = sr.Bounds.symmetric(0.01, n=7), np.full(7, 2.0)
    limits[3] = 1e4
    told = sr.LeastError().solve(j, x, narrow, velocity_limits=limits)
    same = sr.LeastError(price=80.0 * 2.0 / 0.01).solve(j, x, narrow)
    np.testing.assert_allclose(told.rates, same.rates, atol=1e-15)
    limits[[0, 1, 2, 4, 5, 6]] = 0.0  # failed: one joint works, and it counts
    one = sr.LeastError().solve(j, x, narrow, velocity_limits=limits)
    np.testing.assert_allclose(one.rates, sr.LeastError(price=80.0 * 1e4 / 0.01).solve(j, x, narrow).rates, atol=1e-15)


def test_one_generous_limit_moves_nothing_even_where_the_gap_is_closed_before_the_last_step():
    arm, rng, moved = sr.arms.canadarm2(), np.random.default_rng(30), []
    lower, upper = np.clip(arm.position_limits, -np.pi, np.pi).T
    limits = np.array(arm.velocity_limits)
    poses, twists = rng.uniform(lower, upper, (500, arm.n)), np.random.default_rng([31, 6]).normal(size=(500, 6))
    twists *= (arm.reach * limits[0] / 5.0 / np.linalg.norm(twists[:, :3], axis=1))[:, None]
    for j, twist in zip(arm.jacobian(poses), twists, strict=True):
        usual = sr.LeastError().solve(j, twist, sr.Bounds(-limits, limits))
        inside = np.flatnonzero(np.abs(usual.rates) < limits)
        if not inside.size:
            continue
        generous = np.where(np.arange(arm.n) == inside[0], 1e4, limits)
        other = sr.LeastError().solve(j, twist, sr.Bounds(-generous, generous))
        moved.append(float(np.max(np.abs(other.rates - usual.rates) / limits)))
    assert len(moved) > 400
    assert max(moved) <= 1e-12


AT_A_BOUND = {  # ten times J, and the rates that do the twist, one of them the limit, 1 rad/s
    "two joints": ([[0, -3], [9, -8], [-1, -4], [9, -7], [0, 6], [0, 0]], [-1.0, -0.2]),
    "two others": ([[5, 6], [-6, -2], [9, 7], [5, -2], [0, 0], [-6, 0]], [1.0, -0.8]),
    "three": ([[1, -3, -8], [0, 1, -6], [-1, -3, 2], [6, 3, 2], [3, 9, 1], [-4, 4, -4]], [0.9, 1.0, -0.8]),
    "five": (
        [
            [6, -9, -2, 3, 7],
            [5, 9, 8, 9, 3],
            [-8, 3, 6, 1, -6],
            [2, 6, -9, 6, 9],
            [-4, -7, 2, 7, -5],
            [9, -7, -4, 1, 0],
        ],
        [-1.0, -0.7, 0.0, 0.6, 0.5],
    ),
}


@pytest.mark.parametrize("name", AT_A_BOUND)
def test_a_twist_that_needs_a_joint_just_at_its_bound_settles(name):
    rows, rates = AT_A_BOUND[name]
    j, n = np.array(rows) / 10.0, len(rates)
    case = PriceCase(j, j @ rates, np.full(n, -1.0), np.full(n, 1.0), np.zeros(n), name)
    out = answer(sr.LeastError(), case)
    assert judged(case, [(WHOLE, 80.0)], out, 80.0).optimal
    np.testing.assert_allclose(out.rates, rates, atol=1e-9)


def test_a_twist_too_small_to_scale_is_none():
    J = np.random.default_rng(5).normal(size=(6, 7))
    for size in (5e-324, 1e-310, 1e-295):
        out = sr.LeastError().solve(J, size * np.ones(6), sr.Bounds.symmetric(1.0, n=7))
        assert not out.rates.any(), size
        assert out.status == Status.OK, size


@pytest.mark.parametrize("block", [4, 117, 217, 335, 376])
def test_no_hostile_tick_takes_many_steps(block):
    told = attack([0, block], 250)
    controller = told.controller(sr.LeastError())
    for tick in range(250):
        if tick % SEGMENT == 0:
            change_faults(controller, told, tick)
        if np.isfinite([*told.q[tick], *told.twist[tick]]).all():
            assert controller.step(told.q[tick], told.twist[tick]).iterations < 100, tick
