"""Arms, poses and a table: what all parts share."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

import stillreach as sr
from stillreach import _core
from tests.robots.catalogue import ROBOTS

PANDA_START = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.7, 0.8])
"""[rad] Where the Panda's circle starts."""
ELBOW = 3
"""Index of the elbow of an arm with seven joints."""
RATE = np.deg2rad(50.0)
"""[rad/s] Limit of the paper's arm."""
LAWS: dict[str, sr.Law] = {
    "80, the default": sr.LeastError(),
    '"position-first"': sr.LeastError(price="position-first"),
    "(100, 2)": sr.LeastError(price=(100.0, 2.0)),
}
BARE = sr.LeastError(price=None)


@dataclass(frozen=True)
class Machine:
    """An arm and its rate limits (n,) [rad/s]."""

    name: str
    arm: sr.Arm
    limits: np.ndarray

    @property
    def typical(self) -> float:
        """b of the healthy arm."""
        return _core.typical_rate(self.metric, self.limits)

    @property
    def metric(self) -> _core.Metric:
        """One metre, one radian."""
        return sr.Weights().metric([True] * 3 + [False] * 3, [kind == "prismatic" for kind in self.arm.kinds])

    def poses(self, count: int, seed: int) -> np.ndarray:
        """(count, n) uniform between the position limits, between ±π where there are none."""
        lower, upper = np.clip(self.arm.position_limits, -np.pi, np.pi).T
        return np.random.default_rng(seed).uniform(lower, upper, (count, self.arm.n))


def panda() -> Machine:
    """Its flange, as the circle's."""
    return machine("Panda", replace(ROBOTS["Panda"], tip="panda_link8").make())


def machine(name: str, arm: sr.Arm, limits: float | None = None) -> Machine:
    """An arm with its own limits, or one for all joints."""
    return Machine(name, arm, np.array(arm.velocity_limits) if limits is None else np.full(arm.n, limits))


def machines() -> list[Machine]:
    """Those of the tables."""
    files = {
        "iiwa 14": "iiwa 14",
        "xArm7": "xArm7",
        "TALOS, torso and arm": "TALOS 9",
        "human, pelvis to hand": "human 13",
    }
    others = [machine(name, ROBOTS[file].make()) for file, name in files.items()]
    return [
        panda(),
        *others,
        machine("the paper's", sr.arms.nasa_modular(), RATE),
        machine("Canadarm2", sr.arms.canadarm2()),
    ]


def twists(count: int, speed: float, seed: int) -> np.ndarray:
    """(count, 6) random directions with a linear speed of `speed` [m/s]."""
    x = np.random.default_rng([seed, 6]).normal(size=(count, 6))
    return x * (speed / np.linalg.norm(x[:, :3], axis=1))[:, None]


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Markdown."""
    head = list(head)
    lines = [head, ["---"] * len(head), *([str(cell) for cell in row] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def percent(values: np.ndarray, digits: int = 2) -> str:
    """The share of True, or a mean, in per cent."""
    return f"{100.0 * float(np.mean(values)):.{digits}f}"


@dataclass(frozen=True)
class Claim:
    """What a table must show, and whether it does."""

    text: str
    holds: bool

    def __str__(self) -> str:
        return f"- {'met' if self.holds else 'NOT MET'}: {self.text}"


Part = tuple[str, list[Claim]]
"""A table and its claims."""
