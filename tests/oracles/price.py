"""What a priced answer has to be: min of sum_g Y_g |e_g| + |rates - reference|^2 / 2 in the box, e = x - J rates.

Its certificate in 50 digits, the same minimum by another solver, and cases of every kind.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext

import numpy as np
from scipy.optimize import brentq, lsq_linear

EPS = np.finfo(float).eps
ENDLESS = 2.0
"""[rad/s, m/s] What a joint without a limit counts as."""
Parts = Sequence[tuple[Sequence[int], float]]
"""Rows of each part, and its Y."""


@dataclass(frozen=True)
class PriceCase:
    """One question: J (m, n), x (m,), bounds and reference (n,)."""

    j: np.ndarray
    x: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    reference: np.ndarray
    label: str


@dataclass(frozen=True)
class Certificate:
    """Objective of the rates, how much a dual point proves it to be above the least one, and its terms' rounding."""

    objective: float
    gap: float
    rounding: float

    @property
    def optimal(self) -> bool:
        """No more above the least than rounding."""
        return self.gap <= 1e-12 * self.objective + 64.0 * self.rounding


def typical_rate(lower, upper):
    """b: the second largest rate limit of the working joints, or the only one."""
    limits = [max(-a, b) for a, b in zip(lower, upper, strict=True) if a < b]
    limits = sorted((min(limit, np.inf) if limit < np.inf else ENDLESS for limit in limits), reverse=True)
    return limits[1] if len(limits) > 1 else limits[0] if limits else 0.0


def certificate(case: PriceCase, parts: Parts, rates, u) -> Certificate:
    """Weak duality in 50 digits: for any u with |u_g| <= Y_g no rates in the box have a smaller objective than d(u).

    u is shortened where rounding has it out of its balls, which lowers the bound.
    """
    works = case.lower < case.upper
    moves = np.linalg.norm(rates) + np.linalg.norm(case.reference[works])  # rates are found as changes of the reference
    with localcontext() as context:
        context.prec = 50
        exact = np.frompyfunc(lambda number: Decimal(float(number)), 1, 1)
        j, x, r, ref, u = (exact(a) for a in (case.j, case.x, rates, case.reference, u))
        e, dual, primal, rounding = x - j @ r, u.copy(), Decimal(0), 0.0
        for rows, price in parts:
            rows, most = list(rows), Decimal(float(price))
            primal += most * (e[rows] @ e[rows]).sqrt()
            size = (u[rows] @ u[rows]).sqrt()
            if size > most:
                dual[rows] = u[rows] * (most / size)
            rounding += price * (np.linalg.norm(case.x[rows]) + np.linalg.norm(case.j[rows], 2) * moves)
        primal += (r - ref) @ (r - ref) / 2
        pull = dual @ j
        low, high = exact(case.lower), exact(case.upper)
        best = np.array([min(max(a, b), c) for a, b, c in zip(ref + pull, low, high, strict=True)], dtype=object)
        bound = dual @ x + (best - ref) @ (best - ref) / 2 - pull @ best
        return Certificate(float(primal), float(primal - bound), EPS * rounding)


def by_damping(case: PriceCase, price: float) -> np.ndarray:
    """The rates of one part: damped bounded least squares (SciPy) with the damping where |e| = price * damping."""
    works = case.lower < case.upper
    rates = case.lower.copy()
    j, ref = case.j[:, works], case.reference[works]
    x = case.x - case.j[:, ~works] @ case.lower[~works] - j @ ref
    box = (case.lower[works] - ref, case.upper[works] - ref)
    scale = np.linalg.norm(j, 2) ** 2

    def damped(log):
        kappa = scale * np.exp(log)
        a = np.vstack((j, np.sqrt(kappa) * np.eye(j.shape[1])))
        found = lsq_linear(a, np.append(x, np.zeros(j.shape[1])), box, method="bvls", tol=1e-15, max_iter=1000)
        z = np.clip(found.x, *box)
        return z, np.log(max(np.linalg.norm(x - j @ z), 1e-300) / (price * kappa))

    most = np.linalg.norm(x - j @ np.clip(0.0, *box))  # no damping leaves a larger error than that of the least rates
    low, high = -23.0, np.log(max(most / (price * scale), 1e-10)) + 1e-9
    root = brentq(lambda log: damped(log)[1], low, high, xtol=1e-12, rtol=1e-14) if damped(low)[1] > 0.0 else low
    z, _ = damped(root)
    rates[works] = ref + z
    return rates


def by_reweighting(case: PriceCase, parts: Parts, rounds: int = 400) -> np.ndarray | None:
    """The rates of several parts: least squares in the box, each part weighted by Y_g / |e_g|; None: not settled."""
    works = case.lower < case.upper
    rates = case.lower.copy()
    j, ref = case.j[:, works], case.reference[works]
    x = case.x - case.j[:, ~works] @ case.lower[~works] - j @ ref
    box = (case.lower[works] - ref, case.upper[works] - ref)
    floor = 1e-10 * np.linalg.norm(j, 2) ** 2
    kappa, z = np.full(len(parts), 1e-2), None
    for _ in range(rounds):
        weight = np.empty(len(x))
        for (rows, _), value in zip(parts, kappa, strict=True):
            weight[list(rows)] = 1.0 / np.sqrt(value)
        a = np.vstack((weight[:, None] * j, np.eye(j.shape[1])))
        found = lsq_linear(a, np.append(weight * x, np.zeros(j.shape[1])), box, method="bvls", tol=1e-15, max_iter=1000)
        z = np.clip(found.x, *box)
        e = x - j @ z
        new = np.array([max(np.linalg.norm(e[list(rows)]) / price, floor) for rows, price in parts])
        if np.max(np.abs(np.log(new / kappa))) < 1e-9:
            rates[works] = ref + z
            return rates
        kappa = new
    return None


def price_cases(count: int, seed: int, *, hostile: bool = True) -> Iterator[PriceCase]:
    """Arms of 7 to 50 joints, a fifth of them prismatic, 0 to n failed, some running away, with every kind of bound.

    hostile: singular values down to 1e-9 and twists from 1e-12 to 1e3; else down to 1e-2 and from 1e-2 to 10.
    """
    for i in range(count):
        yield price_case(seed, i, hostile=hostile)


def price_case(seed: int, i: int, *, hostile: bool = True) -> PriceCase:
    """Case i of ``price_cases(..., seed)``."""
    least, sizes = (-9.0, (-12.0, 3.0)) if hostile else (-2.0, (-2.0, 1.0))
    rng = np.random.default_rng([seed, i])
    n = int(rng.integers(7, 51))
    j = _jacobian(rng, n, least)
    lower, upper, bounds = _bounds(rng, n)
    failed = rng.permutation(n) < (rng.integers(0, n + 1) if rng.random() < 0.5 else rng.integers(0, n // 3 + 1))
    runaway = failed & (rng.random(n) < rng.choice([0.0, 0.3]))
    lower[failed] = upper[failed] = 0.0
    lower[runaway] = upper[runaway] = rng.normal(size=np.sum(runaway))
    reference = rng.normal(size=n) * rng.choice([0.0, 0.0, 0.1, 1.0])
    x, asked = _twist(rng, j, lower, upper, sizes)
    return PriceCase(j, x, lower, upper, reference, f"case {seed}/{i}: {n} joints, {bounds}, {asked}")


def _jacobian(rng, n, least):
    """(6, n) of a chain of turning and sliding joints, some singular values smaller by down to 10^least."""
    axes, arms = rng.normal(size=(2, 3, n))
    axes /= np.linalg.norm(axes, axis=0)
    arms *= 10.0 ** rng.uniform(-1.0, 1.0)
    slides = rng.random(n) < 0.2
    j = np.vstack((np.where(slides, axes, np.cross(axes, arms, axis=0)), np.where(slides, 0.0, axes)))
    if rng.random() < 0.6:
        left, sigma, right = np.linalg.svd(j, full_matrices=False)
        small = rng.permutation(6) < rng.integers(1, 6)
        sigma[small] *= 10.0 ** rng.uniform(least, 0.0, np.sum(small))
        j = (left * sigma) @ right
    if rng.random() < 0.1:
        j[rng.integers(0, 6)] = 0.0
    return j


def _bounds(rng, n):
    kind = rng.choice(["symmetric", "per joint", "one-sided", "window", "some infinite", "infinite"])
    limit = np.full(n, 10.0 ** rng.uniform(-2.0, 1.0))
    if kind != "symmetric":
        limit = limit * 10.0 ** rng.uniform(-1.0, 1.0, n)
    lower, upper = -limit, limit.copy()
    if kind == "one-sided":
        lower = lower * rng.choice([0.0, 0.1, 1.0], n)
    elif kind == "window":
        middle = rng.normal(size=n) * limit
        lower, upper = middle - 0.4 * limit, middle + 0.4 * limit
    elif kind == "some infinite":
        lower, upper = np.where(rng.random(n) < 0.4, -np.inf, lower), np.where(rng.random(n) < 0.4, np.inf, upper)
    elif kind == "infinite":
        lower, upper = np.full(n, -np.inf), np.full(n, np.inf)
    return lower, upper, kind


def _twist(rng, j, lower, upper, sizes):
    kind = rng.choice(["any size", "any size", "reachable", "just out of reach", "in the image"])
    if kind == "any size":
        return rng.normal(size=6) * 10.0 ** rng.uniform(*sizes), kind
    low, high = np.clip(lower, -1.0, 1.0), np.clip(upper, -1.0, 1.0)
    inside = j @ (low + rng.random(len(low)) * (high - low))
    if kind == "reachable":
        return inside, kind
    if kind == "in the image":
        return inside * 10.0 ** rng.uniform(*sizes), kind
    corner = j @ np.where(rng.normal(size=6) @ j > 0.0, high, low)
    return corner * rng.uniform(0.9, 1.5), kind
