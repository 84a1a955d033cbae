"""Seeded ticks that a controller should not meet, and what must hold in each of them, computed without the core."""

from dataclasses import dataclass
from functools import cache

import numpy as np

import stillreach as sr
from tests.conformance.registry import ARMS

INF = np.inf
LOCKED, DERATED, RUNAWAY, CONFINED, ONE_WAY, FREE_SWINGING = list(sr.Health)[1:]
HALF_RANGE = 0.3
"""A confined joint has so much room on either side of its value."""
SEGMENT = 25
"""Ticks between two changes of faults."""


@dataclass
class Attack:
    """One controller's worth of ticks: what it is told once, and what comes.

    Attributes:
        arm, task, period: of the controller.
        rate, position: (n, 2) limits; `acceleration` (n,).
        q, twist: (K, n) and (K, 6), some of them no numbers.
        health, value: (K, n) state of each joint, and its fraction, rate, middle of the range or direction.
    """

    arm: sr.Arm
    task: sr.Task
    period: float
    rate: np.ndarray
    position: np.ndarray
    acceleration: np.ndarray
    q: np.ndarray
    twist: np.ndarray
    health: np.ndarray
    value: np.ndarray

    def controller(self, law):
        """A new controller of it."""
        return sr.Controller(
            self.arm,
            law=law,
            task=self.task,
            period=self.period,
            velocity_limits=self.rate,
            position_limits=self.position,
            acceleration_limits=self.acceleration,
        )


def attack(seed, ticks):
    """`ticks` ticks (a multiple of SEGMENT) against one controller."""
    rng = np.random.default_rng(seed)
    name = list(ARMS)[rng.integers(len(ARMS))]
    subject, arm = ARMS[name], _arm(name)
    n = arm.n
    task = sr.Task(rows=tuple(row in subject.rows for row in range(6)), frame=("base", "tool")[rng.integers(2)])
    health, value = _faults(rng, n, ticks)
    q, twist = _configurations(rng, arm, ticks), _twists(rng, arm, ticks)
    _no_numbers(rng, q)
    _no_numbers(rng, twist)
    rate, position, acceleration = _limits(rng, n)
    period = 10.0 ** rng.uniform(-4, -1)
    return Attack(arm, task, period, rate, position, acceleration, q, twist, health, value)


@cache
def _arm(name):
    return ARMS[name].make()


def _limits(rng, n):
    pick = lambda values: rng.choice(values, n)  # noqa: E731
    upper, lower = pick([0.0, 1e-9, 0.5, 1.0, 1.0, 50.0, INF]), pick([0.0, 1e-9, 0.5, 1.0, 1.0, 50.0, INF])
    if rng.random() < 0.3:
        upper = lower = np.full(n, 1.0)
    position = np.tile([-INF, INF], (n, 1))
    if rng.random() < 0.6:
        middle, half = rng.normal(size=n), pick([0.0, 1e-6, 1.0, 3.0, INF])
        position = np.stack([middle - half, middle + half * pick([0.5, 1.0])], axis=1)
    acceleration = np.full(n, INF) if rng.random() < 0.4 else pick([0.0, 1e-3, 1.0, 10.0, 1e6, INF])
    return np.stack([-lower, upper], axis=1), position, acceleration


def _faults(rng, n, ticks):
    """Faults that come and go, segment by segment: none, some, all but one, all."""
    count = ticks // SEGMENT
    health, value = np.zeros((count, n), np.int8), np.zeros((count, n))
    for row in range(count):
        broken = [0, 0, int(rng.integers(0, n + 1)), n - 1, n][rng.integers(5)]
        chosen = rng.permutation(n)[:broken]
        health[row, chosen] = rng.choice([LOCKED, FREE_SWINGING, DERATED, RUNAWAY, CONFINED, ONE_WAY], broken)
        value[row, chosen] = rng.choice([0.0, 0.1, 0.5, 1.0], broken)
    runs = health == RUNAWAY
    value[runs] = (value * rng.choice([-1.0, 1e-3, 1.0, 30.0], (count, n)))[runs]
    value[(health == LOCKED) | (health == FREE_SWINGING)] = 0.0
    ways = health == ONE_WAY
    value[ways] = np.where(value > 0.2, 1.0, -1.0)[ways]
    return np.repeat(health, SEGMENT, axis=0), np.repeat(value, SEGMENT, axis=0)


def _configurations(rng, arm, ticks):
    """A motion in small steps, with jumps to singular, nearly singular and far-off places."""
    walk = rng.uniform(-2, 2, arm.n) + np.cumsum(rng.normal(size=(ticks, arm.n)) * 1e-2, axis=0)
    signs = np.where(np.arange(arm.n) % 2 == 0, 1.0, -1.0)
    kind = rng.integers(0, 12, ticks)
    walk[kind == 0] = 0.0
    small = 10.0 ** rng.uniform(-17, -1, (np.count_nonzero(kind == 1), 1))
    walk[kind == 1] = small * signs
    quarter = rng.integers(-2, 3, (np.count_nonzero(kind == 2), arm.n)) * (np.pi / 2)
    walk[kind == 2] = quarter
    walk[kind == 3] *= 10.0 ** rng.uniform(1, 15, (np.count_nonzero(kind == 3), 1))
    walk[kind == 4] = rng.uniform(-np.pi, np.pi, (np.count_nonzero(kind == 4), arm.n))
    if rng.random() < 0.02:
        walk[kind == 3] = 1e300 * signs
    return walk


def _twists(rng, arm, ticks):
    twist = rng.normal(size=(ticks, 6)) * 10.0 ** rng.uniform(-3, 2, (ticks, 1))
    kind = rng.integers(0, 12, ticks)
    twist[kind == 0] = 0.0
    twist[kind == 1] = 1e300 * rng.choice([-1.0, 0.0, 1.0], (np.count_nonzero(kind == 1), 6))
    twist[kind == 2] *= 5e-324 / 1e-3
    twist[kind == 3] *= 1e-310
    twist[kind == 4] = np.eye(6)[rng.integers(0, 6, np.count_nonzero(kind == 4))]
    twist[kind == 5] *= 10.0 ** rng.uniform(-300, 290, (np.count_nonzero(kind == 5), 1))
    return twist


def _no_numbers(rng, values):
    """Puts a NaN or an infinity into one row in fifty."""
    rows = np.flatnonzero(rng.random(len(values)) < 0.01)
    values[rows, rng.integers(0, values.shape[1], len(rows))] = rng.choice([np.nan, INF, -INF], len(rows))


def without_choice(attack):
    """(K, n) which joints have one rate left by their fault."""
    none_left = (attack.health == DERATED) & (attack.value == 0.0)
    return np.isin(attack.health, (LOCKED, FREE_SWINGING, RUNAWAY)) | none_left


def rate_bounds(attack):
    """(K, n) lower and upper bound of each rate by faults and rate limits."""
    stuck, blocked = without_choice(attack), (attack.health == ONE_WAY) & np.array([attack.value > 0, attack.value < 0])
    with np.errstate(invalid="ignore"):
        reduced = [np.nan_to_num(attack.value * side, nan=0.0, posinf=INF, neginf=-INF) for side in attack.rate.T]
    for side, reduction, none in zip(attack.rate.T, reduced, blocked, strict=True):
        left = np.where(none, 0.0, np.where(attack.health == DERATED, reduction, side))
        yield np.where(stuck, attack.value, left)


def position_bounds(attack):
    """(K, n) lower and upper bound of each working joint's rate by position limits and the ranges of confined joints.

    A joint at v that brakes by `a` every tick from the next one on goes `period` times the sum of the positive ones of
    v, v - a period, v - 2 a period, ... further. That sum is the largest of its partial sums, so it fits into the room
    to the limit where for every number N of ticks N v - N (N - 1) / 2 a period <= room / period; the N that says most
    is next to sqrt(2 room / a) / period. Where the joint's position is no number there is no bound.
    """
    h, a = attack.period, attack.acceleration
    with np.errstate(all="ignore"):
        for sign, end in zip((-1.0, 1.0), attack.position.T, strict=True):
            fault = np.where(attack.health == CONFINED, attack.value + sign * HALF_RANGE, sign * INF)
            limit = sign * np.minimum(sign * end, sign * fault)
            room = np.maximum(sign * (limit - attack.q), 0.0)
            ticks = np.maximum(np.floor(np.sqrt(2.0 * room / a) / h), 1.0)
            curve = np.minimum(*(room / (h * count) + a * h * (count - 1.0) / 2.0 for count in (ticks, ticks + 1.0)))
            curve = np.where(room == 0.0, 0.0, np.where(a == INF, INF, np.where(a == 0.0, 0.0, curve)))
            most = np.where(np.isinf(limit), INF, np.minimum(room / h, curve))
            yield sign * np.where(np.isfinite(attack.q), most, INF)


def violations(attack, rates, status, *, bounded=True):
    """In how many ticks each promise was broken.

    Args:
        attack: what came.
        rates, status: (K, n) and (K,) what was answered, from rest on.
        bounded: whether the law promises bounds at all.
    """
    stuck = without_choice(attack)
    last = np.vstack([np.zeros(attack.arm.n), rates[:-1]])
    (rate_low, rate_high), (stop_low, stop_high) = rate_bounds(attack), position_bounds(attack)
    low, high = (
        np.where(stuck, rate_low, np.maximum(rate_low, stop_low)),
        np.where(stuck, rate_high, np.minimum(rate_high, stop_high)),
    )
    change = attack.acceleration * attack.period
    finite_change = np.where(np.isfinite(change), change, 0.0)
    with np.errstate(all="ignore"):
        slack = 1e-9 * np.abs(rates) + 1e-15 * finite_change
        window = 1e-9 * finite_change + 1e-15 * np.abs(last)
        apart = (last - change > high + slack + window) | (last + change < low - slack - window)
        nearly = (last - change > high - slack - window) | (last + change < low + slack + window)
        jumped = np.abs(rates - last) > change + window
    told = {flag: (status & flag) != 0 for flag in (sr.Status.LIMIT_GIVEN_UP, sr.Status.INVALID_INPUT)}
    given_up, invalid = told.values()
    no_number = ~(np.isfinite(attack.q).all(axis=1) & np.isfinite(attack.twist).all(axis=1))
    broken = {
        "not finite": ~np.isfinite(rates),
        "failed joint off its rate": stuck & (rates != attack.value),
        "bad input not told": no_number & ~invalid,
    }
    if bounded:
        broken |= {
            "rate limit": (rates > rate_high) | (rates < rate_low),
            "position limit": (rates > high + slack) | (rates < low - slack),
            "acceleration limit": jumped & ~stuck & ~given_up[:, None],
            "given up, not told": (apart & ~stuck).any(axis=1) & ~given_up,
            "told given up, was not": given_up & ~(nearly & ~stuck).any(axis=1),
        }
    return {
        name: int(np.count_nonzero(where.any(axis=1) if where.ndim == 2 else where)) for name, where in broken.items()
    }
