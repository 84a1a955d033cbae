"""Seeded cases for the laws: every size, rank, scale, set of failed joints and kind of bound, odd ones included."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from oracles.kinematics import INCH, paper_arm
from oracles.weighted import Decomposed, decompose, full_weight, root

JACOBIANS = {  # kind: share
    "random": 0.3,
    "graded": 0.2,
    "rank deficient": 0.1,
    "duplicated": 0.1,
    "small integers": 0.1,
    "paper arm": 0.1,
    "paper arm near singular": 0.1,
}
FAILURES = {"none": 0.42, "some": 0.56, "all": 0.02}
TWISTS = {"random": 0.4, "reachable": 0.42, "axis": 0.15, "zero": 0.03}
BOUNDS = ("symmetric", "per joint", "one-sided", "some infinite", "infinite")
SYMMETRIC = ("symmetric",)


@dataclass(frozen=True)
class LawCase:
    """One question to a law.

    Attributes:
        j, twist: Jacobian (m, n) and twist (m,).
        lower, upper: bounds (n,); equal at failed joints.
        rows: for each row "v" or "w" (length or angle), (m,) characters.
        length, angle: units; `task` W1 and `joints` W2: None, a diagonal or a matrix.
        label: seed and number, and which kinds it was drawn from.
    """

    j: np.ndarray
    twist: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    rows: str
    length: float = 1.0
    angle: float = 1.0
    task: np.ndarray | None = None
    joints: np.ndarray | None = None
    label: str = field(default="")

    @property
    def failed(self) -> np.ndarray:
        """(n,) bool."""
        return self.lower == self.upper

    @property
    def units(self) -> dict:
        """Row units (m,) and joint units (all angles) in the oracles' words."""
        row_units = np.where(np.array(list(self.rows)) == "v", self.length, self.angle)
        return {"row_units": row_units, "joint_units": self.angle}

    @cached_property
    def decomposed(self) -> Decomposed:
        """The weighted problem over the working joints."""
        return decompose(self.j, self.twist, self.lower, self.upper, task=self.task, joints=self.joints, **self.units)

    @property
    def boxed(self) -> "Boxed":
        """The case as a least-squares problem in a box, in units where J, twist and W2 have length 1."""
        c1 = root(full_weight(self.task, len(self.twist))) / self.units["row_units"]
        j, x = c1 @ self.j, c1 @ self.twist
        size, length = np.linalg.norm(j) or 1.0, np.linalg.norm(x) or 1.0
        unit = length / size
        w2 = full_weight(self.joints, j.shape[1])
        return Boxed(j / size, x / length, self.lower / unit, self.upper / unit, w2 / np.linalg.norm(w2), unit)


@dataclass(frozen=True)
class Boxed:
    """||x - J dq|| over a box, dq in multiples of `unit`; `weight` (n, n) measures the rates."""

    j: np.ndarray
    x: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    weight: np.ndarray
    unit: float


def law_cases(count, seed, *, bounds=SYMMETRIC, weighted=0.0, runaways=0.0, scaled=0.1) -> Iterator[LawCase]:
    """`count` cases from `seed`.

    Args:
        count, seed: how many, and from where; case i does not depend on `count`.
        bounds: the kinds of bounds to draw from, a subset of BOUNDS.
        weighted: share of the cases with units and weights.
        runaways: share with a failed joint that moves.
        scaled: share with tiny or huge numbers.
    """
    for i in range(count):
        yield law_case(seed, i, bounds=bounds, weighted=weighted, runaways=runaways, scaled=scaled)


def law_case(seed, i, *, bounds=SYMMETRIC, weighted=0.0, runaways=0.0, scaled=0.1) -> LawCase:
    """Case i of ``law_cases(..., seed, ...)``."""
    rng = np.random.default_rng([seed, i])
    case = _jacobian_case(rng)
    if rng.random() < weighted:
        case = _with_weights(rng, case)
    case = _with_bounds(rng, case, bounds[rng.integers(len(bounds))], runaways)
    if rng.random() < scaled:
        case = _scaled(rng, case)
    return replace(case, label=f"case {seed}/{i}: {case.label}")


def _pick(rng, shares) -> str:
    """One of the keys of `shares`, as often as its value says."""
    steps = np.cumsum(list(shares.values()))
    return list(shares)[int(np.searchsorted(steps, rng.random() * steps[-1], side="right"))]


def _jacobian_case(rng) -> LawCase:
    kind = _pick(rng, JACOBIANS)
    if kind.startswith("paper arm"):
        j, rows = _arm_jacobian(rng, kind.endswith("singular"))
    else:
        m = int(rng.integers(1, 7))
        n = 40 if rng.random() < 0.02 else int(rng.integers(1, 14))
        j, rows = _matrix(rng, kind, m, n), "vvvwww" if m == 6 else "".join("vw"[w] for w in rng.integers(0, 2, m))
    m, n = j.shape
    wanted = _pick(rng, TWISTS)
    if wanted == "random":
        twist = rng.normal(size=m) * np.linalg.norm(j)
    elif wanted == "reachable":
        twist = j @ rng.normal(size=n)
    else:
        twist = np.eye(m)[rng.integers(m)] * np.linalg.norm(j) * (wanted == "axis")
    box = np.ones(n)
    return LawCase(j, twist, -box, box, rows, label=f"{kind}, {wanted} twist")


def _arm_jacobian(rng, near_singular):
    """The paper's arm in metres or inches, all six rows or some; near a straight pose on request."""
    q = rng.uniform(-np.pi, np.pi, 11)
    if near_singular:
        q[1::2] *= 10.0 ** rng.uniform(-12, -1)
    _, _, j = paper_arm(q)
    j[:3] /= INCH if rng.random() < 0.3 else 1.0
    kept = np.sort(rng.permutation(6)[: rng.integers(2, 7)]) if rng.random() < 0.3 else np.arange(6)
    return j[kept], "".join(np.array(list("vvvwww"))[kept])


def _matrix(rng, kind, m, n):
    if kind == "random":
        return rng.normal(size=(m, n))
    if kind == "small integers":
        return rng.integers(-1, 2, (m, n)).astype(float)
    if kind == "duplicated":
        j = rng.normal(size=(m, n))
        return j[:, rng.integers(0, n, n)] * rng.choice([1.0, 1.0, -2.0, 0.0], n)
    k = min(m, n)
    if kind == "rank deficient":
        r = int(rng.integers(0, k))
        return rng.normal(size=(m, r)) @ rng.normal(size=(r, n))
    u, v = (np.linalg.qr(rng.normal(size=(size, k)))[0] for size in (m, n))
    return u * 10.0 ** (np.linspace(0, -1, k) * rng.uniform(2, 12)) @ v.T


def _with_weights(rng, case):
    m, n = case.j.shape
    spread = lambda size: 10.0 ** rng.uniform(-1, 1, size)  # noqa: E731
    full = lambda size: (lambda a: a @ a.T + 0.1 * np.eye(size))(rng.normal(size=(size, size)))  # noqa: E731
    task = (None, spread(m), full(m))[rng.integers(3)]
    joints = (None, spread(n), full(n))[rng.integers(3)]
    length, angle = ((1.0, 1.0), (INCH, np.deg2rad(1)), (0.3, 2.0))[rng.integers(3)]
    return replace(case, task=task, joints=joints, length=length, angle=angle, label=case.label + ", weighted")


def _with_bounds(rng, case, kind, runaways):
    """Fail some joints, then size the bounds so that the pseudoinverse reaches 0.03 to 30 times its limit."""
    n = case.j.shape[1]
    number = {"none": 0, "some": int(rng.integers(0, n + 1)), "all": n}[_pick(rng, FAILURES)]
    failed = np.zeros(n, bool)
    failed[rng.permutation(n)[:number]] = True
    wanted = np.max(np.abs(np.linalg.lstsq(case.j[:, ~failed], case.twist, rcond=1e-10)[0]), initial=0.0)
    size = (wanted if wanted > 0 else 1.0) * 10.0 ** rng.uniform(-1.5, 1.5)
    upper = size * np.ones(n) if kind == "symmetric" else size * 10.0 ** rng.uniform(-1, 1, n)
    lower = -upper
    if kind == "one-sided":
        lower = -upper * rng.choice([0.0, 0.1, 1.0, 5.0], n)
    if kind == "some infinite":
        lower, upper = (np.where(rng.random(n) < 0.4, np.inf, side) for side in (upper, upper))
        lower = -lower
    if kind == "infinite":
        lower, upper = np.full(n, -np.inf), np.full(n, np.inf)
    moving = failed & (rng.random(n) < 0.5) if rng.random() < runaways else np.zeros(n, bool)
    rate = np.where(moving, size * rng.normal(size=n), 0.0)
    label = f"{case.label}, {kind} bounds, {n - number} of {n} joints work"
    return replace(case, lower=np.where(failed, rate, lower), upper=np.where(failed, rate, upper), label=label)


def _scaled(rng, case):
    """J and its twist times one number, rates (twist and bounds) times another."""
    a, b = 10.0 ** rng.uniform(-8, 8, 2)
    scaled = {"j": a * case.j, "twist": a * b * case.twist, "lower": b * case.lower, "upper": b * case.upper}
    return replace(case, label=case.label + ", scaled", **scaled)
