"""Checks of a Solution from its own data: lost directions, weak directions, promises."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm.dexterity import LEAST_SPEED, directions, full_rates, least_speeds
from stillreach.errors import InputError
from stillreach.status import Status

if TYPE_CHECKING:
    from stillreach._core import Solution


@dataclass(frozen=True)
class Check:
    """Result of ``Solution.check()``; true if every promise holds.

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
    """Recomputes every promise of a solution from its data."""
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


def lost_directions(
    solution: Solution, *, rates: npt.ArrayLike | None = None, least: npt.ArrayLike | None = None
) -> FloatArray:
    """Directions in which the working joints can hardly move the tool, judged by what full rates give.

    Args:
        solution: the answer.
        rates: (n,) or one for all [rad/s, m/s] full rates of the joints; None, and for infinite ones: 1 rad/s, 1 m/s.
        least: (m,) or one for all [m/s, rad/s] speeds; a direction in which full rates give less is lost. None:
            1 mm/s and 0.1 deg/s for a task of six rows, 0.001 for other rows.

    Returns:
        (m, lost) orthonormal basis of unit twists in weighted units, the worst first.

    Raises:
        InputError: if a rate is negative, a speed is not positive, or their number is wrong.
    """
    J, row_weights = np.asarray(solution.jacobian), np.asarray(solution.row_weights)
    m, n = J.shape
    speeds = least_speeds(range(6)) if m == 6 else LEAST_SPEED
    wanted = _door.vector("least", least, m, default=speeds)
    if not np.all(wanted > 0.0):
        raise InputError("least", _door.describe(least), f"{m} speeds above 0 (or one for all)")
    full = full_rates(_door.vector("rates", rates, n, allow_inf=True, minimum=0.0, default=np.inf))
    working = np.asarray(solution.lower < solution.upper)
    rows = m - solution.weightless  # what has no weight in the task is not lost
    weighted, to_twist = row_weights @ (J * full)[:, working], np.asarray(np.linalg.pinv(row_weights))
    lost = directions(weighted[:rows], wanted, to_twist[:, :rows]).lost
    return np.vstack([lost, np.zeros((m - rows, lost.shape[1]))])


def weak_directions(solution: Solution, threshold: float) -> FloatArray:
    """(m, weak) unit twists, weakest first, that unit rates move by less than the threshold (weighted units).

    Those whose singular value is at most ``rank_tolerance`` times the largest are always among them.
    """
    weakest = _door.positive("threshold", threshold, or_zero=True)
    J = _working(solution)
    m, rows = J.shape[0], J.shape[0] - solution.weightless
    if not J[:rows].size:
        return np.eye(m)[:, :rows]
    U, sigma, _ = np.linalg.svd(J[:rows], full_matrices=True)
    sigma = np.concatenate([sigma, np.zeros(rows - len(sigma))])
    weak = (sigma <= solution.rank_tolerance * sigma[0]) | (sigma < weakest)
    return np.vstack([U[:, weak][:, ::-1], np.zeros((m - rows, np.count_nonzero(weak)))])


def text(solution: Solution) -> str:
    """One line for a prompt."""
    rates = np.array2string(solution.rates, precision=4, suppress_small=True, max_line_width=100, threshold=12)
    status = solution.status.name or str(int(solution.status))
    numbers = f"task_error={solution.task_error:.3g}, damping={solution.damping:.3g}, scale={solution.scale:.6g}"
    return f"Solution(rates={rates}, status={status}, {numbers})"


def _working(solution: Solution) -> FloatArray:
    """(m, working) columns of the weighted Jacobian whose joints have a choice left."""
    return np.asarray(solution.weighted_jacobian)[:, solution.lower < solution.upper]
