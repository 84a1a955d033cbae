"""How near a run's rates come to their limits, and what held its joints back."""

from __future__ import annotations

import numpy as np

from stillreach._door import FloatArray
from stillreach.faults import Derated
from stillreach.simulate.events import fault_changes
from stillreach.simulate.run import Run
from stillreach.simulate.scenario import Scenario
from stillreach.status import Health

BOUNDS = ("rate", "position", "acceleration")
"""What can hold back a working joint."""


def rate_shares(scenario: Scenario, run: Run) -> FloatArray:
    """(T, n) each rate as a fraction of its rate limit on that side, derated where the joint is; 0 without a limit."""
    lower, upper = _rate_limits(scenario)
    limit = np.where(run.rates < 0.0, -lower, upper) * _derating(scenario, len(run))
    share = np.zeros_like(run.rates)
    np.divide(np.abs(run.rates), limit, out=share, where=np.isfinite(limit) & (limit > 0.0))
    return share


def has_rate_limits(scenario: Scenario) -> bool:
    """Whether any joint has one."""
    return bool(np.any(np.isfinite(_rate_limits(scenario))))


def bound_reasons(scenario: Scenario, run: Run) -> np.ndarray:
    """(T, n) what holds each joint at its bound: 0 nothing or a fault, else 1 + its place in BOUNDS."""
    works = (run.health == Health.HEALTHY) | (run.health == Health.DERATED)
    at_upper, at_lower = run.rates >= run.upper, run.rates <= run.lower
    held = works & (at_upper | at_lower) & (run.lower < run.upper)
    bound = np.where(at_upper, run.upper, run.lower)
    lower, upper = _rate_limits(scenario)
    derated = run.health == Health.DERATED
    own = np.where(at_upper, upper, lower)
    rate = held & (np.isclose(bound, own, rtol=1e-12) | (derated & (bound != 0.0)))
    position = held & ~rate
    reasons = np.zeros(run.rates.shape, dtype=np.int8)
    reasons[rate], reasons[position] = 1, 2
    acceleration = (
        scenario.arm.acceleration_limits if scenario.acceleration_limits is None else scenario.acceleration_limits
    )
    step = np.broadcast_to(np.asarray(acceleration, dtype=float), run.rates.shape[1:]) * scenario.period
    before = np.vstack([np.zeros_like(run.rates[:1]), run.rates[:-1]])
    with np.errstate(invalid="ignore"):
        window = np.isclose(np.abs(bound - before), step, rtol=1e-9)
    reasons[position & window] = 3
    return reasons


def held_back(scenario: Scenario, run: Run) -> dict[str, dict[str, float]]:
    """[s] how long each joint that was at a bound was at which."""
    reasons = bound_reasons(scenario, run)
    found: dict[str, dict[str, float]] = {}
    for joint, name in enumerate(run.joint_names):
        for code, bound in enumerate(BOUNDS, start=1):
            ticks = int(np.count_nonzero(reasons[:, joint] == code))
            if ticks:
                found.setdefault(name, {})[bound] = ticks * scenario.period
    return found


def _derating(scenario: Scenario, ticks: int) -> FloatArray:
    """(ticks, n) what is left of each rate limit, 0 to 1."""
    left = np.ones((ticks, scenario.arm.n))
    for tick, changes in sorted(fault_changes(scenario).items()):
        for joint, kind in changes:
            left[tick:, joint] = kind.fraction if isinstance(kind, Derated) else 1.0
    return left


def _rate_limits(scenario: Scenario) -> tuple[FloatArray, FloatArray]:
    """(n,) lower and (n,) upper rate limits [rad/s, m/s]."""
    given = (
        scenario.arm.velocity_limits if scenario.rate_limits is None else np.asarray(scenario.rate_limits, dtype=float)
    )
    if given.ndim == 2:
        return given[:, 0], given[:, 1]
    limits = np.broadcast_to(given, (scenario.arm.n,))
    return -limits, limits
