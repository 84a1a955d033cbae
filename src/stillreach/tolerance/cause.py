"""Why a failure is not survived, in one word, from the tick that left most of its command undone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach.batch import solve_batch
from stillreach.faults import Loses, losing
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


class Missed(NamedTuple):
    """The tick since the controller knew of a failure that left most of its command undone."""

    q: FloatArray
    command: FloatArray
    lower: FloatArray
    upper: FloatArray
    active: npt.NDArray[np.int8]
    health: npt.NDArray[np.int8]


def missed(record: Mapping[str, np.ndarray], since: int, tick: int) -> Missed:
    """That tick of a record, where the tool left its tolerance at ``tick``: a copy."""
    at = since + int(record["task_error"][since : tick + 1].argmax())
    return Missed(*(record[name][at].copy() for name in SEEN))


SEEN = ("measured", "command", "lower", "upper", "active", "known")
"""What Missed keeps of a record."""


def causes_of(scenario: Scenario, ticks: Sequence[Missed]) -> list[tuple[Cause, int]]:
    """Why the tool left its tolerance in some cases: each with the index of the joint whose limit it is, or -1."""
    q, command, lower, upper, active, health = (np.array(values) for values in zip(*ticks, strict=True))
    reason, fixed = np.abs(active), lower == upper
    hurt = reason == Reason.FAULT
    causes = {
        Cause.DIRECTION: np.zeros(lower.shape, dtype=bool),
        Cause.RANGE: hurt & np.isin(health, losing(Loses.RANGE)),
        Cause.ONE_WAY: hurt & np.isin(health, losing(Loses.SIDE)),
        Cause.POSITION: reason == Reason.POSITION,
    }
    kept = np.array(list(causes.values()))  # of all bounds, only these
    still = np.zeros_like(lower)
    low = np.where(fixed | (kept & (active < 0)), lower, -np.inf)
    high = np.where(fixed | (kept & (active > 0)), upper, np.inf)
    bounds = np.concatenate([[still, lower], low]), np.concatenate([[still, upper], high])
    wanted, undone, *rest = _left(scenario, q, command, *bounds)
    least = MISSED * np.linalg.norm(wanted, axis=1) + NOTHING
    impossible = dict(zip(causes, np.linalg.norm(rest, axis=2) > least, strict=True))
    slow = (reason == Reason.RATE) | (reason == Reason.ACCELERATION) | (hurt & np.isin(health, losing(Loses.SPEED)))
    runs = health == Health.RUNAWAY

    def cause(k: int) -> tuple[Cause, int]:
        if impossible[Cause.DIRECTION][k]:
            return Cause.DIRECTION, -1
        if np.linalg.norm(undone[k]) <= least[k]:
            return Cause.LAW, -1
        for cause, at_bounds in causes.items():
            if at_bounds[k].any() and impossible[cause][k]:
                return cause, int(np.argmax(at_bounds[k]))
        if runs[k].any():
            return Cause.RUNAWAY, int(np.argmax(runs[k]))
        along = undone[k] @ wanted[k]
        if along - undone[k] @ undone[k] <= HARDLY * along:
            return Cause.DIRECTION, -1
        return Cause.SPEED, int(np.argmax(slow[k])) if slow[k].any() else -1

    return [cause(k) for k in range(len(ticks))]


def _left(scenario: Scenario, q: FloatArray, command: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """(B, K, m) what the best rates inside some bounds (B, K, n) leave of K commands."""
    law = LeastError(price=None, weights=scenario.law.weights if scenario.law else None)
    count, n = len(lower), lower.shape[-1]
    every = np.tile(q, (count, 1)), np.tile(command, (count, 1))
    bounds = lower.reshape(-1, n), upper.reshape(-1, n)
    found = solve_batch(scenario.arm, law, *every, bounds, task=scenario.task, want="residual", threads=1)
    return np.asarray(found.residual).reshape(count, len(q), -1)
