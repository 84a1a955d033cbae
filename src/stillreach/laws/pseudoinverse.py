"""The paper's baseline: the pseudoinverse of the working joints' Jacobian."""

from __future__ import annotations

from dataclasses import dataclass

from stillreach._core import LawKind
from stillreach.laws.law import Law


@dataclass(frozen=True, kw_only=True)
class Pseudoinverse(Law):
    """dq = B Jᵀ (J B Jᵀ)⁺ twist: least error, then least rates (Bedrossian, 1994, eq. 3).

    It applies fixed rates but no limits, and sets OVER_LIMIT if a rate exceeds a bound: a baseline, not for a real arm.
    A reference rate ν adds its null motion (B - B Jᵀ (J B Jᵀ)⁺ J B) ν. Weights may be semidefinite, as
    for ``SingularityRobust``.
    """

    word = "pseudoinverse"
    kind = LawKind.PSEUDOINVERSE
    keeps_bounds = False
    semidefinite = True
