"""Slower, but never off course."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stillreach import _core
from stillreach.laws.law import Law
from stillreach.laws.price import ROWS
from stillreach.task import Weights


@dataclass(frozen=True, kw_only=True)
class KeepDirection(Law):
    """The largest fraction of the commanded twist that the bounds allow, in its direction.

    Then the rates nearest to the reference. ``Solution.scale`` is the fraction. Where none is possible (a runaway joint
    that the others cannot make up for) the answer is LeastError's for a twist of zero, with scale 0.
    """

    def core(self, rows: Sequence[str] = ROWS, reach: float | None = None, weights: Weights | None = None) -> _core.Law:
        """The settings as the compiled core reads them."""
        return _core.Law(_core.LawKind.KEEP_DIRECTION, rank_tolerance=self.rank_tolerance)
