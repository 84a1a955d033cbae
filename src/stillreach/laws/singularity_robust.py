"""The paper's law: a damped inverse whose damping keeps every joint inside its velocity limit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from stillreach import _door
from stillreach._core import DampingKind, LawKind, NormKind
from stillreach._forms import Either, Number, Word
from stillreach._kinds import key
from stillreach.errors import InputError
from stillreach.laws.law import Law
from stillreach.task import Weights

DAMPINGS = {"exact": DampingKind.EXACT, "closed-form": DampingKind.CLOSED_FORM}
NORMS = {"inf": NormKind.MAXIMUM, "2": NormKind.EUCLIDEAN}


@dataclass(frozen=True, kw_only=True)
class SingularityRobust(Law):
    """Minimises |twist - J dq|² + κ |dq|² over the working joints (Bedrossian, 1994, eq. 5 to 8), both norms weighted.

    Limits act through dq = D u, where D is the bound on the side that each joint moves to: κ is chosen so that
    |u| <= 1, and damping acts on u (for one limit for all joints: on the rates). A joint rests on a zero bound where
    moving off it gains nothing. Rates beyond a bound are cut to it, with CLIPPED: under a given κ, and under a full
    matrix as joint weight, where a joint's two sides need not agree. A reference rate adds its null motion, as far as
    the bounds allow.

    Weights may be only positive semidefinite where P = Jᵀ W1 J + W2 of eq. (8) is regular over the working joints; κ
    then multiplies W2. ``solve`` rejects others. In loops and batches, where J changes, joint motions
    without weight stay at 0, and the status has SINGULAR.

    Args:
        damping: "exact": the smallest κ that meets the limit (eq. 10), 0 where the pseudoinverse does; as a function of
            the twist it can jump, because the largest rate does not always fall with κ. "closed-form": eq. 16, an upper
            estimate. Or κ itself, a number >= 0 in the units of the weighted J Jᵀ.
        norm: "inf", the largest |u|, or "2", the Euclidean norm of u.

    Raises:
        InputError: if damping or norm is invalid.
    """

    word = "singularity-robust"
    kind = LawKind.SINGULARITY_ROBUST
    semidefinite = True

    damping: str | float = field(
        default="exact",
        metadata=key(
            Either(Number(least=0.0), Word(*DAMPINGS)),
            "Rule for the damping, or the damping itself, in weighted units",
        ),
    )
    norm: str = field(default="inf", metadata=key(Word(*NORMS), "Norm of the rates that is limited"))

    def __post_init__(self) -> None:
        super().__post_init__()
        if isinstance(self.damping, str):
            if self.damping not in DAMPINGS:
                raise InputError("damping", repr(self.damping), "'exact', 'closed-form' or a number of at least 0")
        else:
            object.__setattr__(self, "damping", _door.positive("damping", self.damping, or_zero=True))
        _door.choice("norm", self.norm, tuple(NORMS))

    def core_settings(self, rows: Sequence[str], reach: float | None, weights: Weights) -> dict[str, Any]:
        """The rule for κ, or κ."""
        if isinstance(self.damping, str):
            return {"damping": DAMPINGS[self.damping], "norm": NORMS[self.norm]}
        return {"damping": DampingKind.NUMBER, "norm": NORMS[self.norm], "kappa": float(self.damping)}
