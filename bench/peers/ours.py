"""stillreach: the bare optimum, `LeastError(price=None)`, and the default law, each on the whole arm."""

from collections.abc import Callable

import numpy as np

import stillreach as sr
from bench.peers.base import Robot


class Bound:
    """The caller's arrays, bound once; a tick reads and writes them in place."""

    packages = ("stillreach",)
    law: sr.Law = sr.LeastError(price=None)

    def __init__(self, robot: Robot) -> None:
        self.arm, self.working = sr.arms.nasa_modular(), robot.working
        self.controller = sr.Controller(self.arm, law=self.law, velocity_limits=robot.limit)
        for joint in robot.locked:
            self.controller.fail(int(joint))
        self.controller.reset()
        self.rates = np.zeros(robot.n)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        return self.arm.jacobian(q)[:, self.working]

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        self.controller.bind(q=q, twist=twist, rates=self.rates)()
        return self.rates

    def prepare(self, q: np.ndarray, twist: np.ndarray) -> Callable[[slice], None]:
        bind = self.controller.bind
        ticks = [bind(q=a, twist=b, rates=self.rates) for a, b in zip(q, twist, strict=True)]

        def run(part: slice) -> None:
            for tick in ticks[part]:
                tick()

        return run


class NewArray(Bound):
    """`Controller.step`, which answers with a new array."""

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        return self.controller.step(q, twist).rates

    def prepare(self, q: np.ndarray, twist: np.ndarray) -> Callable[[slice], None]:
        rows, step = list(zip(q, twist, strict=True)), self.controller.step

        def run(part: slice) -> None:
            for a, b in rows[part]:
                step(a, b).rates  # noqa: B018 - reading them is part of the work

        return run


class DefaultBound(Bound):
    law = sr.LeastError()


class DefaultNewArray(NewArray):
    law = sr.LeastError()


class Batch:
    """`solve_batch` on one thread."""

    packages = ("stillreach",)
    law: sr.Law = sr.LeastError(price=None)

    def __init__(self, robot: Robot) -> None:
        if not hasattr(sr, "solve_batch"):
            raise RuntimeError("the stillreach that is installed has no solve_batch")
        self.arm, self.working = sr.arms.nasa_modular(), robot.working
        self.bounds = sr.Bounds.symmetric(robot.limit, n=robot.n).lock([int(joint) for joint in robot.locked])

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        return self.arm.jacobian(q)[:, self.working]

    def solve(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        return sr.solve_batch(self.arm, self.law, q, twist, self.bounds, threads=1).rates


class BatchExact(Batch):
    law = sr.SingularityRobust(damping="exact")


class BatchPseudoinverse(Batch):
    law = sr.Pseudoinverse()
