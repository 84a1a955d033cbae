"""What can be wrong with a joint."""

from __future__ import annotations

from dataclasses import dataclass, field

from stillreach import _door
from stillreach.errors import InputError
from stillreach.status import Health


@dataclass(frozen=True)
class Locked:
    """The joint stands where it is (brake on): rate exactly 0."""

    @property
    def health(self) -> Health:
        """The joint's state under this fault."""
        return Health.LOCKED

    @property
    def value(self) -> float:
        """What the core needs to know beside the state."""
        return 0.0


@dataclass(frozen=True)
class Derated:
    """The joint moves at most at a fraction of its rate limit (weak motor, hot drive).

    Args:
        fraction: from 0 to 1.
    """

    fraction: float

    def __post_init__(self) -> None:
        value = _door.scalar("fraction", self.fraction)
        if not 0.0 <= value <= 1.0:
            raise InputError("fraction", f"{value:g}", "a number from 0 to 1")
        object.__setattr__(self, "fraction", value)

    @property
    def health(self) -> Health:
        """The joint's state under this fault."""
        return Health.DERATED

    @property
    def value(self) -> float:
        """What the core needs to know beside the state."""
        return self.fraction


@dataclass(frozen=True)
class Runaway:
    """The joint moves at a rate that nobody commands.

    Args:
        rate: [rad/s, m/s].
    """

    rate: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate", _door.scalar("rate", self.rate))

    @property
    def health(self) -> Health:
        """The joint's state under this fault."""
        return Health.RUNAWAY

    @property
    def value(self) -> float:
        """What the core needs to know beside the state."""
        return self.rate


FaultKind = Locked | Derated | Runaway


def fault_kind(name: str, value: object) -> FaultKind:
    """The value if it is a fault kind; InputError naming the choices otherwise."""
    if isinstance(value, Locked | Derated | Runaway):
        return value
    raise InputError(name, _door.describe(value), "Locked(), Derated(fraction) or Runaway(rate)")


@dataclass(frozen=True)
class Fault:
    """A joint fails at a time, and may be restored at a later one.

    Args:
        joint: name or 0-based index.
        at: onset [s].
        kind: Locked(), Derated(fraction) or Runaway(rate).
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
