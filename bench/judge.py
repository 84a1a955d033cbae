"""What an answer is worth beside the time it took."""

from dataclasses import dataclass

import numpy as np

from bench.problem import Problem

INSIDE = 1e-9
"""A rate is over its limit if by more than this part of it; less is rounding."""
FOLLOWED = 1e-6
"""A twist is missed if the error is more than this part of it."""


@dataclass(frozen=True)
class Verdict:
    """What was wrong with the rates of all ticks."""

    ticks: int
    feasible: int
    over_limit: int
    """Ticks with a rate above the limit."""
    worst_over: float
    """Largest rate above the limit, as a part of it; negative: all were below."""
    locked_moved: int
    """Ticks with a locked joint told to move."""
    missed: int
    """Feasible ticks whose twist was not done."""
    excess: float
    """Error above the least possible, as a part of the twist: mean over the ticks that are not feasible."""
    worst_excess: float
    """The same of the worst of these ticks."""

    @property
    def safe(self) -> bool:
        """Inside the limits, and locked joints stand."""
        return self.over_limit == 0 and self.locked_moved == 0

    @property
    def clean(self) -> bool:
        """Safe, and no feasible tick missed."""
        return self.safe and self.missed == 0


def judge(problem: Problem, rates: np.ndarray) -> Verdict:
    """Rates (ticks, n) [rad/s]. NaN rates count as wrong in every respect."""
    if rates.shape != problem.q.shape:
        raise ValueError(f"rates have shape {rates.shape}, expected {problem.q.shape}")
    over = np.max(np.abs(rates[:, problem.working]), axis=1) / problem.limit - 1.0
    moved = np.max(np.abs(rates[:, problem.locked]), axis=1)
    error = np.linalg.norm(problem.twist - np.einsum("tij,tj->ti", problem.jacobian, rates), axis=1)
    length = np.linalg.norm(problem.twist, axis=1)
    excess = ((error - problem.least) / length)[~problem.feasible]
    return Verdict(
        ticks=len(problem),
        feasible=int(np.sum(problem.feasible)),
        over_limit=int(np.sum(~(over <= INSIDE))),
        worst_over=float(np.max(over)),
        locked_moved=int(np.sum(~(moved <= INSIDE * problem.limit))),
        missed=int(np.sum(~(error <= FOLLOWED * length) & problem.feasible)),
        excess=float(np.mean(excess)) if excess.size else 0.0,
        worst_excess=float(np.max(excess)) if excess.size else 0.0,
    )
