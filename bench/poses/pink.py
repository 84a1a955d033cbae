"""Pink with daqp: Newton steps of its frame task inside its configuration limits, at most as large as ours."""

import numpy as np
import pinocchio as pin
from pink import Configuration, solve_ik
from pink.limits import ConfigurationLimit, VelocityLimit
from pink.tasks import FrameTask

from bench.poses.base import STEP, TOOL, Loop, Robot


class Peer:
    packages = ("pin-pink", "daqp", "pin")

    def __init__(self, robot: Robot) -> None:
        model = pin.buildModelFromUrdf(robot.urdf)
        model.lowerPositionLimit, model.upperPositionLimit = robot.lower, robot.upper
        model.velocityLimit = np.full(model.nv, STEP)
        self.loop, self.model, self.data = Loop(robot), model, model.createData()
        self.task = FrameTask(TOOL, position_cost=1.0, orientation_cost=1.0, lm_damping=0.0)
        self.limits = [ConfigurationLimit(model, config_limit_gain=1.0), VelocityLimit(model)]

    def solve(self, pose: np.ndarray, start: np.ndarray) -> np.ndarray | None:
        self.task.set_target(pin.SE3(pose))
        return self.loop.search(start, self.step)

    def step(self, q: np.ndarray, new: bool) -> tuple[float, np.ndarray]:
        at = Configuration(self.model, self.data, q, copy_data=False)
        size = float(np.abs(self.task.compute_error(at)).max())
        try:
            rates = solve_ik(at, [self.task], 1.0, solver="daqp", damping=1e-9, limits=self.limits, safety_break=False)
        except Exception:  # its solver found no answer: another start
            return size, q
        return size, q + rates
