"""mink with daqp.

As with Pink: a model without the failed joints, a task of one's own that holds the twist itself, no
Levenberg-Marquardt damping. `FrameTaskPeer` is the same with mink's own task.
"""

import mink
import mujoco
import numpy as np

from bench.peers.base import TOOL, Robot

DAMPING = 1e-9
"""The default of 1e-12 is too small for daqp, which then misses feasible twists."""


class TwistTask(mink.Task):
    """Move a body with a twist in the world's axes; the displacement of one second."""

    def __init__(self, body: int, nv: int) -> None:
        super().__init__(cost=np.ones(6))
        self.body, self.nv, self.twist = body, nv, np.zeros(6)

    def compute_error(self, configuration: mink.Configuration) -> np.ndarray:
        return -self.twist

    def compute_jacobian(self, configuration: mink.Configuration) -> np.ndarray:
        J = np.empty((6, self.nv))
        mujoco.mj_jacBody(configuration.model, configuration.data, J[:3], J[3:], self.body)
        return J


class Peer:
    packages = ("mink", "daqp", "mujoco")

    def __init__(self, robot: Robot) -> None:
        model = mujoco.MjModel.from_xml_path(robot.urdf)
        self.configuration = mink.Configuration(model)
        self.task = TwistTask(model.body(TOOL).id, model.nv)
        limits = {model.joint(i).name: robot.limit for i in range(model.njnt)}
        self.tasks, self.limits = [self.task], [mink.VelocityLimit(model, limits)]
        self.working, self.rates = robot.working, np.zeros(robot.n)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        self.configuration.update(q[self.working])
        return self.task.compute_jacobian(self.configuration)

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        self.configuration.update(q[self.working])
        self.task.twist = twist
        self.rates[self.working] = mink.solve_ik(
            self.configuration, self.tasks, 1.0, solver="daqp", damping=DAMPING, limits=self.limits
        )
        return self.rates


class FrameTaskPeer(Peer):
    """mink's own task; its target is the tool's pose a millisecond ahead."""

    period = 1e-3

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot)
        self.frame_task = mink.FrameTask(TOOL, "body", position_cost=1.0, orientation_cost=1.0, lm_damping=0.0)
        self.tasks = [self.frame_task]

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        self.configuration.update(q[self.working])
        T = self.configuration.get_transform_frame_to_world(TOOL, "body")
        to_tool, step = T.rotation().as_matrix().T, self.period * twist
        motion = np.concatenate([to_tool.dot(step[:3]), to_tool.dot(step[3:])])
        self.frame_task.set_target(T @ mink.SE3.exp(motion))
        settings = {"solver": "daqp", "damping": DAMPING, "primal_tol": 1e-12}  # the steps are small
        self.rates[self.working] = mink.solve_ik(
            self.configuration, self.tasks, self.period, limits=self.limits, **settings
        )
        return self.rates
