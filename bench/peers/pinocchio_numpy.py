"""Pinocchio's Jacobian and damped least squares in NumPy, scaled down to the limit: what many write themselves.

The failed joints are left out of the model (`buildReducedModel` does the same). It keeps the twist's direction, and
so misses twists that only another choice of rates can do.
"""

import numpy as np
import pinocchio as pin

from bench.peers.base import TOOL, Robot

DAMPING = 1e-12
AXES = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class Peer:
    packages = ("pin", "numpy")

    def __init__(self, robot: Robot) -> None:
        self.model = pin.buildModelFromUrdf(robot.urdf)
        self.data = self.model.createData()
        self.tool = self.model.getFrameId(TOOL)
        self.working, self.limit = robot.working, robot.limit
        self.damping = DAMPING * np.eye(6)
        self.rates = np.zeros(robot.n)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        return pin.computeFrameJacobian(self.model, self.data, q[self.working], self.tool, AXES)

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        J = pin.computeFrameJacobian(self.model, self.data, q[self.working], self.tool, AXES)
        rates = J.T.dot(np.linalg.solve(J.dot(J.T) + self.damping, twist))  # `dot` is faster than `@` here
        largest = max(rates.max(), -rates.min())
        if largest > self.limit:
            rates *= self.limit / largest
        self.rates[self.working] = rates
        return self.rates
