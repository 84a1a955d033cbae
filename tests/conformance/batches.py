"""Rows for batches, the worst beside the ordinary, and their answers one at a time."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import stillreach as sr
from stillreach import _core
from stillreach.laws.law import row_names

INF = np.inf
BLOCK = 1000
ANSWERS = ("residual", "damping", "scale", "task_error", "active", "iterations")


@dataclass
class Rows:
    """N questions about one arm: q, lower, upper (N, n) and twist (N, 6)."""

    q: np.ndarray
    twist: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    def __len__(self):
        return len(self.q)

    def __getitem__(self, which):
        return Rows(self.q[which], self.twist[which], self.lower[which], self.upper[which])

    @property
    def bounds(self):
        """As solve_batch takes them."""
        return self.lower, self.upper


def mixed_rows(arm, count, seed=0):
    """Every kind of place, twist, fault and limit, each row its own; a row does not depend on `count`."""
    blocks = [_rows(arm.n, seed, k) for k in range(-(-max(count, 1) // BLOCK))]
    parts = (np.concatenate(part)[:count] for part in zip(*blocks, strict=True))
    return Rows(*(np.ascontiguousarray(part) for part in parts))


@lru_cache(maxsize=64)
def _rows(n, seed, block):
    rng = np.random.default_rng([seed, block])
    lower, upper = _limits(rng, n, BLOCK)
    _faults(rng, lower, upper)
    return _configurations(rng, n, BLOCK), _twists(rng, BLOCK), lower, upper


def _configurations(rng, n, count):
    q = rng.uniform(-np.pi, np.pi, (count, n))
    signs = np.where(np.arange(n) % 2 == 0, 1.0, -1.0)
    kind = rng.integers(0, 16, count)
    size = lambda which, low, high: 10.0 ** rng.uniform(low, high, (np.count_nonzero(which), 1))  # noqa: E731
    q[kind == 0] = 0.0
    q[kind == 1] = size(kind == 1, -17, -1) * signs
    q[kind == 2] *= size(kind == 2, -12, -1)  # nearly straight
    q[kind == 3] = rng.integers(-2, 3, (np.count_nonzero(kind == 3), n)) * (np.pi / 2)
    q[kind == 4] *= size(kind == 4, 1, 12)
    q[kind == 5, 1::2] *= size(kind == 5, -8, -1)
    return q


def _twists(rng, count):
    twist = rng.normal(size=(count, 6)) * 10.0 ** rng.uniform(-2.5, 1.0, (count, 1))
    kind = rng.integers(0, 32, count)
    some = [np.count_nonzero(kind == k) for k in range(8)]
    twist[kind == 0] = 0.0
    twist[kind == 1] = 1e300 * rng.choice([-1.0, 0.0, 1.0], (some[1], 6))
    twist[kind == 2] *= 5e-324 / 1e-3
    twist[kind == 3] *= 1e-310
    twist[kind == 4] = np.eye(6)[rng.integers(0, 6, some[4])]
    twist[kind == 5] *= 10.0 ** rng.uniform(-300, 290, (some[5], 1))
    twist[kind == 6] = -0.0
    twist[kind == 7] *= rng.choice([1e-60, 1e-50, 1e50, 1e60], (some[7], 1))
    return twist


def _limits(rng, n, count):
    """Both sides alike, per joint, one-sided, a window beside 0, some zero, some or all infinite, tiny, huge."""
    upper = np.full((count, n), 0.5)
    lower = -upper
    kind = rng.integers(0, 12, count)[:, None]
    spread = 0.5 * 10.0 ** rng.uniform(-1.0, 1.0, (count, n))
    side = rng.choice([0.0, 0.1, 1.0], (count, n))
    middle = rng.uniform(-0.5, 0.5, (count, n))
    some = rng.random((2, count, n)) < 0.4
    choices = {
        1: (-spread, spread),
        2: (-spread * side, spread),
        3: (middle - 0.2, middle + 0.2),
        4: (np.where(some[0], 0.0, lower), np.where(some[0], 0.0, upper)),
        5: (np.where(some[0], -INF, lower), np.where(some[1], INF, upper)),
        6: (np.full((count, n), -INF), np.full((count, n), INF)),
        7: (1e-9 * lower, 1e-9 * upper),
        8: (1e9 * lower, 1e9 * upper),
        9: (20.0 * lower, 20.0 * upper),
    }
    for number, (low, high) in choices.items():
        lower, upper = np.where(kind == number, low, lower), np.where(kind == number, high, upper)
    return lower, upper


def _faults(rng, lower, upper):
    """0 to n joints of each row with one rate left: 0, or a runaway's."""
    count, n = lower.shape
    failed = rng.integers(0, n + 1, count) * (rng.random(count) < 0.7)
    order = rng.permuted(np.tile(np.arange(n), (count, 1)), axis=1)
    stuck = order < failed[:, None]
    rate = np.where(rng.random((count, 1)) < 0.6, 0.0, rng.choice([0.0, 0.05, -0.3, 30.0], (count, n)))
    lower[stuck] = upper[stuck] = rate[stuck]


def ask_batch(arm, law, rows, **kwargs):
    """All rows at once, with everything there is to know."""
    want = (*ANSWERS, "jacobian") if "jacobians" in kwargs else (*ANSWERS, "jacobian", "pose")
    return sr.solve_batch(arm, law, rows.q, rows.twist, kwargs.pop("bounds", rows.bounds), want=want, **kwargs)


def ask_alone(law, jacobians, twist, bounds, *, reference=None, row_kinds=None, joint_kinds=None, length=None):
    """The same rows one by one, as ``law.solve`` asks the core; each answer an array of a batch's name."""
    settings = law.core(row_names(jacobians.shape[1], row_kinds), length)
    lower, upper = (bounds.lower, bounds.upper) if isinstance(bounds, sr.Bounds) else bounds
    metric = law._metric(*jacobians.shape[1:], row_kinds, joint_kinds)
    own = lambda values, i: values if values is None or np.ndim(values) == 1 else values[i]  # noqa: E731
    jacobians, twist = np.ascontiguousarray(jacobians), np.ascontiguousarray(twist)
    answers = [
        _core.solve(settings, metric, J, own(twist, i), own(lower, i), own(upper, i), own(reference, i))
        for i, J in enumerate(jacobians)
    ]
    return as_arrays(answers, *jacobians.shape[1:])


def as_arrays(answers, m, n):
    """Solutions as arrays of a batch's names, shapes and types."""
    shapes = {"rates": (n,), "residual": (m,), "active": (n,)}
    types = {"status": np.int32, "iterations": np.int32, "active": np.int8}
    return {
        name: np.array([getattr(answer, name) for answer in answers], dtype=types.get(name, float)).reshape(
            (len(answers), *shapes.get(name, ()))
        )
        for name in ("rates", "status", *ANSWERS)
    }


def differences(batch, alone, places=None):
    """What is not the same to the last bit, row by row, in words.

    Args:
        batch: BatchSolution.
        alone: arrays by name, of all rows, or of the rows `places`.
        places: indices of rows.
    """
    places = np.arange(len(batch)) if places is None else places
    found = []
    for name, expected in alone.items():
        have = getattr(batch, name)[places]
        assert have.shape == expected.shape, f"{name}: {have.shape} instead of {expected.shape}"
        wrong = bits(have) != bits(expected)
        for i in np.flatnonzero(wrong.any(axis=tuple(range(1, wrong.ndim)))):
            found.append(f"row {places[i]}, {name}: {have[i]} instead of {expected[i]}")
    return found


def bits(values):
    """The numbers as integers, so that -0.0 is not 0.0 and a NaN is itself."""
    values = np.ascontiguousarray(values)
    return values.view(np.int64) if values.dtype == np.float64 else values
