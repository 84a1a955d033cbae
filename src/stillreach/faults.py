"""What can be wrong with a joint: one class a kind, and ``FAULTS``, all of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

from stillreach import _door
from stillreach._forms import JointName, Number
from stillreach._kinds import Kind, Table, about, key, keys_of
from stillreach._reading import Reading
from stillreach.errors import InputError
from stillreach.status import Health

MOMENT = Number("s", least=0.0)


class FaultKind(Kind):
    """Base of the kinds of faults."""

    health: ClassVar[Health]
    """The joint's state under this fault."""

    @property
    def value(self) -> float:
        """What the core needs to know beside the state."""
        return 0.0

    @property
    def share(self) -> float:
        """What is left of the joint's velocity limits, 0 to 1."""
        return 0.0

    def sentence(self, *, slides: bool) -> str:
        """The fault in a few words, for a joint that slides or turns."""
        return self.word


@dataclass(frozen=True)
class Locked(FaultKind):
    """The joint stands where it is (brake on): rate exactly 0."""

    word = "locked"
    health = Health.LOCKED


@dataclass(frozen=True)
class Derated(FaultKind):
    """The joint moves at most at a fraction of its velocity limits (weak motor, hot drive).

    Args:
        fraction: from 0 to 1.
    """

    word = "derated"
    health = Health.DERATED

    fraction: float = field(metadata=key(Number(least=0.0, most=1.0), "What is left of the velocity limits, 0 to 1"))

    def __post_init__(self) -> None:
        value = _door.scalar("fraction", self.fraction)
        if not 0.0 <= value <= 1.0:
            raise InputError("fraction", f"{value:g}", "a number from 0 to 1")
        object.__setattr__(self, "fraction", value)

    @property
    def value(self) -> float:
        """The fraction."""
        return self.fraction

    @property
    def share(self) -> float:
        """The fraction."""
        return self.fraction

    def sentence(self, *, slides: bool) -> str:
        """``derated to 20 %``."""
        return f"derated to {100 * self.fraction:.3g} %"


@dataclass(frozen=True)
class Runaway(FaultKind):
    """The joint moves at a rate that nobody commands.

    Args:
        rate: [rad/s, m/s].
    """

    word = "runaway"
    health = Health.RUNAWAY

    rate: float = field(metadata=key(Number("joint/s"), "The rate"))

    def __post_init__(self) -> None:
        object.__setattr__(self, "rate", _door.scalar("rate", self.rate))

    @property
    def value(self) -> float:
        """The rate."""
        return self.rate

    def sentence(self, *, slides: bool) -> str:
        """``runs away, 3 deg/s``."""
        return (
            f"runs away, {1000 * self.rate:.3g} mm/s" if slides else f"runs away, {math.degrees(self.rate):.3g} deg/s"
        )


FAULTS: tuple[type[FaultKind], ...] = (Locked, Derated, Runaway)
"""Every kind of fault."""


def fault_kind(name: str, value: Any) -> FaultKind:
    """The value if it is a fault kind; InputError naming the choices otherwise."""
    if isinstance(value, FAULTS):
        return value
    calls = [f"{kind.__name__}({', '.join(own.name for own in fields(kind))})" for kind in FAULTS]  # type: ignore[arg-type]
    raise InputError(name, _door.describe(value), f"{', '.join(calls[:-1])} or {calls[-1]}")


@dataclass(frozen=True)
class Fault:
    """A joint fails at a time, and may be restored at a later one.

    Args:
        joint: name or 0-based index.
        at: onset [s].
        kind: Locked(), Derated(fraction) or Runaway(rate).
        until: [s] when the joint is restored; None is never.
    """

    joint: str | int = field(metadata=key(JointName(), "Name of the joint"))
    at: float = field(default=0.0, kw_only=True, metadata=key(MOMENT, "Onset"))
    kind: FaultKind = field(default=Locked(), kw_only=True)
    until: float | None = field(
        default=None, kw_only=True, metadata=key(MOMENT, "When the joint works again; never if absent")
    )

    def __post_init__(self) -> None:
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
