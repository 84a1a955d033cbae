"""mink with daqp: Newton steps of its frame task inside its configuration limits, at most as large as ours."""

import mink
import mujoco
import numpy as np

from bench.poses.base import STEP, TOOL, Loop, Robot


class Peer:
    packages = ("mink", "daqp", "mujoco")

    def __init__(self, robot: Robot) -> None:
        model = mujoco.MjModel.from_xml_path(robot.urdf)
        model.jnt_range, model.jnt_limited = np.column_stack([robot.lower, robot.upper]), 1
        self.loop, self.configuration = Loop(robot), mink.Configuration(model)
        self.task = mink.FrameTask(TOOL, "body", position_cost=1.0, orientation_cost=1.0, lm_damping=0.0)
        steps = {model.joint(i).name: STEP for i in range(model.njnt)}
        self.limits = [mink.ConfigurationLimit(model, gain=1.0), mink.VelocityLimit(model, steps)]

    def solve(self, pose: np.ndarray, start: np.ndarray) -> np.ndarray | None:
        self.task.set_target(mink.SE3.from_matrix(pose))
        return self.loop.search(start, self.step)

    def step(self, q: np.ndarray, new: bool) -> tuple[float, np.ndarray]:
        self.configuration.update(q)
        size = float(np.abs(self.task.compute_error(self.configuration)).max())
        try:
            rates = mink.solve_ik(self.configuration, [self.task], 1.0, solver="daqp", damping=1e-9, limits=self.limits)
        except Exception:  # its solver found no answer: another start
            return size, q
        return size, q + rates
