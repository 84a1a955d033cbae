"""What the conformance suite is made of: a law, an arm, a fault or a limit joins every test with one line here."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

import stillreach as sr
from tests.robots.catalogue import ROBOTS
from tests.unit.arm.coupled_arms import coupled
from tests.unit.arm.odd_arms import ODD_ARMS

INF = np.inf


@dataclass(frozen=True)
class Contract:
    """A law and what is true of it.

    Attributes:
        make: the law, with settings as keywords.
        bounded: its rates are inside the bounds.
        optimal: "error" or "scale", what a larger box can only better while nothing is damped; "" for neither.
        continuous: its rates do not jump with the rounding of J.
        of_vectors: it uses the singular vectors one by one, and those of equal singular values are anybody's choice.
    """

    make: Callable[..., sr.Law]
    bounded: bool = True
    optimal: str = ""
    continuous: bool = True
    of_vectors: bool = False


def _robust(damping, norm="inf", *, of_vectors=False):
    return Contract(partial(sr.SingularityRobust, damping=damping, norm=norm), of_vectors=of_vectors)


LAWS = {
    "pseudoinverse": Contract(sr.Pseudoinverse, bounded=False, optimal="error"),
    "damping 0": _robust(0.0),
    "damping 0.01": _robust(0.01),
    "exact damping": _robust("exact"),
    "exact damping, 2-norm": _robust("exact", "2"),
    "closed-form damping": _robust("closed-form", of_vectors=True),
    "closed-form damping, 2-norm": _robust("closed-form", "2"),
    "least error": Contract(sr.LeastError, optimal="error"),
    "least error, price 8": Contract(partial(sr.LeastError, price=8.0), optimal="error"),
    "least error, two prices": Contract(partial(sr.LeastError, price=(80.0, 8.0))),
    "least error, position first": Contract(partial(sr.LeastError, price="position-first")),
    "least error, bare": Contract(partial(sr.LeastError, price=None), optimal="error", continuous=False),
    "keep direction": Contract(sr.KeepDirection, optimal="scale", continuous=False),
}


@dataclass(frozen=True)
class Subject:
    """An arm and the rows of [v; w] that are its task; one in `sample` pairings of fault and limit is tried."""

    make: Callable[[], sr.Arm]
    rows: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    sample: int = 1


ARMS = {
    "paper": Subject(sr.arms.nasa_modular),
    "canadarm2": Subject(sr.arms.canadarm2),
    "planar, position": Subject(partial(sr.arms.planar, 4), rows=(0, 1)),
    "planar, height too": Subject(partial(sr.arms.planar, 5), rows=(0, 1, 2)),
    "one joint": Subject(partial(sr.arms.planar, 1)),
    "five joints": Subject(partial(sr.arms.snake, 5)),
    "snake of 30": Subject(partial(sr.arms.snake, 30)),
    "skew, pointing": Subject(ODD_ARMS["skew"], rows=(0, 1, 2, 3, 4)),
    "gantry": Subject(ODD_ARMS["slides and turns"]),
    "mounted": Subject(ODD_ARMS["mounted"]),
    "one slide": Subject(ODD_ARMS["one slide"], rows=(1,)),
}

SUBJECTS = (
    ARMS
    | {"coupled": Subject(coupled, sample=2)}
    | {name: Subject(robot.make, sample=8) for name, robot in ROBOTS.items()}
)
"""The arms, and robots that nobody here wrote."""


def _fixed(choose, rate=0.0):
    """The chosen joints have one rate left."""

    def fault(rng, lower, upper):
        chosen = choose(rng.permutation(len(lower)))
        lower, upper = lower.copy(), upper.copy()
        lower[chosen] = upper[chosen] = rate
        return lower, upper

    return fault


def _derated(rng, lower, upper):
    fraction = rng.choice([0.0, 0.2, 1.0], len(lower))
    return (np.where(fraction == 0.0, 0.0, np.where(fraction == 1.0, side, 0.2 * side)) for side in (lower, upper))


FAULTS = {
    "none": lambda rng, lower, upper: (lower, upper),
    "one locked": _fixed(lambda order: order[:1]),
    "several locked": _fixed(lambda order: order[: len(order) // 2]),
    "derated": _derated,
    "runaway": _fixed(lambda order: order[:1], rate=0.05),
    "several runaways": _fixed(lambda order: order[: len(order) // 3], rate=-0.3),
    "all but one": _fixed(lambda order: order[1:]),
    "all": _fixed(lambda order: order),
}


def _spread(rng, n):
    return 0.5 * 10.0 ** rng.uniform(-1.0, 1.0, n)


def _one_sided(rng, n):
    upper = _spread(rng, n)
    return -upper * rng.choice([0.0, 0.1, 1.0], n), upper


def _window(rng, n):
    """As of acceleration limits around the last rates: 0 is outside for some."""
    middle = rng.uniform(-0.5, 0.5, n)
    return middle - 0.2, middle + 0.2


def _zero_for_some(rng, n):
    upper = np.where(rng.random(n) < 0.4, 0.0, 0.5)
    return -upper, upper


def _some_infinite(rng, n):
    lower, upper = (np.where(rng.random(n) < 0.4, INF, 0.5) for _ in range(2))
    return -lower, upper


LIMITS = {
    "symmetric": lambda rng, n: (np.full(n, -0.5), np.full(n, 0.5)),
    "per joint": lambda rng, n: (-_spread(rng, n), _spread(rng, n)),
    "one-sided": _one_sided,
    "window": _window,
    "zero for some": _zero_for_some,
    "some infinite": _some_infinite,
    "infinite": lambda rng, n: (np.full(n, -INF), np.full(n, INF)),
    "tiny": lambda rng, n: (np.full(n, -1e-9), np.full(n, 1e-9)),
}
