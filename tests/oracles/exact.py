"""A linear program in rational arithmetic, for cases that floating-point solvers answer differently."""

from fractions import Fraction

import numpy as np


def largest_scale(j, x, lower, upper):
    """The largest s in [0, 1] with J dq = s x for a dq in the box, exactly for the doubles given; None: no dq at all.

    Shapes: `j` (m, n), `x` (m,), bounds `lower`, `upper` (n,), infinite ones allowed.
    """
    columns = [[_exact(v) for v in column] for column in (*j.T, -x)]
    low = [_exact(v) for v in lower] + [Fraction(0)]
    high = [_exact(v) for v in upper] + [Fraction(1)]
    program = _Program(columns, low, high)
    goal = [Fraction(0)] * len(columns)
    goal[-1] = Fraction(1)
    if not program.make_feasible():
        return None
    program.maximise(goal)
    return float(program.value[len(columns) - 1])


def _exact(v):
    """A Fraction; None for an infinity."""
    return Fraction(float(v)) if np.isfinite(v) else None


class _Program:
    """Columns a_i, sum of value_i a_i = 0, low_i <= value_i <= high_i (None: no bound), by Bland's simplex rule."""

    def __init__(self, columns, low, high):
        rows = range(len(columns[0]))
        self.low, self.high, self.count = low, high, len(columns)
        self.value = [low[i] if low[i] is not None else high[i] or Fraction(0) for i in range(self.count)]
        missing = [-sum(columns[i][r] * self.value[i] for i in range(self.count)) for r in rows]
        signs = [1 if m >= 0 else -1 for m in missing]
        self.table = [[signs[r] * c[r] for c in columns] + [Fraction(r == c) for c in rows] for r in rows]
        self.basis = [self.count + r for r in rows]  # a variable of its own for each row makes up for what is missing
        self.value += [abs(m) for m in missing]
        self.low, self.high = low + [Fraction(0) for _ in rows], high + [None for _ in rows]

    def make_feasible(self):
        """Whether there is a point at all; then it is one."""
        rows = len(self.basis)
        self.maximise([Fraction(0)] * self.count + [Fraction(-1)] * rows)
        self.high[self.count :] = [Fraction(0)] * rows
        return not any(self.value[self.count :])

    def maximise(self, goal):
        """Goes to a vertex where the sum of goal_i value_i is largest; it has to be bounded."""
        goal = goal + [Fraction(0)] * (len(self.value) - len(goal))
        while (entering := self._entering(goal)) is not None:
            self._move(*entering)

    def _entering(self, goal):
        for i in range(len(self.value)):
            if i in self.basis or (self.low[i] is not None and self.low[i] == self.high[i]):
                continue
            gain = goal[i] - sum(goal[b] * row[i] for b, row in zip(self.basis, self.table, strict=True))
            if gain > 0 and self.value[i] != self.high[i]:
                return i, 1
            if gain < 0 and self.value[i] != self.low[i]:
                return i, -1
        return None

    def _move(self, i, side):
        bound = self.high[i] if side > 0 else self.low[i]
        step, leaving = (None if bound is None else abs(bound - self.value[i])), None
        for r, b in enumerate(self.basis):
            slope = -side * self.table[r][i]
            end = self.high[b] if slope > 0 else self.low[b]
            if slope == 0 or end is None:
                continue
            room = (end - self.value[b]) / slope
            if step is None or room < step or (room == step and leaving is not None and b < self.basis[leaving]):
                step, leaving = room, r
        self.value[i] += side * step
        for r, b in enumerate(self.basis):
            self.value[b] -= side * step * self.table[r][i]
        if leaving is not None:
            self._pivot(leaving, i)

    def _pivot(self, r, i):
        pivot = self.table[r][i]
        self.table[r] = [v / pivot for v in self.table[r]]
        for other in range(len(self.table)):
            factor = self.table[other][i]
            if other != r and factor:
                self.table[other] = [v - factor * w for v, w in zip(self.table[other], self.table[r], strict=True)]
        self.basis[r] = i
