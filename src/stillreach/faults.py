"""Kinds of joint faults, one class each; ``FAULTS`` lists them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any, ClassVar

from stillreach import _door
from stillreach._forms import INF, JointName, Number, Sign
from stillreach._kinds import Kind, key, keys_of
from stillreach._reading import Reading
from stillreach._tables import Table, about
from stillreach.errors import InputError
from stillreach.status import Health

__all__ = ["Confined", "Derated", "Fault", "FreeSwinging", "Locked", "OneWay", "Runaway"]

MOMENT = Number("s", least=0.0)


class Loses(Enum):
    """What a fault takes from a joint; CHOICE: one rate is left."""

    CHOICE = auto()
    SPEED = auto()
    RANGE = auto()
    SIDE = auto()


class FaultKind(Kind):
    """Base of the kinds of faults."""

    health: ClassVar[Health]
    """The joint's state under this fault."""
    loses: ClassVar[Loses]
    """What the joint loses."""

    def driven(self, rate: float, limit: float) -> float:
        """The joint's rate when it is told one, with this velocity limit [rad/s, m/s], inside its range."""
        return 0.0 if self.loses is Loses.CHOICE else rate

    def positions(self, q: float) -> tuple[float, float]:
        """The ends [rad, m] of the range that a joint at q keeps, its position limits aside."""
        return -INF, INF

    def __post_init__(self) -> None:
        self.check_numbers()

    @property
    def numbers(self) -> tuple[float, float]:
        """The settings, as the two numbers that the core reads with the state."""
        first, second, *_ = *vars(self).values(), 0.0, 0.0
        return first, second

    def sentence(self, *, slides: bool) -> str:
        """The fault in a few words, for a prismatic or revolute joint."""
        return self.word


@dataclass(frozen=True)
class Locked(FaultKind):
    """The joint does not move (brake on): its rate is exactly 0."""

    word = "locked"
    health = Health.LOCKED
    loses = Loses.CHOICE


@dataclass(frozen=True)
class Derated(FaultKind):
    """The joint moves at most at a fraction of its velocity limits (weak motor, hot drive).

    Args:
        fraction: from 0 to 1.
    """

    word = "derated"
    health = Health.DERATED
    loses = Loses.SPEED

    fraction: float = field(metadata=key(Number(least=0.0, most=1.0), "Remaining share of the velocity limits, 0 to 1"))

    def driven(self, rate: float, limit: float) -> float:
        """At most the fraction of the limit."""
        most = self.fraction * limit if self.fraction else 0.0
        return min(max(rate, -most), most)

    def sentence(self, *, slides: bool) -> str:
        """``derated to 20 %``."""
        return f"derated to {100 * self.fraction:.3g} %"


@dataclass(frozen=True)
class Runaway(FaultKind):
    """The joint moves at a fixed rate that ignores commands.

    Args:
        rate: [rad/s, m/s].
    """

    word = "runaway"
    health = Health.RUNAWAY
    loses = Loses.CHOICE

    rate: float = field(metadata=key(Number("joint/s"), "The rate"))

    def driven(self, rate: float, limit: float) -> float:
        """The fault's rate."""
        return self.rate

    def sentence(self, *, slides: bool) -> str:
        """``runs away, 3 deg/s``."""
        return f"runs away, {_shown(self.rate, slides)}/s"


@dataclass(frozen=True)
class Confined(FaultKind):
    """The joint's range is reduced, in addition to its position limits.

    Rates towards an end decrease so that the joint can stop there. Outside the range it may move back in, but not
    further out. Its velocity limits stay in force.

    Args:
        lower: [rad, m] -inf: no end on this side.
        upper: [rad, m] at least ``lower``; inf: no end on this side.
    """

    word = "confined"
    health = Health.CONFINED
    loses = Loses.RANGE

    lower: float = field(metadata=key(Number("joint", least=-INF, most=INF), "The lower end of its range"))
    upper: float = field(metadata=key(Number("joint", least=-INF, most=INF), "The upper end of its range"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lower > self.upper or self.lower == INF or self.upper == -INF:
            got = f"{self.lower:g} with upper {self.upper:g}"
            raise InputError("lower", got, "lower <= upper, with room for a position")

    def positions(self, q: float) -> tuple[float, float]:
        """The reduced range."""
        return self.lower, self.upper

    def sentence(self, *, slides: bool) -> str:
        """``confined to -30 deg … 45 deg``."""
        return f"confined to {_shown(self.lower, slides)} … {_shown(self.upper, slides)}"


@dataclass(frozen=True)
class OneWay(FaultKind):
    """The joint moves in one direction only, up to its velocity limit in that direction.

    Args:
        direction: +1 (rates of at least 0) or -1 (at most 0).
    """

    word = "one-way"
    health = Health.ONE_WAY
    loses = Loses.SIDE

    direction: float = field(metadata=key(Sign(), "1: rates of at least 0; -1: at most 0"))

    def driven(self, rate: float, limit: float) -> float:
        """Nothing against the direction."""
        return max(rate, 0.0) if self.direction > 0.0 else min(rate, 0.0)

    def positions(self, q: float) -> tuple[float, float]:
        """From where it stands on."""
        return (q, INF) if self.direction > 0.0 else (-INF, q)

    def sentence(self, *, slides: bool) -> str:
        """``moves one way, +``."""
        return f"moves one way, {'+' if self.direction > 0.0 else '-'}"


@dataclass(frozen=True)
class FreeSwinging(FaultKind):
    """The joint has lost its drive and moves as forces move it (English and Maciejewski, 1998).

    It is not commanded: its rate is 0. Where it has swung to, the next tick measures. In a simulation without inertia
    it stands still; in MuJoCo it swings.
    """

    word = "free-swinging"
    health = Health.FREE_SWINGING
    loses = Loses.CHOICE

    def sentence(self, *, slides: bool) -> str:
        """``swings freely``."""
        return "swings freely"


def _shown(value: float, slides: bool) -> str:
    """A joint value in mm or degrees."""
    return f"{1000.0 * value:.3g} mm" if slides else f"{math.degrees(value):.3g} deg"


FAULTS: tuple[type[FaultKind], ...] = (Locked, Derated, Runaway, Confined, OneWay, FreeSwinging)
"""Every kind of fault."""


def losing(loss: Loses) -> list[int]:
    """The states (``health``) of joints that lose it."""
    return [int(kind.health) for kind in FAULTS if kind.loses is loss]


def fault_kind(name: str, value: Any) -> FaultKind:
    """The value, if it is a fault kind; otherwise raises InputError with the choices."""
    if isinstance(value, FAULTS):
        return value
    calls = [f"{kind.__name__}({', '.join(kind.keys())})" for kind in FAULTS]
    raise InputError(name, _door.describe(value), f"{', '.join(calls[:-1])} or {calls[-1]}")


@dataclass(frozen=True)
class Fault:
    """A joint fails at a time, and may be restored at a later one.

    Args:
        joint: name or 0-based index.
        at: onset [s].
        kind: one of FAULTS, e.g. Derated(0.2).
        until: [s] when the joint is restored; None: never.
        known_after: [s] from the onset, and from the restoration, until the controller knows; inf: it never does.
    """

    joint: str | int = field(metadata=key(JointName(), "Name of the joint"))
    at: float = field(default=0.0, kw_only=True, metadata=key(MOMENT, "Onset"))
    kind: FaultKind = field(default=Locked(), kw_only=True)
    until: float | None = field(
        default=None, kw_only=True, metadata=key(MOMENT, "When the joint is restored; never if absent")
    )

    known_after: float = field(
        default=0.0,
        kw_only=True,
        metadata=key(Number("s", least=0.0, most=INF), "Time until the controller knows of onset and restoration"),
    )

    def __post_init__(self) -> None:
        known = _door.positive("known_after", self.known_after, or_zero=True, allow_inf=True)
        object.__setattr__(self, "known_after", known)
        object.__setattr__(self, "at", _door.positive("at", self.at, or_zero=True))
        fault_kind("kind", self.kind)
        if self.until is not None:
            until = _door.scalar("until", self.until)
            if until <= self.at:
                raise InputError("until", f"{until:g}", f"a time after the onset at {self.at:g} s")
            object.__setattr__(self, "until", until)


def fault_tables() -> dict[str, Table]:
    """The table of a fault of each kind in a file, by word."""
    return {kind.word: _table(kind) for kind in FAULTS}


def _table(kind: type[FaultKind]) -> Table:
    own = kind.keys()

    def build(values: dict[str, Any], reading: Reading) -> Fault:
        settings = {name: values.pop(name) for name in own}
        return Fault(**values, kind=kind.read(settings, reading))

    return Table(kind.__name__, about(kind), {**keys_of(Fault), **own}, build, kind.word)
