"""How near a run's rates come to their limits, and which limits its joints were at."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stillreach._door import FloatArray
from stillreach.status import Health, Reason

if TYPE_CHECKING:
    from stillreach.simulation.run import Run

BOUNDS = ("rate", "position", "acceleration")
"""What can limit a working joint."""


def rate_shares(run: Run) -> FloatArray:
    """(T, n) each rate as a fraction of its rate limit on that side, derated where the joint is; 0 without a limit."""
    lower, upper = run.scenario.controller().velocity_limits.T
    limit = np.where(run.rates < 0.0, -lower, upper) * _derating(run)
    share = np.zeros_like(run.rates)
    np.divide(np.abs(run.rates), limit, out=share, where=np.isfinite(limit) & (limit > 0.0))
    return share


def bound_reasons(run: Run) -> np.ndarray:
    """(T, n) the limit that each joint is at: 0 none or a fault, else 1 + its place in BOUNDS.

    A derated joint at its reduced rate is at its rate limit, unless nothing is left of that.
    """
    reason = np.abs(run.active)
    derated = (reason == Reason.FAULT) & (run.health == Health.DERATED) & (run.rates != 0.0)
    return np.where(derated, 1, np.where(reason >= Reason.RATE, reason - 1, 0)).astype(np.int8)


def held_back(run: Run) -> dict[str, dict[str, float]]:
    """[s] how long each joint that was at a limit was at which."""
    reasons = bound_reasons(run)
    found: dict[str, dict[str, float]] = {}
    for joint, name in enumerate(run.joint_names):
        for code, bound in enumerate(BOUNDS, start=1):
            ticks = int(np.count_nonzero(reasons[:, joint] == code))
            if ticks:
                found.setdefault(name, {})[bound] = ticks * run.scenario.period
    return found


def _derating(run: Run) -> FloatArray:
    """(T, n) what is left of each rate limit, 0 to 1."""
    left = np.ones_like(run.rates)
    for tick, changes in sorted(run.scenario.schedule.changes.items()):
        for joint, kind in changes:
            left[tick:, joint] = 1.0 if kind is None else kind.share
    return left
