"""How fast rates inside their bounds move the tool: in every direction, and in one."""

from __future__ import annotations

from itertools import combinations
from math import comb
from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.bounds import Bounds
from stillreach.laws import KeepDirection
from stillreach.task import Task

MOST_NORMALS = 5_000
"""Normals of a zonotope that are looked at: all of up to 16 joints in 6 directions."""
SEED = 1994
FAR = 1e4
"""A speed, relative to that of all joints, that no arm reaches."""


def row_scales(task: Task) -> FloatArray:
    """(m,) what one unit of each row counts: lengths and angles in the units of the task's weights."""
    weights = task.weights
    units: tuple[Any, Any] = (1.0, 1.0) if weights is None else (weights.length, weights.angle)
    return np.array([1.0 / units[row >= 3] for row in task.indices])


def normals(J: FloatArray) -> tuple[FloatArray, bool]:
    """Unit normals of the facets of the tool's velocities, and whether these are all.

    Velocities J rates of rates in a box are a zonotope: each facet is parallel to m - 1 columns of J.

    Returns:
        (N, m), one of each pair of opposite facets.
    """
    m, n = J.shape
    if m == 1:
        return np.ones((1, 1)), True
    whole = comb(n, m - 1) <= MOST_NORMALS
    if whole:
        subsets = np.array(list(combinations(range(n), m - 1)), dtype=np.int64).reshape(-1, m - 1)
    else:
        rng = np.random.default_rng(SEED)
        subsets = np.array([rng.choice(n, m - 1, replace=False) for _ in range(MOST_NORMALS)])
    length = np.linalg.norm(J, axis=0)
    columns = (J / np.where(length > 0.0, length, 1.0)).T[subsets]
    _, sigma, Vt = np.linalg.svd(columns, full_matrices=True)
    return np.ascontiguousarray(Vt[sigma[:, -1] > 1e-9 * sigma[:, 0], -1]), whole


def guaranteed(J: FloatArray, facets: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """The speed that the tool reaches in every direction: the distance from 0 to the nearest facet.

    Args:
        J: (m, n), rows in units that may be compared.
        facets: (N, m) normals of J, or of a matrix with more columns.
        lower: (..., n) bounds of the rates, at most 0.
        upper: (..., n) at least 0.

    Returns:
        (...); 0 where the columns of joints that can move do not span all directions.
    """
    push = facets @ J
    ahead, back = np.maximum(push, 0.0), np.minimum(push, 0.0)
    forward = upper @ ahead.T + lower @ back.T
    backward = -(lower @ ahead.T + upper @ back.T)
    nearest = np.min(np.minimum(forward, backward), axis=-1, initial=np.inf)
    moving = upper > lower
    rank = np.linalg.matrix_rank(J * moving[..., None, :], tol=1e-12 * max(float(np.linalg.norm(J)), 1e-300))
    return np.where(rank == len(J), np.maximum(nearest, 0.0), 0.0)


def along(J: FloatArray, direction: FloatArray, lower: FloatArray, upper: FloatArray) -> float:
    """The largest speed along a unit direction (m,), with nothing in the others."""
    span = float(np.sum(np.linalg.norm(J, axis=0) * np.maximum(np.abs(lower), np.abs(upper))))
    if span == 0.0:
        return 0.0
    most = FAR * span
    return most * float(KeepDirection().solve(J, direction * most, Bounds(lower, upper)).scale)
