"""The default law: exact where the price pays for it, and continuous everywhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from stillreach._core import LawKind
from stillreach._kinds import key
from stillreach.laws.law import Law
from stillreach.laws.price import FORM, checked, parts
from stillreach.task import Weights


@dataclass(frozen=True, kw_only=True)
class LeastError(Law):
    """The rates that minimise Y |twist - J dq| + ½ |dq - reference|² inside the bounds; the error is not squared.

    Y = price · b, where b is the second largest rate limit of the working joints. The task is done exactly where that
    costs no more than the price: a joint goes to its full speed where this buys at least b / price of tool speed.
    Elsewhere this is damped least squares inside the bounds with κ = |error| / Y. The rates are continuous in
    configuration, twist, bounds and reference, also where joints saturate or the Jacobian loses rank: a change δ of the
    twist changes them by at most sqrt(2 Y δ).

    With a price for each part of the task, Y_v |e_v| + Y_w |e_w| + …, each part is done exactly or gives way according
    to its price. Prices are marginal: where no part can be done, some of each gives way.

    A task row that the arm can never serve (the height of a planar arm) costs nothing while it is commanded 0;
    otherwise it makes the other rows less accurate, unless it has a price of its own or is left out of the task.

    Args:
        price: what a task error costs. One number for the whole task is in units of its weights: 1/m for an error in
            metres, no unit for one in radians. A pair (position, orientation), or a mapping by rows such as
            ``{"position": 100, "wx wy": 8, "wz": 1}``, makes up to three parts, along the axes of the task's frame; the
            price of a part of v rows alone is divided by the arm's reach: 100 is about 80 per metre for an arm of
            1.3 m. ``"position-first"`` is (110, 7), with a ceiling: an orientation error rate above 0.3 b costs up to
            80 instead of 7. None: the bare optimum, the least error and then the least rates, which is not continuous.

    Raises:
        InputError: if the price is invalid.
    """

    word = "least-error"
    kind = LawKind.LEAST_ERROR

    price: float | str | tuple[float, float] | Mapping[str, float] | None = field(
        default=80.0, metadata=key(FORM, "What a task error costs, in units of the task's weights or by rows")
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "price", checked(self.price))

    def core_settings(self, rows: Sequence[str], reach: float | None, weights: Weights) -> dict[str, Any]:
        """The parts of the task and their prices."""
        return parts(self.price, rows, reach, weights)
