"""What can be wrong with a joint."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import ClassVar

from stillreach import _door
from stillreach.errors import InputError
from stillreach.status import Health


@dataclass(frozen=True)
class Locked:
    """The joint stands where it is (brake on): rate exactly 0."""

    health: ClassVar = Health.LOCKED

    @property
    def numbers(self) -> tuple[float, float]:
        """The two numbers that the core reads beside the state."""
        return 0.0, 0.0


@dataclass(frozen=True)
class Derated:
    """The joint moves at most at a fraction of its rate limit (weak motor, hot drive).

    Args:
        fraction: from 0 to 1.
    """

    health: ClassVar = Health.DERATED
    fraction: float

    def __post_init__(self) -> None:
        value = _door.scalar("fraction", self.fraction)
        if not 0.0 <= value <= 1.0:
            raise InputError("fraction", f"{value:g}", "a number from 0 to 1")
        object.__setattr__(self, "fraction", value)

    @property
    def numbers(self) -> tuple[float, float]:
        """The two numbers that the core reads beside the state."""
        return self.fraction, 0.0


@dataclass(frozen=True)
class Runaway:
    """The joint moves at a rate that nobody commands.

    Args:
        rate: [rad/s, m/s].
    """

    health: ClassVar = Health.RUNAWAY
    rate: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate", _door.scalar("rate", self.rate))

    @property
    def numbers(self) -> tuple[float, float]:
        """The two numbers that the core reads beside the state."""
        return self.rate, 0.0


@dataclass(frozen=True)
class Confined:
    """The joint's range is reduced: it stays inside as inside position limits, which hold as well.

    Rates towards an end shrink so that the joint can stop there. Outside the range it may move back in and no further
    out. Its rate limit stays.

    Args:
        lower: [rad, m] -inf for no end on this side.
        upper: [rad, m] at least ``lower``; inf for no end on this side.
    """

    health: ClassVar = Health.CONFINED
    lower: float
    upper: float

    def __post_init__(self) -> None:
        lower, upper = _door.vector("range", (self.lower, self.upper), 2, allow_inf=True)
        if lower > upper or lower == inf or upper == -inf:
            raise InputError("range", f"{lower:g} to {upper:g}", "lower <= upper, with room for a position")
        object.__setattr__(self, "lower", float(lower))
        object.__setattr__(self, "upper", float(upper))

    @property
    def numbers(self) -> tuple[float, float]:
        """The two numbers that the core reads beside the state."""
        return self.lower, self.upper


@dataclass(frozen=True)
class OneWay:
    """The joint moves to one side only, up to its rate limit on that side.

    Args:
        direction: +1 (rates of at least 0) or -1 (at most 0).
    """

    health: ClassVar = Health.ONE_WAY
    direction: float

    def __post_init__(self) -> None:
        value = _door.scalar("direction", self.direction)
        if value not in (1.0, -1.0):
            raise InputError("direction", f"{value:g}", "+1 or -1")
        object.__setattr__(self, "direction", value)

    @property
    def numbers(self) -> tuple[float, float]:
        """The two numbers that the core reads beside the state."""
        return self.direction, 0.0


FaultKind = Locked | Derated | Runaway | Confined | OneWay


def fault_kind(name: str, value: object) -> FaultKind:
    """The value if it is a fault kind; InputError naming the choices otherwise."""
    if isinstance(value, FaultKind):
        return value
    choices = "Locked(), Derated(fraction), Runaway(rate), Confined(lower, upper) or OneWay(direction)"
    raise InputError(name, _door.describe(value), choices)


@dataclass(frozen=True)
class Fault:
    """A joint fails at a time, and may be restored at a later one.

    Args:
        joint: name or 0-based index.
        at: onset [s].
        kind: Locked(), Derated(fraction), Runaway(rate), Confined(lower, upper) or OneWay(direction).
        until: [s] when the joint is restored; None is never.
    """

    joint: str | int
    at: float = field(default=0.0, kw_only=True)
    kind: FaultKind = field(default=Locked(), kw_only=True)
    until: float | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "at", _door.positive("at", self.at, or_zero=True))
        fault_kind("kind", self.kind)
        if self.until is not None:
            until = _door.scalar("until", self.until)
            if until <= self.at:
                raise InputError("until", f"{until:g}", f"a time after the onset at {self.at:g} s")
            object.__setattr__(self, "until", until)
