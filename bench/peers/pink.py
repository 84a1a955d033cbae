"""Pink with quadprog.

What makes it fast and fair: a model without the failed joints (Pink reads a velocity limit of zero as no limit, and an
equality constraint on them takes longer), a task that holds the twist itself (`FrameTask` with a target a step ahead
takes longer), no Levenberg-Marquardt damping, the configuration's data used in place.
"""

import numpy as np
import pinocchio as pin
from pink import Configuration, solve_ik
from pink.limits import VelocityLimit
from pink.tasks import Task

from bench.peers.base import TOOL, Robot

DAMPING = 1e-9
"""Large enough for quadprog, too small to miss a twist that can be done."""


class TwistTask(Task):
    """Move a frame with a twist in base axes; the displacement of one second."""

    def __init__(self, frame: int, nv: int) -> None:
        super().__init__(cost=None)
        self.frame, self.twist = frame, np.zeros(6)

    def compute_error(self, configuration: Configuration) -> np.ndarray:
        return -self.twist

    def compute_jacobian(self, configuration: Configuration) -> np.ndarray:
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        return pin.getFrameJacobian(configuration.model, configuration.data, self.frame, axes)

    def __repr__(self) -> str:
        return f"TwistTask({self.frame})"


class Peer:
    packages = ("pin-pink", "quadprog", "pin")

    def __init__(self, robot: Robot) -> None:
        model = pin.buildModelFromUrdf(robot.path("working.urdf"))
        self.configuration = Configuration(model, model.createData(), np.zeros(model.nq), copy_data=False)
        self.task = TwistTask(model.getFrameId(TOOL), model.nv)
        self.tasks, self.limits = [self.task], [VelocityLimit(model)]
        self.working, self.rates = robot.working, np.zeros(robot.n)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        self.configuration.update(q[self.working])
        return self.task.compute_jacobian(self.configuration)

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        self.configuration.update(q[self.working])
        self.task.twist = twist
        self.rates[self.working] = solve_ik(
            self.configuration, self.tasks, 1.0, solver="quadprog", damping=DAMPING, limits=self.limits
        )
        return self.rates
