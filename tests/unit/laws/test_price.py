"""LeastError with a price: a certificate in 50 digits, other solvers, weights, parts, and what a price may be.

STILLREACH_FULL=1 shows the certificate 20,000 cases of one part and 5,000 of several.
"""

import os

import numpy as np
import pytest

import stillreach as sr
from oracles.price import by_damping, by_reweighting, certificate, price_cases, typical_rate
from stillreach import Status

FULL = bool(os.environ.get("STILLREACH_FULL"))
ONE_PART, SEVERAL_PARTS = (20_000, 5_000) if FULL else (300, 150)
ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")
WHOLE = range(6)


def answer(law, case, **kwargs):
    return law.solve(case.j, case.x, sr.Bounds(case.lower, case.upper), reference=case.reference, **kwargs)


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


def definite(rng, count):
    a = rng.normal(size=(count, count))
    return a @ a.T + 0.1 * np.eye(count)


def blocks(rng, groups):
    """(6, 6) positive definite, without weights between groups."""
    full = np.zeros((6, 6))
    for rows in groups:
        full[np.ix_(rows, rows)] = definite(rng, len(rows))
    return full


def optimality(case, out, weights, kinds, parts):
    """What a minimum has to fulfil (Karush, Kuhn, Tucker), relative to the terms' size: stationarity, parts.

    parts: (rows, price in the units of the weights).
    """
    rows = np.array([weights.length] * 3 + [weights.angle] * 3)
    units = np.where(np.array(list(kinds)) == "P", weights.length, weights.angle)
    diagonal = lambda w, count: np.eye(count) if w is None else np.diag(w) if w.ndim == 1 else w  # noqa: E731
    factor = np.linalg.cholesky(diagonal(weights.task, 6)).T / rows
    inertia = diagonal(weights.joints, len(kinds)) / np.outer(units, units)
    limits = np.sqrt(np.diag(inertia)) * np.where(np.isfinite(case.upper - case.lower), 1.0, np.inf)
    limits = np.where(
        np.isfinite(limits), limits * np.maximum(-case.lower, case.upper), 2.0 * np.sqrt(np.diag(inertia))
    )
    limits = np.sort(limits[case.lower < case.upper])[::-1]
    b = limits[1] if len(limits) > 1 else limits[0]
    force = case.j.T @ out.multiplier - inertia @ (out.rates - case.reference)
    size = np.abs(case.j.T) @ np.abs(out.multiplier) + np.abs(inertia) @ np.abs(out.rates - case.reference) + 1e-300
    works = case.lower < case.upper
    wrong = np.abs(force) / np.max(size)
    wrong[out.rates == case.upper] = np.maximum(-force, 0.0)[out.rates == case.upper] / np.max(size)
    wrong[out.rates == case.lower] = np.maximum(force, 0.0)[out.rates == case.lower] / np.max(size)
    u, e = np.linalg.solve(factor.T, out.multiplier), factor @ (case.x - case.j @ out.rates)
    scale = np.linalg.norm(factor @ case.x) + np.linalg.norm(factor @ case.j, 2) * np.linalg.norm(out.rates)
    lost = 0.0
    for group, price in parts:
        group = list(group)
        assert np.linalg.norm(u[group]) <= price * b * (1.0 + 1e-12), case.label
        lost = max(lost, (price * b * np.linalg.norm(e[group]) - u[group] @ e[group]) / (price * b * scale))
    return np.max(wrong[works]), lost


PARTS = {
    "one": (80.0, [(tuple(range(6)), 80.0)]),
    "two": ((60.0, 5.0), [((0, 1, 2), "v"), ((3, 4, 5), 5.0)]),
    "three": ({"vx vy": 60.0, "vz wx": 9.0, "wy wz": 3.0}, [((0, 1), "v"), ((2, 3), 9.0), ((4, 5), 3.0)]),
}


@pytest.mark.parametrize("name", PARTS)
@pytest.mark.parametrize("joints", ["none", "diagonal", "full"])
@pytest.mark.parametrize("task", ["none", "diagonal", "full"])
def test_weights_and_units_are_those_of_the_minimum(name, joints, task):
    rng = np.random.default_rng([9, len(name), len(joints), len(task)])
    price, parts = PARTS[name]
    used = 0
    for number, case in enumerate(price_cases(30, 10, hostile=False)):
        n, length = len(case.lower), float(10.0 ** rng.uniform(-0.5, 0.5))
        if not np.any(case.lower < case.upper):
            continue
        weights = sr.Weights(
            length=(1.0, 0.3)[number % 2],
            angle=(1.0, 1.0, 0.5)[number % 3],
            task={"none": None, "diagonal": rng.uniform(0.2, 5.0, 6), "full": blocks(rng, [r for r, _ in parts])}[task],
            joints={"none": None, "diagonal": rng.uniform(0.2, 5.0, n), "full": definite(rng, n)}[joints],
        )
        kinds = "".join(rng.choice(["R", "R", "P"], n))
        out = answer(sr.LeastError(price=price, weights=weights), case, joint_kinds=kinds, length=length)
        own = [(rows, 60.0 * weights.length / (length * weights.angle) if y == "v" else y) for rows, y in parts]
        wrong, lost = optimality(case, out, weights, kinds, own)
        assert wrong <= 1e-9, (case.label, wrong)
        assert lost <= 1e-10, (case.label, lost)
        used += 1
    assert used > 20


@pytest.mark.parametrize("price", [80.0, (100.0, 8.0), "position-first"])
def test_the_rates_are_the_multiplier_cut_to_the_bounds(price):
    rng = np.random.default_rng(11)
    for case in price_cases(60, 12, hostile=False):
        n = len(case.lower)
        weights = sr.Weights(length=0.3, angle=0.5, joints=rng.uniform(0.2, 5.0, n), task=rng.uniform(0.2, 5.0, 6))
        kinds = "".join(rng.choice(["R", "P"], n))
        out = answer(sr.LeastError(price=price, weights=weights), case, joint_kinds=kinds, length=1.0)
        inverse = np.where(np.array(list(kinds)) == "P", 0.3, 0.5) ** 2 / weights.joints
        free = case.reference + inverse * (case.j.T @ out.multiplier)
        size = np.max(np.abs(case.reference) + inverse * (np.abs(case.j.T) @ np.abs(out.multiplier)), initial=1e-300)
        np.testing.assert_allclose(out.rates / size, np.clip(free, case.lower, case.upper) / size, atol=1e-10)


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


def test_a_row_that_cannot_be_served_costs_the_others_nothing_in_a_part_of_its_own():
    j = np.vstack((np.random.default_rng(2).normal(size=(5, 7)), np.zeros(7)))
    x, bounds = np.array([0.02, 0.01, 0.0, 0.03, 0.02, 0.5]), sr.Bounds.symmetric(1.0, n=7)
    apart = sr.LeastError(price={"position wx wy": 80.0, "wz": 80.0}).solve(j, x, bounds)
    assert np.linalg.norm(apart.residual[:5]) < 1e-14
    assert apart.residual[5] == 0.5
    together = sr.LeastError().solve(j, x, bounds)
    assert np.linalg.norm(together.residual[:5]) > 1e-6
    x[5] = 0.0
    assert np.linalg.norm(sr.LeastError().solve(j, x, bounds).residual) < 1e-14


def test_prices_in_the_axes_of_the_tool():
    arm = sr.arms.nasa_modular()
    law = sr.LeastError(price={"position": 100.0, "wx wy": 8.0, "wz": 1.0})
    limit, q = np.deg2rad(50.0), np.random.default_rng(5).uniform(-1.5, 1.5, arm.n)
    twist = np.array([1.0, 2.0, -1.0, 0.5, -1.0, 2.0])
    ctl = sr.Controller(arm, law=law, task=sr.Task(frame="tool"), rate_limits=limit)
    out = ctl.step(q, twist)
    turn = np.kron(np.eye(2), arm.forward(q)[:3, :3].T)
    bounds = sr.Bounds.symmetric(limit, n=arm.n)
    expected = law.solve(turn @ arm.jacobian(q), turn @ twist, bounds, length=arm.reach)
    np.testing.assert_allclose(out.rates, expected.rates, atol=1e-10)
    base = law.solve(arm.jacobian(q), twist, bounds, length=arm.reach)
    assert np.max(np.abs(base.rates - out.rates)) > 1e-3


def test_rows_left_out_of_the_task_need_no_price():
    arm = sr.arms.nasa_modular()
    q, twist = np.linspace(-1.0, 1.0, 11), np.array([1.0, 2.0, -1.0, 0.5, -1.0, 2.0])
    rows = sr.Task(rows=(True, True, True, True, True, False))
    all_named = sr.LeastError(price={"position": 100.0, "wx wy": 8.0, "wz": 1.0})
    named = sr.LeastError(price={"position": 100.0, "wx wy": 8.0})
    ask = lambda law: sr.Controller(arm, law=law, task=rows, rate_limits=0.5).step(q, twist).rates  # noqa: E731
    assert np.array_equal(ask(all_named), ask(named))
    with pytest.raises(sr.InputError, match="wz"):
        sr.Controller(arm, law=named, rate_limits=0.5)


def test_one_part_of_v_rows_is_priced_per_reach():
    rng = np.random.default_rng(8)
    j, x, bounds = rng.normal(size=(3, 5)), 20.0 * rng.normal(size=3), sr.Bounds.symmetric(0.7, n=5)
    pair = sr.LeastError(price=(100.0, 8.0)).solve(j, x, bounds, row_kinds="vvv", length=4.0)
    word = sr.LeastError(price={"position": 100.0}).solve(j, x, bounds, row_kinds="vvv", length=4.0)
    number = sr.LeastError(price=25.0).solve(j, x, bounds, row_kinds="vvv")
    assert np.array_equal(pair.rates, number.rates)
    assert np.array_equal(word.rates, number.rates)
    turning = sr.LeastError(price=(100.0, 8.0)).solve(j, x, bounds, row_kinds="www")
    assert np.array_equal(turning.rates, sr.LeastError(price=8.0).solve(j, x, bounds, row_kinds="www").rates)


def test_a_mapping_and_a_pair_are_the_same_prices():
    pair = sr.LeastError(price=(70.0, 8.0))
    words = sr.LeastError(price={"orientation": 8, "position": 70})
    names = sr.LeastError(price={"wz  wx wy": 8.0, "vx vy vz": 70.0})
    for case in price_cases(20, 13, hostile=False):
        rates = [answer(law, case, length=0.9).rates for law in (pair, words, names)]
        np.testing.assert_allclose(rates[1], rates[0], atol=1e-9)
        np.testing.assert_allclose(rates[2], rates[0], atol=1e-9)


def ceiling_problem(case):
    """Whether position first keeps its ceiling, by the objective's own terms: see the test."""
    b = typical_rate(case.lower, case.upper)
    out = answer(sr.LeastError(price="position-first"), case, length=1.0)
    plain = answer(sr.LeastError(price=(100.0, 8.0)), case, length=1.0)
    beyond = answer(sr.LeastError(price=(100.0, 80.0)), case, length=1.0)
    attitude = [float(np.linalg.norm(a.residual[3:])) for a in (plain, out, beyond)]
    return out, plain, beyond, attitude, 0.25 * b


def test_position_first_buys_attitude_up_to_its_ceiling():
    seen = {"below": 0, "at": 0, "beyond": 0}
    for case in price_cases(200, 14, hostile=False):
        out, plain, beyond, (free, mine, dear), ceiling = ceiling_problem(case)
        if ceiling == 0.0:
            continue
        if free <= ceiling:
            seen["below"] += 1
            np.testing.assert_allclose(out.rates, plain.rates, atol=1e-12, err_msg=case.label)
        elif dear >= ceiling:
            seen["beyond"] += 1
            np.testing.assert_allclose(out.rates, beyond.rates, rtol=1e-7, atol=1e-7, err_msg=case.label)
        else:
            seen["at"] += 1
            assert mine == pytest.approx(ceiling, rel=1e-9), case.label
            price = np.linalg.norm(out.multiplier[3:])
            own = [((0, 1, 2), 400.0 * ceiling), ((3, 4, 5), price)]
            assert 32.0 * ceiling < price < 320.0 * ceiling
            found = certificate(case, own, out.rates, out.multiplier)
            assert found.gap <= 1e-9 * found.objective, case.label
    assert min(seen.values()) > 5, seen


WRONG = {
    "zero": (0.0, "above 0"),
    "negative": (-1.0, "above 0"),
    "nan": (float("nan"), "price"),
    "infinite": (float("inf"), "price"),
    "a word": ("attitude-first", "position-first"),
    "one of a pair": ((80.0,), "pair"),
    "three": ((1.0, 2.0, 3.0), "pair"),
    "a pair with 0": ((80.0, 0.0), "above 0"),
    "a pair with None": ((80.0, None), "price"),
    "no rows": ({}, "1 to 3 parts"),
    "four parts": ({"vx": 1.0, "vy": 1.0, "vz": 1.0, "orientation": 1.0}, "1 to 3 parts"),
    "an unknown row": ({"vq": 1.0}, "vq"),
    "a row twice": ({"position": 1.0, "vx wx": 1.0}, "each row once"),
    "a row twice in a word": ({"vx vx": 1.0}, "each row once"),
    "an empty name": ({"": 1.0}, "names of rows"),
    "a number for a name": ({3: 1.0}, "names of rows"),
    "a price that is a word": ({"position": "dear"}, "price"),
    "a truth value": (True, "price"),
    "an array": (np.ones(2), "price"),
}


@pytest.mark.parametrize(("price", "words"), WRONG.values(), ids=WRONG)
def test_a_wrong_price_is_refused(price, words):
    with pytest.raises(sr.InputError, match=words) as caught:
        sr.LeastError(price=price)
    assert "price" in str(caught.value)


def test_what_only_the_task_shows_to_be_wrong_is_refused_there():
    j, x, bounds = np.eye(6, 7), np.ones(6), sr.Bounds.symmetric(1.0, n=7)
    with pytest.raises(sr.InputError, match="length"):
        sr.LeastError(price=(80.0, 8.0)).solve(j, x, bounds)
    with pytest.raises(sr.InputError, match="length"):
        sr.LeastError(price=(80.0, 8.0)).solve(j, x, bounds, length=0.0)
    with pytest.raises(sr.InputError, match="no price for the row wz"):
        sr.LeastError(price={"position": 80.0, "wx wy": 8.0}).solve(j, x, bounds, length=1.0)
    with pytest.raises(sr.InputError, match="no price for the row w"):  # of kinds, not of names
        sr.LeastError(price={"position": 80.0, "wx wy": 8.0, "wz": 1.0}).solve(
            j[:4], x[:4], bounds, row_kinds="vvvw", length=1.0
        )
    coupled = sr.Weights(task=definite(np.random.default_rng(1), 6))
    with pytest.raises(sr.InputError, match=r"weights\.task"):
        sr.LeastError(price=(80.0, 8.0), weights=coupled).solve(j, x, bounds, length=1.0)
    assert np.all(np.isfinite(sr.LeastError(weights=coupled).solve(j, x, bounds).rates))


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
