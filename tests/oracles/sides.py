"""The damping laws where a joint's two bounds differ: dq = D u, D the bound on the side that the joint moves to.

Each joint is split into a motion up and one down, neither negative: least ||x - A z||^2 + kappa ||z||^2 over z >= 0 by
SciPy's bounded-variable least squares (Stark and Parker, 1995). With kappa > 0 no joint uses both.
"""

import numpy as np
from scipy.optimize import lsq_linear

from oracles.damping import rate_norm
from oracles.weighted import RANK_TOLERANCE, full_weight, root


class Sided:
    """A case without a full joint weight, every joint that works as one or two columns that may not be negative.

    Attributes:
        columns: (m, c) weighted; `joint` (c,) whose they are; `back` (c,) from z to plain rates, signed.
        least: (c,) what a bound beyond zero leaves of z.
        extents: (c,) bounds that the columns' joints move to.
    """

    def __init__(self, case):
        m = len(case.twist)
        working = case.lower != case.upper
        self.start = np.where(working, 0.0, case.lower)
        c1 = root(full_weight(case.task, m)) / case.units["row_units"]
        self.x = c1 @ (case.twist - case.j @ self.start)
        unit = case.units["joint_units"]
        larger = np.maximum(case.upper, -case.lower)[working] / unit
        reference = np.max(larger[np.isfinite(larger)], initial=0.0) or 1.0
        joint, back, least, extents = [], [], [], []
        for i in np.flatnonzero(working):
            weight = 1.0 if case.joints is None else case.joints[i]
            for sign, near, far in ((1.0, case.lower[i], case.upper[i]), (-1.0, -case.upper[i], -case.lower[i])):
                if far > 0:
                    size = far / unit / reference if np.isfinite(far) else 1.0
                    joint.append(i)
                    back.append(sign * unit * size / np.sqrt(weight))
                    least.append(max(near, 0.0) / abs(back[-1]))
                    extents.append(far)
        self.joint, self.back, self.least, self.extents = (np.array(a) for a in (joint, back, least, extents))
        self.columns = (c1 @ case.j)[:, self.joint] * self.back
        self.size = np.linalg.norm(self.columns, 2)

    def moves(self, kappa):
        """The z (c,) of damping kappa > 0."""
        count = len(self.joint)
        damped = np.vstack([self.columns, np.sqrt(kappa) * np.eye(count)])
        right = np.concatenate([self.x, np.zeros(count)])
        return lsq_linear(damped, right, (self.least, np.inf), method="bvls", tol=1e-15, max_iter=1000).x

    def rates(self, z):
        """Plain rates (n,)."""
        return self.start + np.bincount(self.joint, self.back * z, len(self.start))

    def free(self, z):
        """(c,) which moves are off their bounds by more than rounding."""
        return z > self.least + 1e-12 * np.max(z, initial=0.0)

    def used(self, z, norm):
        """Norm of u over the joints that are free to move."""
        free = self.free(z)
        return rate_norm((np.abs(self.back) * z / self.extents)[free], norm) if np.any(free) else 0.0

    def closed_form(self, z, norm):
        """Eq. (16) over the joints that move in z; None where none does, or V is anything: equal singular values."""
        free = self.free(z)
        rest = self.x - self.columns[:, ~free] @ z[~free]
        u, s, vt = np.linalg.svd(self.columns[:, free], full_matrices=False)
        rank = np.count_nonzero(s > RANK_TOLERANCE * np.max(s, initial=0.0))
        u, s, vt = u[:, :rank], s[:rank], vt[:rank]
        if not s.size or np.min(-np.diff(s), initial=s[0]) < 1e-3 * s[0]:
            return None
        order = {"inf": np.inf, "2": 2}[norm]
        shapes = (np.abs(self.back) / self.extents)[free, None] * vt.T
        return (np.linalg.norm(shapes, order) * np.linalg.norm(u.T @ rest, order) / 2) ** 2
