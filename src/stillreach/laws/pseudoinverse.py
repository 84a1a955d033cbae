"""The paper's baseline: the pseudoinverse of the working joints' Jacobian."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stillreach import _core
from stillreach.laws.law import Law
from stillreach.laws.price import ROWS
from stillreach.task import Weights


@dataclass(frozen=True, kw_only=True)
class Pseudoinverse(Law):
    """dq = B Jᵀ (J B Jᵀ)⁺ twist: least error, then least rates (Bedrossian, 1994, eq. 3).

    It honours fixed rates but no limits, and says OVER_LIMIT when it exceeds a bound: a baseline, not for a real arm. A
    reference rate ν adds its null motion (B - B Jᵀ (J B Jᵀ)⁺ J B) ν. Weights may be semidefinite, as of
    ``SingularityRobust``.
    """

    semidefinite = True

    def core(self, rows: Sequence[str] = ROWS, reach: float | None = None, weights: Weights | None = None) -> _core.Law:
        """The settings as the compiled core reads them."""
        return _core.Law(_core.LawKind.PSEUDOINVERSE, rank_tolerance=self.rank_tolerance)
