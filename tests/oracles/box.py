"""What LeastError and KeepDirection must reach, by solvers that share nothing with them.

Shapes: `j` (m, n) and `x` (m,) weighted, bounds `lower`, `upper` (n,), infinite ones allowed, rates (n,).
"""

import daqp
import numpy as np
from scipy.optimize import linprog, lsq_linear


def inside(rates, lower, upper):
    """`rates` moved componentwise to the nearest point of the box (n,)."""
    return np.minimum(np.maximum(rates, lower), upper)


def error(j, x, rates):
    """||x - J rates||, a scalar."""
    return float(np.linalg.norm(x - j @ rates))


def least_error_bvls(j, x, lower, upper):
    """Least ||x - J dq|| in the box by SciPy's bounded-variable least squares (Stark and Parker, 1995), (n,)."""
    free = lower != upper
    rates = np.where(free, 0.0, lower)
    if np.any(free):
        rest = x - j @ rates
        found = lsq_linear(j[:, free], rest, (lower[free], upper[free]), method="bvls", tol=1e-14, max_iter=500)
        rates[free] = found.x
    return inside(rates, lower, upper)


def least_error_daqp(j, x, lower, upper, rounds=8):
    """The same by a dual active-set QP (Arnström, 2022), (n,).

    J'J is singular for a redundant arm, so a small multiple of ||dq - last round's||^2 is added and the round repeated.
    """
    free = lower != upper
    rates = np.where(free, inside(np.zeros(len(lower)), lower, upper), lower)
    size = np.linalg.norm(j[:, free]) if np.any(free) else 0.0
    if size == 0.0:
        return rates
    a, rest = j[:, free] / size, (x - j @ np.where(free, 0.0, lower)) / size
    rho = 1e-8
    h = a.T @ a + rho * np.eye(a.shape[1])
    for _ in range(rounds):
        f = -(a.T @ rest + rho * rates[free])
        answer, _, flag, _ = daqp.solve(
            h, f, np.zeros((0, a.shape[1])), upper[free].copy(), lower[free].copy(), primal_tol=1e-12, dual_tol=1e-12
        )
        if flag != 1:
            break
        rates[free] = answer
    return inside(rates, lower, upper)


def excess_error_bound(j, x, lower, upper, rates):
    """A number that ||x - J rates|| exceeds the least possible error by at most: weak duality, no solver.

    With r = x - J rates and a = J'r: least^2 >= ||r||^2 - 2 sum_i (max(lower_i a_i, upper_i a_i) - rates_i a_i). An
    infinite side is replaced by one beyond the answer: a convex problem that cannot be improved nearby cannot at all.
    """
    r = x - j @ rates
    a = j.T @ r
    reach = 1.0 + np.max(np.abs(rates), initial=0.0)
    low = np.where(np.isfinite(lower), lower, rates - reach)
    high = np.where(np.isfinite(upper), upper, rates + reach)
    gap = np.sum(np.maximum((low - rates) * a, (high - rates) * a))
    e = np.linalg.norm(r)
    return e - np.sqrt(max(e**2 - 2.0 * gap, 0.0))


def nearest_same_motion(j, rates, lower, upper, reference, weight=None, tolerance=1e-10):
    """Among the dq in the box with J dq = J rates, the one nearest to `reference` (n,), by the dual active-set QP.

    Nearest in (dq - reference)' W2 (dq - reference), `weight` W2 (n, n) or None. None where the solver gives up.
    Directions of J below `tolerance` times its largest singular value are left out.
    """
    free = lower != upper
    found = np.where(free, 0.0, lower)
    k = int(np.sum(free))
    _, s, vt = np.linalg.svd(j[:, free], full_matrices=False)
    rows = vt[: len(s)][s > tolerance * np.max(s, initial=0.0)]
    target = rows @ rates[free]
    w2 = np.eye(len(rates)) if weight is None else weight
    linear = w2[np.ix_(free, ~free)] @ (found - reference)[~free] - w2[np.ix_(free, free)] @ reference[free]
    answer, _, flag, _ = daqp.solve(
        np.ascontiguousarray(w2[np.ix_(free, free)]),
        linear,
        np.ascontiguousarray(rows),
        np.concatenate((upper[free], target)),
        np.concatenate((lower[free], target)),
        np.concatenate((np.zeros(k), np.full(len(rows), 5))).astype(np.int32),
        primal_tol=1e-11,
        dual_tol=1e-12,
    )
    if flag != 1:
        return None
    found[free] = answer
    return found


def largest_scale(j, x, lower, upper):
    """The largest s in [0, 1] with J dq = s x for a dq in the box, by a linear program (HiGHS).

    Returns s, None where there is no dq at all, and ||J dq - s x|| of its own dq: HiGHS is content with 1e-10.
    """
    m, n = j.shape
    size = max(np.linalg.norm(j, 2), 1e-300)
    found = linprog(
        np.concatenate((np.zeros(n), [-1.0])),
        A_eq=np.column_stack((j, -x)) / size,
        b_eq=np.zeros(m),
        bounds=[*zip(lower, upper, strict=True), (0.0, 1.0)],
        method="highs",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if found.status != 0:
        return None, 0.0
    return float(found.x[-1]), float(np.linalg.norm(j @ inside(found.x[:-1], lower, upper) - found.x[-1] * x))


def scale_bound(j, x, lower, upper, rates):
    """A number that no feasible scale exceeds, from the joints that `rates` leaves between their bounds; inf at worst.

    Weak duality: for any y with y'x = 1, s = y' J dq <= sum_i max(lower_i a_i, upper_i a_i) with a = J'y. The best y
    has a_i = 0 at every joint between its bounds.
    """
    between = (rates > lower) & (rates < upper)
    wanted = np.append(np.zeros(np.sum(between)), 1.0)
    normal, *_ = np.linalg.lstsq(np.vstack((j[:, between].T, x)), wanted, rcond=1e-12)
    across = normal @ x
    if not across > 1e-12:
        return np.inf
    a = j.T @ (normal / across)
    a[between & (np.abs(a) < 1e-12 * np.max(np.abs(a), initial=0.0))] = 0.0
    with np.errstate(invalid="ignore"):
        sides = np.where(a > 0, upper * a, np.where(a < 0, lower * a, 0.0))
    return float(np.sum(sides))
