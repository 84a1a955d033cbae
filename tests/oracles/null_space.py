"""Relative manipulability by its definition, one failure set at a time."""

import numpy as np


def manipulability(j):
    """w(J) = sqrt(det(J J')) of a full-row-rank J (m, n); 0 with fewer columns than rows."""
    m, n = j.shape
    return float(np.sqrt(max(np.linalg.det(j @ j.T), 0.0))) if n >= m else 0.0


def relative_manipulability(j, failed):
    """r_f = w(J without the columns `failed`) / w(J), a scalar."""
    return manipulability(np.delete(j, list(failed), axis=1)) / manipulability(j)


def least_jump(j, rates, failed):
    """The least change of `rates` (n,) that stops joints `failed` and keeps J rates, (n,); J full rank without them."""
    kept = np.setdiff1d(np.arange(len(rates)), failed)
    change = np.zeros(len(rates))
    change[list(failed)] = -rates[list(failed)]
    change[kept] = np.linalg.pinv(j[:, kept]) @ (-j[:, list(failed)] @ change[list(failed)])
    return change
