"""EAIK solves arms of six joints: the last joint is held at one value after the other, each a solver of its own."""

import numpy as np
from eaik.IK_URDF import UrdfRobot

from bench.poses.base import TOLERANCE, TOOL, Robot

VALUES = 65


class Peer:
    packages = ("EAIK",)

    def __init__(self, robot: Robot) -> None:
        self.lower, self.upper = np.maximum(robot.lower, -2 * np.pi), np.minimum(robot.upper, 2 * np.pi)
        if len(self.lower) == 6:
            self.solvers = [UrdfRobot(robot.urdf)]
        else:
            values = np.linspace(self.lower[6], self.upper[6], VALUES + 2)[1:-1]
            order = np.argsort(np.abs(np.arange(VALUES) - VALUES // 2) % 8 != 0, kind="stable")  # coarse first
            self.solvers = [UrdfRobot(robot.urdf, fixed_axes=[(6, float(at))]) for at in values[order]]
        if not self.solvers[0].hasKnownDecomposition():
            raise ValueError(f"no decomposition of {robot.name}: {self.solvers[0].getKinematicFamily()}")
        self.to_tool = _tool(robot)

    def solve(self, pose: np.ndarray, start: np.ndarray) -> np.ndarray | None:
        goal, doubtful = pose @ self.to_tool, []
        for solver in self.solvers:
            answer = solver.IK(goal)
            for q, least_squares in zip(answer.Q, answer.is_LS, strict=True):
                inside = self.inside(np.asarray(q))
                if inside is not None and not least_squares:
                    return inside
                if inside is not None:
                    doubtful.append((solver, inside))
        for solver, q in doubtful:  # exact answers of some families are marked as least squares, too
            if np.abs(solver.fwdKin(q) - goal).max() < TOLERANCE:
                return q
        return None

    def inside(self, q: np.ndarray) -> np.ndarray | None:
        """The same up to whole turns, within the limits; None if there is none."""
        turned = q + 2 * np.pi * np.ceil((self.lower - q) / (2 * np.pi))
        return turned if (turned <= self.upper).all() else None


def _tool(robot: Robot) -> np.ndarray:
    """EAIK's tool, seen from ours: its frame at zero has the base's axes and the last joint's place."""
    import pinocchio as pin

    model = pin.buildModelFromUrdf(robot.urdf)
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.zeros(model.nq))
    last = np.eye(4)
    last[:3, 3] = data.oMi[model.njoints - 1].translation
    return np.linalg.inv(data.oMf[model.getFrameId(TOOL)].homogeneous) @ last
