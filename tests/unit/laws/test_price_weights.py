"""LeastError with a price under weights, units and kinds of joints: the conditions of its minimum."""

import numpy as np
import pytest

import stillreach as sr
from oracles.price import ENDLESS, price_cases
from tests.unit.laws.priced import answer


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
    limits = np.maximum(-case.lower, case.upper)
    limits = np.sqrt(np.diag(inertia)) * np.where(np.isfinite(limits), limits, ENDLESS)
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
