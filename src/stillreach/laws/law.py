"""The base of all laws: weights, rank tolerance, and ``solve`` for one Jacobian."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from stillreach import _core, _door
from stillreach._door import FloatArray
from stillreach._forms import Number
from stillreach._kinds import Kind, key
from stillreach.bounds import Bounds
from stillreach.errors import InputError
from stillreach.laws.price import ROWS
from stillreach.task import UNIT_WEIGHTS, Weights, some_joint_unweighted, weight_root


@dataclass(frozen=True, kw_only=True)
class Law(Kind):
    """Base of all laws.

    Args:
        weights: units and weights of task and rates; None: those of the task, or one metre and one radian.
        rank_tolerance: singular values of the working joints' weighted Jacobian below this, relative to the largest,
            count as zero.
    """

    kind: ClassVar[_core.LawKind]
    """The kind in the core."""
    keeps_bounds: ClassVar[bool] = True
    """Whether its rates are inside the bounds."""
    semidefinite: ClassVar[bool] = False
    """Whether weights may be only positive semidefinite."""

    weights: Weights | None = None
    rank_tolerance: float = field(
        default=1e-10,
        metadata=key(
            Number(above=0.0, below=1.0), "Singular values below this, relative to the largest, count as zero"
        ),
    )

    def __post_init__(self) -> None:
        if self.weights is not None and not isinstance(self.weights, Weights):
            raise InputError("weights", _door.describe(self.weights), "stillreach.Weights")
        self.check_numbers()

    def core(self, rows: Sequence[str] = ROWS, reach: float | None = None, weights: Weights | None = None) -> _core.Law:
        """The settings as the compiled core reads them.

        Args:
            rows: names of the task's rows.
            reach: [m] a length typical of the arm.
            weights: those of the task, for laws without their own.
        """
        if not hasattr(self, "kind"):
            raise TypeError(f"{type(self).__name__} is a base class; use one of the laws")
        own = self.core_settings(rows, reach, self.weights or weights or UNIT_WEIGHTS)
        return _core.Law(self.kind, rank_tolerance=self.rank_tolerance, **own)

    def core_settings(self, rows: Sequence[str], reach: float | None, weights: Weights) -> dict[str, Any]:
        """The settings of this law alone, as arguments of the core's ``Law``."""
        return {}

    def solve(
        self,
        J: npt.ArrayLike,
        twist: npt.ArrayLike,
        bounds: Bounds,
        *,
        reference: npt.ArrayLike | None = None,
        start: npt.ArrayLike | None = None,
        row_kinds: str | None = None,
        joint_kinds: str | None = None,
        velocity_limits: npt.ArrayLike | None = None,
        length: float | None = None,
    ) -> _core.Solution:
        """Returns the best joint rates for one Jacobian.

        Args:
            J: (m, n), m <= 6, any rank; six rows are [v; w] by default.
            twist: (m,) [m/s, rad/s] commanded.
            bounds: of the n rates.
            reference: (n,) [rad/s, m/s] rates to stay near, as far as the task allows; None: 0.
            start: (n,) ``active`` of an earlier solution, to start the search for active bounds; it changes the
                time, not the result.
            row_kinds: m letters, v for a row in m/s and w for one in rad/s; needed for m != 6 where length and angle
                have different units in the weights.
            joint_kinds: n letters, R revolute and P prismatic; None: all revolute.
            velocity_limits: (n,) [rad/s, m/s] of the joints, 0 for failed ones: the unit of LeastError's price; None:
                the larger of each joint's bounds.
            length: [m] a length typical of the arm; needed where LeastError has a price for v rows alone.

        Returns:
            Solution with the rates and diagnostics.

        Raises:
            InputError: if an argument is invalid, or eq. (8) with semidefinite weights has no unique solution for this
                Jacobian.
        """
        matrix = _door.matrix("J", J, (None, None))
        m, n = matrix.shape
        if not 1 <= m <= 6 or n < 1:
            raise InputError("J", f"a matrix of shape {matrix.shape}", "1 to 6 rows and at least one column")
        if not isinstance(bounds, Bounds):
            raise InputError("bounds", _door.describe(bounds), "stillreach.Bounds")
        if bounds.n != n:
            raise InputError("bounds", f"bounds of {bounds.n} joints", f"bounds of {n} joints, as J has columns")
        near = None if reference is None else _door.vector("reference", reference, n)
        begin = None if start is None else _door.codes("start", start, n, "Solution.active of an earlier solution")
        metric = self._metric(m, n, row_kinds, joint_kinds)
        typical = -1.0
        if velocity_limits is not None:
            limits = _door.vector("velocity_limits", velocity_limits, n, allow_inf=True, minimum=0.0)
            typical = _core.typical_rate(metric, limits)
        settings = self.core(row_names(m, row_kinds), None if length is None else _door.positive("length", length))
        solution = _core.solve(
            settings, metric, matrix, _door.vector("twist", twist, m), bounds.lower, bounds.upper, near, begin, typical
        )
        if self.weights is not None and some_joint_unweighted(self.weights):
            self._refuse_singular(solution, self.weights.joints)
        return solution

    def _metric(self, m: int, n: int, row_kinds: str | None, joint_kinds: str | None) -> _core.Metric:
        weights = self.weights or UNIT_WEIGHTS
        if row_kinds is None:
            if m != 6 and weights.length != weights.angle:
                raise InputError("row_kinds", "None", f"{m} letters, v for a row in m/s, w for one in rad/s")
            row_kinds = "vvvwww"[:m]
        rows = _letters("row_kinds", row_kinds, m, "vw")
        joints = _letters("joint_kinds", "R" * n if joint_kinds is None else joint_kinds, n, "RP")
        return weights.metric(
            [kind == "v" for kind in rows], [kind == "P" for kind in joints], semidefinite=self.semidefinite
        )

    def _refuse_singular(self, solution: _core.Solution, W2: FloatArray | None) -> None:
        """Raises InputError if P = J' W1 J + W2 of eq. (8) is singular over the working joints."""
        assert W2 is not None
        working = solution.lower < solution.upper
        parts = [np.asarray(part)[:, working] for part in (solution.weighted_jacobian, weight_root(W2))]
        sizes = [float(np.linalg.norm(part)) for part in parts]
        rows = [part / size for part, size in zip(parts, sizes, strict=True) if size > 0.0]
        k = int(np.count_nonzero(working))
        rank = int(np.linalg.matrix_rank(np.vstack(rows), tol=self.rank_tolerance)) if rows else 0
        if rank < k:
            raise InputError(
                "weights.joints",
                f"semidefinite weights, with no weight in {k - rank} of {k} directions of the working joints",
                "weights with a regular P = J' W1 J + W2 in eq. (8): motions without effect on the task need a weight",
            )


def row_names(m: int, row_kinds: str | None) -> tuple[str, ...]:
    """Names of the m rows of a bare Jacobian: all six, or their kinds."""
    return ROWS if m == 6 and row_kinds is None else tuple(row_kinds or "vvvwww"[:m])


def _letters(name: str, value: Any, count: int, letters: Sequence[str]) -> str:
    """Returns a text of ``count`` of the given letters; raises InputError otherwise."""
    if isinstance(value, str) and len(value) == count and set(value) <= set(letters):
        return value
    raise InputError(name, _door.describe(value), f"{count} letters, each {' or '.join(letters)}")
