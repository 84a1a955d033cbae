"""Relative manipulability: what is left of an arm's manipulability without some of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import comb, sqrt

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray


def null_basis(J: FloatArray) -> FloatArray:
    """(n, n - m) orthonormal basis of the null space of a Jacobian (m, n) of full rank, as columns."""
    _, _, Vt = np.linalg.svd(J, full_matrices=True)
    return np.ascontiguousarray(Vt[len(J) :].T)


def failure_sets(joints: Sequence[int], size: int) -> npt.NDArray[np.int64]:
    """(C, size) all sets of so many joints, by index."""
    return np.array(list(combinations(joints, size)), dtype=np.int64).reshape(-1, size)


def without(basis: FloatArray, sets: npt.NDArray[np.int64]) -> FloatArray:
    """(C,) manipulability without each set of joints (C, f) over manipulability with them, 0 to 1.

    It is the product of the singular values of the sets' rows of a basis of the null space (n, n - m): one
    decomposition of the Jacobian serves every set, and no digits are lost where little is left.
    """
    if sets.shape[1] > basis.shape[1]:
        return np.zeros(len(sets))
    return np.asarray(np.prod(np.linalg.svd(basis[sets], compute_uv=False), axis=1))


def best_possible(n: int, m: int, size: int) -> float:
    """The largest value of the worst set of so many joints that any arm of n joints has in m directions."""
    return sqrt(comb(n - m, size) / comb(n, size)) if size <= n - m else 0.0
