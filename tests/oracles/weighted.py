"""The laws in weighted units, over the working joints, by a singular value decomposition.

The rows of J are divided by the row units (m,), its columns multiplied by the joint units (n,); there W1 (m, m)
measures the task error and W2 (n, n) the rates: e' W1 e + kappa dq' W2 dq is least over the working joints.
With W1 = C1'C1 and C2'C2 the working joints' block of W2 that is ||x - C1 J C2^-1 v||^2 + kappa ||v||^2 in
v = C2 (dq - offset). The offset is where dq' W2 dq alone is least: not zero where W2 couples a working joint with one
fixed at a rate.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

RANK_TOLERANCE = 1e-10


def full_weight(weight, n):
    """A weight given as None, a diagonal (n,) or a matrix (n, n), as a matrix."""
    if weight is None:
        return np.eye(n)
    weight = np.asarray(weight, float)
    return np.diag(weight) if weight.ndim == 1 else weight


def root(weight):
    """Upper triangular C with C'C = weight."""
    return np.linalg.cholesky(weight).T


@dataclass(frozen=True)
class Decomposed:
    """The problem over the working joints, weighted and decomposed.

    Attributes:
        working: (n,) bool, the joints whose bounds differ.
        start: (n,) rates of the others, and the offset of the working joints.
        u, s, vt: full singular value decomposition of the weighted Jacobian, s (min(m, k),).
        rank: singular values above the rank tolerance.
        x: weighted twist (m,) that the working joints should make.
        back: (k, k) from weighted to plain rates.
    """

    working: np.ndarray
    start: np.ndarray
    u: np.ndarray
    s: np.ndarray
    vt: np.ndarray
    rank: int
    x: np.ndarray
    back: np.ndarray

    @cached_property
    def coefficients(self):
        """c (k, r) and s2 (r,): the working joints' rates are their offset + c @ (1 / (s2 + kappa))."""
        r = self.rank
        beta = self.u[:, :r].T @ self.x
        return self.back @ (self.vt[:r].T * (self.s[:r] * beta)), self.s[:r] ** 2

    def rates(self, kappa=0.0):
        """Rates (n,) at damping `kappa`; the least-norm least-error rates at 0."""
        c, s2 = self.coefficients
        dq = self.start.copy()
        dq[self.working] += c @ (1.0 / (s2 + kappa))
        return dq

    def damped_rates(self, kappa):
        """Eq. (6) at `kappa` > 0: rates (n,) in which every singular value counts, however small."""
        beta = self.u[:, : len(self.s)].T @ self.x
        dq = self.start.copy()
        dq[self.working] += self.back @ (self.vt[: len(self.s)].T @ (self.s * beta / (self.s**2 + kappa)))
        return dq

    def null_rates(self, nu):
        """The part of `nu` (n,) that moves neither the task nor a fixed joint (n,), nearest in the rate weight."""
        out = np.zeros(len(nu))
        v = np.linalg.solve(self.back, nu[self.working])
        row = self.vt[: self.rank]
        out[self.working] = self.back @ (v - row.T @ (row @ v))
        return out

    @cached_property
    def condition(self):
        """Largest over smallest singular value kept; 1 where none is."""
        return self.s[0] / self.s[self.rank - 1] if self.rank else 1.0

    @cached_property
    def back_size(self):
        """Largest plain rates of weighted rates of length 1."""
        return np.linalg.norm(self.back, 2) if self.back.size else 0.0

    @cached_property
    def unreachable(self):
        """Length of the part of the weighted twist outside the range, over the smallest singular value kept."""
        if not self.rank:
            return 0.0
        u = self.u[:, : self.rank]
        return np.linalg.norm(self.x - u @ (u.T @ self.x)) / self.s[self.rank - 1]

    @cached_property
    def kind(self):
        """How the singular values lie to the rank tolerance: the class under which a case is counted."""
        if not np.any(self.working):
            return "no working joint"
        if self.s[0] == 0.0:
            return "rank deficient"
        ratio = self.s / self.s[0]
        if np.any((ratio >= RANK_TOLERANCE / 10) & (ratio <= RANK_TOLERANCE * 10)):
            return "near the rank tolerance"
        return "rank deficient" if np.any(ratio < RANK_TOLERANCE) else "regular"


def decompose(
    j,
    twist,
    lower,
    upper,
    *,
    row_units=1.0,
    joint_units=1.0,
    task=None,
    joints=None,
    rank_tolerance=RANK_TOLERANCE,
):
    """Weight and decompose the problem for J (m, n), twist (m,) and bounds (n,), equal where a joint does not work.

    `row_units` (m,) and `joint_units` (n,) or scalars; `task` is W1, `joints` W2, each None, a diagonal or a matrix.
    """
    m, n = j.shape
    working = lower != upper
    start = np.where(working, 0.0, lower)
    units = np.ones(n) * joint_units
    back = np.diag(units[working])
    if joints is not None:
        w2 = full_weight(joints, n)
        coupling = w2[np.ix_(working, ~working)] @ (start / units)[~working]
        block = w2[np.ix_(working, working)]
        start[working] = units[working] * np.linalg.solve(block, -coupling)
        back = back @ np.linalg.inv(root(block))
    c1 = np.diag(np.ones(m) / row_units) if task is None else root(full_weight(task, m)) / row_units
    u, s, vt = np.linalg.svd(c1 @ j[:, working] @ back)
    rank = int(np.sum(s > rank_tolerance * s[0])) if s.size and s[0] > 0 else 0
    return Decomposed(working, start, u, s, vt, rank, c1 @ (twist - j @ start), back)


def task_error(j, twist, rates, *, row_units=1.0, task=None):
    """sqrt(e' W1 e) of e = twist - J rates in row units, a scalar."""
    e = (twist - j @ rates) / row_units
    return np.sqrt(e @ full_weight(task, len(e)) @ e)
