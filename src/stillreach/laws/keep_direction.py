"""The law that slows down rather than leave the path."""

from __future__ import annotations

from dataclasses import dataclass

from stillreach._core import LawKind
from stillreach.laws.law import Law


@dataclass(frozen=True, kw_only=True)
class KeepDirection(Law):
    """The largest fraction of the commanded twist that the bounds allow, in its direction.

    Of the rates that give it, the law returns those nearest to the reference. ``Solution.scale`` is the fraction. If
    none is possible (the others cannot compensate a runaway joint), it returns LeastError's rates for a twist of zero,
    with scale 0.
    """

    word = "keep-direction"
    kind = LawKind.KEEP_DIRECTION
