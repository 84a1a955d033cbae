"""Status flags of a tick, reasons of active bounds, health of joints."""

from __future__ import annotations

import operator
from enum import IntFlag
from typing import Any

from stillreach._core import STATUS, Health, Reason

__all__ = ["Health", "Reason", "Status"]


class Status(IntFlag):
    """Flags of a tick; several can be set. The values are the compiled core's."""

    OK = STATUS["OK"]
    """No other flag."""
    SATURATED = STATUS["SATURATED"]
    """A working joint is at a limit: one that is healthy, or that its fault leaves a choice, however little."""
    SCALED = STATUS["SCALED"]
    """Less than the whole commanded twist was aimed at (KeepDirection)."""
    DAMPED = STATUS["DAMPED"]
    """The damping factor is above 0."""
    SINGULAR = STATUS["SINGULAR"]
    """The working joints' Jacobian has lost rank."""
    OVER_LIMIT = STATUS["OVER_LIMIT"]
    """The rates exceed a bound (Pseudoinverse only)."""
    NO_WORKING_JOINT = STATUS["NO_WORKING_JOINT"]
    """Every joint has failed, and no fault leaves a choice."""
    FAULT_NOT_COMPENSATED = STATUS["FAULT_NOT_COMPENSATED"]
    """A runaway joint moves the tool, and the others cannot make up for it."""
    CLIPPED = STATUS["CLIPPED"]
    """Rates were cut to their bounds one by one (damping laws)."""
    LIMIT_GIVEN_UP = STATUS["LIMIT_GIVEN_UP"]
    """Limits contradicted each other; the one of lower precedence was given up."""
    ITERATION_LIMIT = STATUS["ITERATION_LIMIT"]
    """A search reached its limit of steps; the result is the best found, inside the bounds."""
    INVALID_INPUT = STATUS["INVALID_INPUT"]
    """An input is NaN or infinite; the rates brake."""

    @classmethod
    def _missing_(cls, value: object) -> Any:
        """Integers of NumPy arrays, as of ``BatchSolution.status`` and ``Run.status``, are statuses too."""
        try:
            return super()._missing_(operator.index(value))  # type: ignore[arg-type]
        except TypeError:
            return super()._missing_(value)

    def __str__(self) -> str:
        return self.name or "OK"


IN_WORDS = {
    Status.OK: "no limit active",
    Status.SATURATED: "a joint at a limit",
    Status.SCALED: "slowed down",
    Status.DAMPED: "damped",
    Status.SINGULAR: "singular",
    Status.OVER_LIMIT: "over a limit",
    Status.NO_WORKING_JOINT: "no working joint",
    Status.FAULT_NOT_COMPENSATED: "fault not compensated",
    Status.CLIPPED: "rates cut to their bounds",
    Status.LIMIT_GIVEN_UP: "limit given up",
    Status.ITERATION_LIMIT: "iteration limit",
    Status.INVALID_INPUT: "invalid input",
}
"""Flags as people read them."""
