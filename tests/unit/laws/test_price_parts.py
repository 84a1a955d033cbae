"""A price for each part of the task: rows, axes, units, and position first."""

import pickle

import numpy as np
import pytest

import stillreach as sr
from oracles.price import PriceCase, certificate, price_cases, typical_rate
from stillreach.laws.price import BEYOND, CEILING, POSITION_FIRST
from tests.unit.laws.priced import answer


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


CONSISTENT = {  # ten times J of two or three joints, the rates that do the twist exactly, prices
    "a third too much": (
        [[-1, -6, 6], [4, 8, 8], [6, 8, 7], [0, -9, 3], [-4, 7, 2], [-1, 4, -9]],
        [-0.4, 0.3, 0.1],
        (1.0, 0.5),
    ),
    "one joint asked": (
        [[-6, 5, 7], [-5, 4, 7], [3, -2, 2], [5, -1, 5], [5, -2, -4], [5, -1, 4]],
        [0.0, -0.5, 0.0],
        (2.0, 2.0),
    ),
    "cheap": (
        [[-1, 8, 4], [1, -5, 6], [-4, -2, -9], [-8, -3, 1], [-7, -6, -8], [-1, -8, -3]],
        [0.5, 0.3, -0.4],
        (1.0, 0.5),
    ),
    "two joints": (
        [[9, 7], [-1, -2], [7, 8], [-5, -5], [3, 9], [5, 3]],
        [0.5, -0.2],
        (2.0, 0.5),
    ),
    "equal prices": (
        [[7, -6, -7], [3, 6, -6], [-6, -8, 3], [-2, 3, 1], [-8, 8, 6], [-9, 7, 7]],
        [0.2, 0.0, 0.3],
        (1.0, 1.0),
    ),
    "two joints, cheap": (
        [[0, -1], [1, 3], [5, 4], [-1, 4], [1, 6], [-6, -1]],
        [0.1, -0.5],
        (1.0, 0.5),
    ),
}


@pytest.mark.parametrize("name", CONSISTENT)
def test_fewer_joints_than_rows_that_do_the_twist_exactly_settle(name):
    rows, rates, price = CONSISTENT[name]
    j, n = np.array(rows) / 10.0, len(rates)
    case = PriceCase(j, j @ rates, np.full(n, -1.0), np.full(n, 1.0), np.zeros(n), name)
    out = answer(sr.LeastError(price=price), case, length=1.0)
    found = certificate(case, [((0, 1, 2), price[0]), ((3, 4, 5), price[1])], out.rates, out.multiplier)
    assert found.optimal, found


def test_prices_in_the_axes_of_the_tool():
    arm = sr.arms.nasa_modular()
    law = sr.LeastError(price={"position": 100.0, "wx wy": 8.0, "wz": 1.0})
    limit, q = np.deg2rad(50.0), np.random.default_rng(5).uniform(-1.5, 1.5, arm.n)
    twist = np.array([1.0, 2.0, -1.0, 0.5, -1.0, 2.0])
    ctl = sr.Controller(arm, law=law, task=sr.Task(frame="tool"), velocity_limits=limit)
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
    ask = lambda law: sr.Controller(arm, law=law, task=rows, velocity_limits=0.5).step(q, twist).rates  # noqa: E731
    assert np.array_equal(ask(all_named), ask(named))
    with pytest.raises(sr.InputError, match="wz"):
        sr.Controller(arm, law=named, velocity_limits=0.5)


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


def test_prices_by_rows_cannot_change_and_have_a_hash():
    given = {"position": 70.0, "orientation": 8.0}
    law, pair = sr.LeastError(price=given), sr.LeastError(price=(70, 8))
    given["position"] = 1.0
    assert law == pair
    assert len({law, pair, sr.LeastError(price=given)}) == 2
    with pytest.raises(TypeError):
        law.price["position"] = 1.0
    copy = pickle.loads(pickle.dumps(law))
    assert (copy, hash(copy), repr(copy)) == (law, hash(law), repr(law))
    assert repr(law.price) == "{'position': 70.0, 'orientation': 8.0}"


def position_first(case):
    """Its answer, those at the prices below and beyond the ceiling, their orientation errors, and b."""
    b = typical_rate(case.lower, case.upper)
    out = answer(sr.LeastError(price="position-first"), case, length=1.0)
    plain = answer(sr.LeastError(price=POSITION_FIRST), case, length=1.0)
    beyond = answer(sr.LeastError(price={**POSITION_FIRST, "orientation": BEYOND}), case, length=1.0)
    attitude = [float(np.linalg.norm(a.residual[3:])) for a in (plain, out, beyond)]
    return out, plain, beyond, attitude, b


def test_position_first_buys_attitude_up_to_its_ceiling():
    seen = {"below": 0, "at": 0, "beyond": 0}
    for case in price_cases(200, 14, hostile=False):
        out, plain, beyond, (free, mine, dear), b = position_first(case)
        ceiling = CEILING * b
        if b == 0.0:
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
            assert POSITION_FIRST["orientation"] * b < price < BEYOND * b
            own = [((0, 1, 2), POSITION_FIRST["position"] * b), ((3, 4, 5), price)]
            found = certificate(case, own, out.rates, out.multiplier)
            assert found.gap <= 1e-9 * found.objective, case.label
    assert min(seen.values()) > 5, seen


@pytest.mark.parametrize("seed", [14, 15, 17])
def test_the_price_of_attitude_is_raised_no_further_than_its_ceiling_asks(seed):
    raised = 0
    for case in price_cases(600, seed, hostile=True):
        out = answer(sr.LeastError(price="position-first"), case, length=1.0)
        b = typical_rate(case.lower, case.upper)
        price, error = np.linalg.norm(out.multiplier[3:]), np.linalg.norm(out.residual[3:])
        if price <= POSITION_FIRST["orientation"] * b * (1.0 + 1e-9):
            continue
        raised += 1
        if price < BEYOND * b * (1.0 - 1e-9):
            assert error == pytest.approx(CEILING * b, rel=1e-9), case.label
        else:
            assert error >= CEILING * b * (1.0 - 1e-9), case.label
    assert raised > 100


def test_position_first_from_the_price_of_the_last_tick_is_the_same_answer():
    arm, law = sr.arms.nasa_modular(), sr.LeastError(price="position-first")
    limit, rng, seen = np.deg2rad(50.0), np.random.default_rng(17), {"below": 0, "at": 0, "beyond": 0}
    ctl = sr.Controller(arm, law=law, velocity_limits=limit)
    for joint in range(2, 8):
        ctl.fail(joint)
    start, along = np.deg2rad([0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0]), 1e-3 * rng.uniform(-1.0, 1.0, 11)
    for tick in range(300):
        q, twist = start + tick * along, [0, 0, 0.4 * np.sin(0.03 * tick), 0, 0, 0]
        out = ctl.step(q, twist)
        cold = law.solve(arm.jacobian(q), twist, sr.Bounds(out.lower, out.upper), length=arm.reach)
        np.testing.assert_allclose(out.rates, cold.rates, atol=1e-9)
        share = np.linalg.norm(out.residual[3:]) / (CEILING * limit)
        seen["at" if share == pytest.approx(1.0, rel=1e-9) else "below" if share < 1.0 else "beyond"] += 1
    assert min(seen["below"], seen["at"]) > 20, seen
