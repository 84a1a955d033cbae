"""Rates of a run relative to their limits, and the limits that its joints reached."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stillreach._door import FloatArray
from stillreach.faults import Loses, losing
from stillreach.status import Reason

if TYPE_CHECKING:
    from stillreach.simulation.run import Run

BOUNDS = ("rate", "position", "acceleration")
"""The limits of a working joint, as in files and JSON."""
BOUND_WORDS = {"rate": "velocity"}
"""Words in text, where they differ."""


def rate_shares(run: Run) -> FloatArray:
    """(T, n) each rate as a fraction of its velocity limit in that direction, after derating; 0 without a limit."""
    lower, upper = run.scenario.controller().velocity_limits.T
    limit = np.where(run.rates < 0.0, -lower, upper)
    for tick, changes in sorted(run.scenario.schedule.changes.items()):
        for joint, kind in changes:
            low, high = float(lower[joint]), float(upper[joint])
            if kind is not None and kind.loses is Loses.SPEED:
                low, high = kind.driven(low, -low), kind.driven(high, high)
            limit[tick:, joint] = np.where(run.rates[tick:, joint] < 0.0, -low, high)
    share = np.zeros_like(run.rates)
    np.divide(np.abs(run.rates), limit, out=share, where=np.isfinite(limit) & (limit > 0.0))
    return share


def bound_reasons(run: Run) -> np.ndarray:
    """(T, n) the limit that each joint is at: 0 for none or a fault, else 1 + index in BOUNDS.

    A derated joint at its reduced rate is at its velocity limit, unless that is 0.
    """
    reason = np.abs(run.active)
    derated = (reason == Reason.FAULT) & np.isin(run.known, losing(Loses.SPEED)) & (run.rates != 0.0)
    return np.where(derated, 1, np.where(reason >= Reason.RATE, reason - 1, 0)).astype(np.int8)


def held_back(run: Run) -> dict[str, dict[str, float]]:
    """[s] time of each joint at each of its limits."""
    reasons = bound_reasons(run)
    found: dict[str, dict[str, float]] = {}
    for joint, name in enumerate(run.joint_names):
        for code, bound in enumerate(BOUNDS, start=1):
            ticks = int(np.count_nonzero(reasons[:, joint] == code))
            if ticks:
                found.setdefault(name, {})[bound] = ticks * run.scenario.period
    return found
