"""placo: its kinematics solver with a position and an orientation task.

Its targets are poses: the tool's pose a millisecond ahead. The solver's own regularisation of 1e-8 is lowered, because
with it a few twists near singular poses are missed.
"""

import numpy as np
import pinocchio as pin
import placo

from bench.peers.base import TOOL, Robot

PERIOD = 1e-3
REGULARIZATION = 1e-10
BASE = 6
"""placo's models float; the base's six velocities are masked."""


class Peer:
    packages = ("placo", "pin")

    def __init__(self, robot: Robot) -> None:
        self.robot = placo.RobotWrapper(robot.urdf, placo.Flags.ignore_collisions)
        self.robot.set_velocity_limits(robot.limit)
        self.solver = placo.KinematicsSolver(self.robot)
        self.solver.mask_fbase(True)
        self.solver.enable_joint_limits(False)
        self.solver.enable_velocity_limits(True)
        self.solver.dt = PERIOD
        self.solver.problem.regularization = REGULARIZATION
        self.task = self.solver.add_frame_task(TOOL, np.eye(4))
        self.task.configure(TOOL, "soft", 1.0, 1.0)
        self.q = np.array(self.robot.state.q)
        self.target = np.eye(4)
        self.working, self.rates = robot.working, np.zeros(robot.n)

    def move_to(self, q: np.ndarray) -> None:
        self.q[BASE + 1 :] = q[self.working]
        self.robot.state.q = self.q
        self.robot.update_kinematics()

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        self.move_to(q)
        return self.robot.frame_jacobian(TOOL, "local_world_aligned")[:, BASE:]

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        self.move_to(q)
        T, step = self.robot.get_T_world_frame(TOOL), PERIOD * twist
        self.target[:3, 3] = T[:3, 3] + step[:3]
        self.target[:3, :3] = pin.exp3(step[3:]).dot(T[:3, :3])
        self.task.T_world_frame = self.target
        self.rates[self.working] = self.solver.solve(False)[BASE:] / PERIOD
        return self.rates
