"""Why a failure is not survived, in one word, from the tick that left most of its command undone."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.batch import solve_batch
from stillreach.laws import LeastError
from stillreach.simulation import Scenario
from stillreach.simulation.why import HARDLY, MISSED, NOTHING
from stillreach.status import Health, Reason


class Cause(IntEnum):
    """What became of a failure, and why the tool was not held."""

    NOT_DONE = 0
    SURVIVES = 1
    DELAY = 2
    DIRECTION = 3
    POSITION = 4
    SPEED = 5
    ONE_WAY = 6
    RUNAWAY = 7
    LAW = 8
    RANGE = 9
    LIMITS = 10


WORDS = {
    Cause.NOT_DONE: "not computed",
    Cause.SURVIVES: "survives",
    Cause.DELAY: "before the controller knew",
    Cause.DIRECTION: "direction lost",
    Cause.POSITION: "position limit",
    Cause.SPEED: "speed limit",
    Cause.ONE_WAY: "one direction only",
    Cause.RUNAWAY: "the runaway joint",
    Cause.LAW: "the law",
    Cause.RANGE: "reduced range",
    Cause.LIMITS: "rates beyond the limits",
}
"""In tables; ``docs/rehearsal.md`` explains them."""


def cause_of(scenario: Scenario, record: Mapping[str, np.ndarray], since: int, tick: int) -> tuple[Cause, int]:
    """Why the tool left its tolerance at a tick, from the ticks since the controller knew of the failure.

    Returns:
        The cause, and the index of the joint whose limit it is, or -1.
    """
    at = since + int(np.argmax(record["task_error"][since : tick + 1]))
    lower, upper, active = record["lower"][at], record["upper"][at], record["active"][at]
    reason, health, fixed = np.abs(active), record["known"][at], lower == upper
    hurt = reason == Reason.FAULT
    causes = {
        Cause.DIRECTION: np.zeros(len(lower), dtype=bool),
        Cause.RANGE: hurt & (health == Health.CONFINED),
        Cause.ONE_WAY: hurt & (health == Health.ONE_WAY),
        Cause.POSITION: reason == Reason.POSITION,
    }
    kept = np.array(list(causes.values()))  # of all bounds, only these
    still = np.zeros_like(lower)
    low = np.where(fixed | (kept & (active < 0)), lower, -np.inf)
    high = np.where(fixed | (kept & (active > 0)), upper, np.inf)
    wanted, undone, *rest = _left(scenario, record, at, np.vstack([still, lower, low]), np.vstack([still, upper, high]))
    least = MISSED * float(np.linalg.norm(wanted)) + NOTHING
    impossible = dict(zip(causes, np.linalg.norm(rest, axis=1) > least, strict=True))
    if impossible[Cause.DIRECTION]:
        return Cause.DIRECTION, -1
    if np.linalg.norm(undone) <= least:
        return Cause.LAW, -1
    for cause, bounds in causes.items():
        if bounds.any() and impossible[cause]:
            return cause, int(np.argmax(bounds))
    if (health == Health.RUNAWAY).any():
        return Cause.RUNAWAY, int(np.argmax(health == Health.RUNAWAY))
    if undone @ wanted - undone @ undone <= HARDLY * (undone @ wanted):
        return Cause.DIRECTION, -1
    slow = (reason == Reason.RATE) | (reason == Reason.ACCELERATION) | (hurt & (health == Health.DERATED))
    return Cause.SPEED, int(np.argmax(slow)) if slow.any() else -1


def _left(scenario: Scenario, record: Mapping[str, Any], at: int, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """(K, m) what the best rates inside some bounds (K, n) leave of the command of a tick."""
    law = LeastError(price=None, weights=scenario.law.weights if scenario.law else None)
    q, twist = (np.tile(record[name][at], (len(lower), 1)) for name in ("measured", "command"))
    found = solve_batch(scenario.arm, law, q, twist, (lower, upper), task=scenario.task, want="residual", threads=1)
    return np.asarray(found.residual)
