"""Status flags of a tick, reasons of active bounds, health of joints."""

from __future__ import annotations

import operator
from enum import IntEnum, IntFlag
from typing import Any


class Status(IntFlag):
    """Flags of a tick; several can be set. The values are the compiled core's."""

    OK = 0
    """No other flag."""
    SATURATED = 1
    """A working joint is at a limit: one that is healthy, or that its fault leaves a choice, however little."""
    SCALED = 2
    """Less than the whole commanded twist was aimed at (KeepDirection)."""
    DAMPED = 4
    """The damping factor is above 0."""
    SINGULAR = 8
    """The working joints' Jacobian has lost rank."""
    OVER_LIMIT = 16
    """The rates exceed a bound (Pseudoinverse only)."""
    NO_WORKING_JOINT = 32
    """Every joint has failed, and no fault leaves a choice."""
    FAULT_NOT_COMPENSATED = 64
    """A runaway joint moves the tool, and the others cannot make up for it."""
    CLIPPED = 128
    """Rates were cut to their bounds one by one (damping laws)."""
    LIMIT_GIVEN_UP = 256
    """Limits contradicted each other; the one of lower precedence was given up."""
    ITERATION_LIMIT = 512
    """A search reached its limit of steps; the result is the best found, inside the bounds."""
    INVALID_INPUT = 1024
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


class Reason(IntEnum):
    """Why a rate bound is what it is. In ``Solution.active`` negative at the lower bound, positive at the upper one."""

    FREE = 0
    FAULT = 1
    RATE = 2
    POSITION = 3
    ACCELERATION = 4


class Health(IntEnum):
    """State of a joint, as ``Run.health`` and ``Controller.health`` hold it."""

    HEALTHY = 0
    LOCKED = 1
    DERATED = 2
    RUNAWAY = 3
