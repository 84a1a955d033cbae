"""Slower, but never off course."""

from __future__ import annotations

from dataclasses import dataclass

from stillreach._core import LawKind
from stillreach.laws.law import Law


@dataclass(frozen=True, kw_only=True)
class KeepDirection(Law):
    """The largest fraction of the commanded twist that the bounds allow, in its direction.

    Then the rates nearest to the reference. ``Solution.scale`` is the fraction. Where none is possible (a runaway joint
    that the others cannot make up for) the answer is LeastError's for a twist of zero, with scale 0.
    """

    word = "keep-direction"
    kind = LawKind.KEEP_DIRECTION
