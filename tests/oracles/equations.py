"""The numbered equations of Bedrossian (1994), written as they are printed.

Shapes: `j` (m, n), `x` the twist (m,), `a` the rows of the identity that select the failed joints (f, n).
Inverses are written as inverses: use these only where the matrices are well conditioned.
"""

import numpy as np
from numpy.linalg import inv, pinv


def failed_rows(failed):
    """A (f, n): the rows of the identity at the failed joints `failed` (n,) bool."""
    return np.eye(len(failed))[np.flatnonzero(failed)]


def b_matrix(a):
    """B = I - A' (A A')^-1 A (n, n); an empty A gives the identity."""
    n = a.shape[1]
    return np.eye(n) - a.T @ inv(a @ a.T) @ a if len(a) else np.eye(n)


def eq3(j, x, a):
    """Eq. (3): dq = B J' (J B J')^-1 x, the pseudoinverse over the working joints, (n,)."""
    b = b_matrix(a)
    return b @ j.T @ inv(j @ b @ j.T) @ x


def null_projector(j, a):
    """After eq. (1), with failed joints: N = B - B J' (J B J')^+ J B (n, n); J N = 0 and A N = 0."""
    b = b_matrix(a)
    return b - b @ j.T @ pinv(j @ b @ j.T, rcond=1e-12, hermitian=True) @ j @ b


def eq5(j, x, kappa):
    """Eq. (5): dq = (J'J + kappa I)^-1 J' x (n,)."""
    return inv(j.T @ j + kappa * np.eye(j.shape[1])) @ j.T @ x


def eq6(j, x, kappa):
    """Eq. (6): dq = J' (J J' + kappa I)^-1 x (n,)."""
    return j.T @ inv(j @ j.T + kappa * np.eye(j.shape[0])) @ x


def eq7(j, w1, w2):
    """Eq. (7): P = J' W1 J + W2 (n, n)."""
    return j.T @ w1 @ j + w2


def eq8(j, x, a, w1, w2):
    """Eq. (8): dq = P^-1 [I - A' (A P^-1 A')^-1 A P^-1] J' W1 x (n,)."""
    p = inv(eq7(j, w1, w2))
    kept = np.eye(j.shape[1])
    if len(a):
        kept = kept - a.T @ inv(a @ p @ a.T) @ a @ p
    return p @ kept @ j.T @ w1 @ x


def compact_svd(j, a, rank_tolerance=1e-10):
    """U (m, r), s (r,), V (n, r) of J B, singular values above `rank_tolerance` times the largest.

    Failed joints have zero rows in V.
    """
    u, s, vt = np.linalg.svd(j @ b_matrix(a), full_matrices=False)
    r = int(np.sum(s > rank_tolerance * s[0]))
    v = vt[:r].T.copy()
    v[np.any(a != 0, axis=0)] = 0.0
    return u[:, :r], s[:r], v


def eq12(j, x, a, kappa, rank_tolerance=1e-10):
    """Eq. (12): eq. (6) by the singular value decomposition, dq = V diag(s / (s^2 + kappa)) U' x (n,)."""
    u, s, v = compact_svd(j, a, rank_tolerance)
    return v @ (s / (s**2 + kappa) * (u.T @ x))


def eq16(j, x, a, limit, norm, rank_tolerance=1e-10):
    """Eq. (16): kappa = [||V|| ||U'x|| / (2 limit)]^2, `norm` "inf" (row sums; largest entry) or "2"."""
    u, _, v = compact_svd(j, a, rank_tolerance)
    if v.shape[1] == 0:
        return 0.0
    order = np.inf if norm == "inf" else 2
    return (np.linalg.norm(v, order) * np.linalg.norm(u.T @ x, order) / (2.0 * limit)) ** 2
