"""Pink with quadprog.

What makes it fast and fair: a model without the failed joints (Pink reads a velocity limit of zero as no limit; an
equality constraint would make the program larger, a model without them makes it smaller), a task of one's own that
holds the twist itself, no Levenberg-Marquardt damping, the configuration's data used in place. `FrameTaskPeer` is the
same with Pink's own task.
"""

import numpy as np
import pinocchio as pin
from pink import Configuration, solve_ik
from pink.limits import VelocityLimit
from pink.tasks import FrameTask, Task

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
        model = pin.buildModelFromUrdf(robot.urdf)
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


class FrameTaskPeer(Peer):
    """Pink's own task; its target is the tool's pose a millisecond ahead."""

    period = 1e-3

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot)
        self.frame_task = FrameTask(TOOL, position_cost=1.0, orientation_cost=1.0, lm_damping=0.0)
        self.tasks = [self.frame_task]

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        self.configuration.update(q[self.working])
        T = self.configuration.data.oMf[self.task.frame]
        to_tool, step = T.rotation.T, self.period * twist
        motion = pin.Motion(to_tool.dot(step[:3]), to_tool.dot(step[3:]))
        self.frame_task.transform_target_to_world = T * pin.exp6(motion)
        self.rates[self.working] = solve_ik(
            self.configuration, self.tasks, self.period, solver="quadprog", damping=DAMPING, limits=self.limits
        )
        return self.rates
