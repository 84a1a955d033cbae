"""A second look at an answer, from the data it holds: what is lost, what is weak, and whether it kept its word."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.status import Status

if TYPE_CHECKING:
    from stillreach._core import Solution


@dataclass(frozen=True)
class Check:
    """What ``Solution.check()`` found; true as a whole when every promise holds.

    Args:
        finite: all rates are finite.
        inside: all rates are inside their bounds, exactly.
        fixed: joints with one rate left have exactly that rate.
        residual: the reported residual is twist - J rates.
        excess: largest excess of a rate over its bound [rad/s, m/s].
        residual_error: largest difference of reported and recomputed residual.
    """

    finite: bool
    inside: bool
    fixed: bool
    residual: bool
    excess: float
    residual_error: float

    def __bool__(self) -> bool:
        return self.finite and self.inside and self.fixed and self.residual


def check(solution: Solution) -> Check:
    """Recomputes every promise of an answer from its data."""
    rates, lower, upper = solution.rates, solution.lower, solution.upper
    fixed = lower == upper
    excess = np.maximum(np.maximum(rates - upper, lower - rates), 0.0)
    difference, slack = 0.0, 0.0
    if Status.INVALID_INPUT not in solution.status:
        difference = float(np.max(np.abs(solution.twist - solution.jacobian @ rates - solution.residual), initial=0.0))
        slack = 1e-13 * float(np.max(np.abs(solution.twist) + np.abs(solution.jacobian) @ np.abs(rates), initial=0.0))
    return Check(
        finite=bool(np.all(np.isfinite(rates))),
        inside=bool(np.all((rates >= lower) & (rates <= upper))),
        fixed=bool(np.all(rates[fixed] == lower[fixed])),
        residual=difference <= slack,
        excess=float(np.max(excess, initial=0.0)),
        residual_error=difference,
    )


def singular_values(solution: Solution) -> FloatArray:
    """(min(m, working joints),) of the working joints' weighted Jacobian, falling."""
    J = _working(solution)
    return np.asarray(np.linalg.svd(J, compute_uv=False)) if J.size else np.zeros(0)


def lost_directions(solution: Solution) -> FloatArray:
    """(m, lost) orthonormal basis of the unit twists (in weighted units) that no working joint serves."""
    return _left(solution, 0.0)


def weak_directions(solution: Solution, threshold: float) -> FloatArray:
    """(m, weak) unit twists, weakest first, that unit rates move by less than the threshold (weighted units)."""
    return _left(solution, _door.positive("threshold", threshold, or_zero=True))


def text(solution: Solution) -> str:
    """One line for a prompt."""
    rates = np.array2string(solution.rates, precision=4, suppress_small=True, max_line_width=100, threshold=12)
    status = solution.status.name or str(int(solution.status))
    numbers = f"task_error={solution.task_error:.3g}, damping={solution.damping:.3g}, scale={solution.scale:.6g}"
    return f"Solution(rates={rates}, status={status}, {numbers})"


def _working(solution: Solution) -> FloatArray:
    """(m, working) columns of the weighted Jacobian whose joints have a choice left."""
    return np.asarray(solution.weighted_jacobian)[:, solution.lower < solution.upper]


def _left(solution: Solution, threshold: float) -> FloatArray:
    """(m, k) left singular vectors whose singular value counts as zero or is below the threshold, weakest first.

    What has no weight in the task is not lost.
    """
    J = _working(solution)
    m, rows = J.shape[0], J.shape[0] - solution.weightless
    if not J[:rows].size:
        return np.eye(m)[:, :rows]
    U, sigma, _ = np.linalg.svd(J[:rows], full_matrices=True)
    sigma = np.concatenate([sigma, np.zeros(rows - len(sigma))])
    weak = (sigma <= solution.rank_tolerance * sigma[0]) | (sigma < threshold)
    return np.vstack([U[:, weak][:, ::-1], np.zeros((m - rows, np.count_nonzero(weak)))])
