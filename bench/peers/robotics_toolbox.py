"""Robotics Toolbox: its compiled Jacobian, and quadprog for the bounded least squares, as its examples do it."""

import numpy as np
import quadprog
from roboticstoolbox import ERobot

from bench.peers.base import TOOL, Robot

DAMPING = 1e-9


class Peer:
    packages = ("roboticstoolbox-python", "quadprog")

    def __init__(self, robot: Robot) -> None:
        self.chain = ERobot.URDF(robot.urdf).ets(end=TOOL)
        n = len(robot.working)
        self.damping = DAMPING * np.eye(n)
        self.sides = np.hstack([np.eye(n), -np.eye(n)])
        self.limits = np.full(2 * n, -robot.limit)
        self.working, self.rates = robot.working, np.zeros(robot.n)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        return self.chain.jacob0(q[self.working])

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        J = self.chain.jacob0(q[self.working])
        P = J.T.dot(J) + self.damping
        self.rates[self.working] = quadprog.solve_qp(P, twist.dot(J), self.sides, self.limits)[0]
        return self.rates
