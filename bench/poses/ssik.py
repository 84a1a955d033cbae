"""ssik: its artifact where it ships one of the same geometry, else the solver that it makes from the file.

Which joint values count is left to the judge, who has the limits; ssik gets them from its artifact or the file.
"""

import numpy as np
import ssik

from bench.poses.base import BASE, TOOL, Robot

SHIPPED = {"panda": "panda_ik", "iiwa14": "iiwa14_ik"}


class Peer:
    packages = ("ssik",)
    most: int | None = 1

    def __init__(self, robot: Robot) -> None:
        own = ssik.Manipulator.from_urdf(robot.urdf, base=BASE, ee=TOOL)
        self.tool, self.solver = np.eye(4), own
        if robot.name in SHIPPED:
            zero, self.solver = np.zeros(len(robot.lower)), ssik.Manipulator.from_prebuilt(SHIPPED[robot.name])
            self.tool = np.linalg.inv(own.fk(zero)) @ self.solver.fk(zero)

    def solve(self, pose: np.ndarray, start: np.ndarray) -> np.ndarray | None:
        found = self.solver.solve(pose @ self.tool, max_solutions=self.most)
        return found[0].q if found else None


class All(Peer):
    most = None
