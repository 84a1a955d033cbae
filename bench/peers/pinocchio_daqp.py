"""Pinocchio's Jacobian and daqp called directly: as little as can lie between the two.

One daqp model for all ticks, its matrices updated in place, so that it starts from the last tick's active bounds.
"""

import daqp
import numpy as np
import pinocchio as pin

from bench.peers.base import TOOL, Robot

DAMPING = 1e-10
"""With 1e-12 daqp misses feasible twists, with 1e-8 the damping does."""
AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class Peer:
    packages = ("pin", "daqp")

    def __init__(self, robot: Robot) -> None:
        self.model = pin.buildModelFromUrdf(robot.urdf)
        self.data = self.model.createData()
        self.tool = self.model.getFrameId(TOOL)
        n = self.model.nv
        self.damping, limit = DAMPING * np.eye(n), np.full(n, robot.limit)
        self.solver = daqp.Model()
        self.solver.setup(np.eye(n), np.zeros(n), np.zeros((0, n)), limit, -limit)
        self.working, self.rates = robot.working, np.zeros(robot.n)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        return pin.computeFrameJacobian(self.model, self.data, q[self.working], self.tool, AXES)

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        J = pin.computeFrameJacobian(self.model, self.data, q[self.working], self.tool, AXES)
        self.solver.update(H=J.T.dot(J) + self.damping, f=-twist.dot(J))
        self.rates[self.working] = self.solver.solve()[0]
        return self.rates
