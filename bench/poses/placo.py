"""placo: steps of its frame task inside its joint limits, as large as those of `arm.inverse`."""

import numpy as np
import pinocchio as pin
import placo

from bench.poses.base import STEP, TOOL, Loop, Robot

FLOAT = 7
"""placo's models float: a place and a quaternion before the joints."""


class Peer:
    packages = ("placo", "pin")

    def __init__(self, robot: Robot) -> None:
        self.loop, self.robot = Loop(robot), placo.RobotWrapper(robot.urdf, placo.Flags.ignore_collisions)
        for name, low, high in zip(self.robot.joint_names(), robot.lower, robot.upper, strict=True):
            self.robot.set_joint_limits(name, float(low), float(high))
        self.robot.set_velocity_limits(STEP)
        self.solver = placo.KinematicsSolver(self.robot)
        self.solver.mask_fbase(True)
        self.solver.enable_joint_limits(True)
        self.solver.enable_velocity_limits(True)
        self.solver.dt = 1.0
        self.solver.problem.regularization = 1e-10
        self.task = self.solver.add_frame_task(TOOL, np.eye(4))
        self.task.configure(TOOL, "soft", 1.0, 1.0)
        self.q, self.pose = np.array(self.robot.state.q), np.eye(4)

    def solve(self, pose: np.ndarray, start: np.ndarray) -> np.ndarray | None:
        self.pose = self.task.T_world_frame = pose
        return self.loop.search(start, self.step)

    def step(self, q: np.ndarray, new: bool) -> tuple[float, np.ndarray]:
        self.q[FLOAT:] = q
        self.robot.state.q = self.q
        self.robot.update_kinematics()
        T = self.robot.get_T_world_frame(TOOL)
        turn = pin.log3(T[:3, :3].T @ self.pose[:3, :3])
        size = float(max(np.abs(T[:3, 3] - self.pose[:3, 3]).max(), np.abs(turn).max()))
        try:
            self.solver.solve(True)
        except RuntimeError:  # its solver found no answer: another start
            return size, q
        return size, np.array(self.robot.state.q)[FLOAT:]
