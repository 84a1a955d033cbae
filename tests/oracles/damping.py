"""Exact damping, eq. (9) and (10), as "the smallest kappa that meets the limit", by interval bisection.

Along kappa the rates are sums of falling terms: rate_i(kappa) = offset_i + sum_j c_ij / (s2_j + kappa). The positive
terms alone and the negative terms alone are monotone: on an interval [a, b] their values at the ends enclose each rate.
An interval on which that enclosure stays above the limit holds no solution. The answer is the end of the first interval
that cannot be ruled out and is too narrow to split: no root is passed over, however the largest rate rises and falls.
"""

import numpy as np

NARROW = 1e-13  # width of the last interval over its upper end
PARTS = 32  # into how many parts an interval is split


def rates_at(c, s2, kappa, offset=0.0):
    """Rates (k,) at damping `kappa`, from coefficients c (k, r), squared singular values s2 (r,) and offset (k,)."""
    return offset + c @ (1.0 / (s2 + kappa))


def rate_norm(rates, norm):
    """Largest absolute rate for "inf", Euclidean length for "2"; `rates` (k,) or (k, grid)."""
    return np.max(np.abs(rates), axis=0) if norm == "inf" else np.sqrt(np.sum(rates**2, axis=0))


def _lower_bound(c, s2, offset, edges, norm):
    """A number per interval between `edges` (g,) that the norm of the rates does not fall below on it, (g - 1,)."""
    terms = 1.0 / (s2[:, None] + edges)
    up, down = np.maximum(c, 0.0) @ terms, np.maximum(-c, 0.0) @ terms
    least = offset[:, None] + up[:, 1:] - down[:, :-1]
    most = offset[:, None] + up[:, :-1] - down[:, 1:]
    return rate_norm(np.maximum(np.maximum(least, -most), 0.0), norm)


def _first_possible(c, s2, offset, edges, level, norm):
    for i in np.flatnonzero(_lower_bound(c, s2, offset, edges, norm) <= level):
        a, b = edges[i], edges[i + 1]
        if b - a <= NARROW * b:
            return b
        found = _first_possible(c, s2, offset, np.linspace(a, b, PARTS + 1), level, norm)
        if found is not None:
            return found
    return None


def smallest_damping(c, s2, norm, level=1.0, offset=None, up_to=None):
    """The smallest kappa >= 0 at which the norm of the rates is at most `level`; None where there is none.

    c (k, r), s2 (r,) > 0, offset (k,); `norm` "inf" or "2"; `up_to` ends the search there. Right to a relative 1e-13.
    """
    offset = np.zeros(len(c)) if offset is None else offset
    if c.shape[0] == 0 or rate_norm(rates_at(c, s2, 0.0, offset), norm) <= level:
        return 0.0
    largest = _surely_enough(c, offset, norm, level) if up_to is None else up_to
    if largest is None:
        return None
    smallest = min(1e-3 * np.min(s2), 1e-3 * largest)
    decades = np.log10(largest / smallest)
    edges = np.concatenate(([0.0], np.geomspace(smallest, largest, int(10 * decades) + 2)))
    return _first_possible(c, s2, offset, edges, level, norm)


def _surely_enough(c, offset, norm, level):
    """A kappa that meets the level, as every term is below |c_ij| / kappa; None where the offset fills the level."""
    room = level - np.abs(offset) if norm == "inf" else level - np.linalg.norm(offset)
    return None if np.any(room <= 0) else 2.0 * rate_norm(np.sum(np.abs(c), axis=1) / room, norm)
