"""TRAC-IK by pytracik, whose own package name is not that of its module. Its limits are set by hand: it reads those of
revolute joints of a file wrongly.
"""

from pathlib import Path

import numpy as np
import pytracik

from bench.poses.base import BASE, TOOL, Robot


class Peer:
    packages = ("pytracik",)
    seconds = 0.05

    def __init__(self, robot: Robot) -> None:
        text = Path(robot.urdf).read_text(encoding="utf-8")
        self.solver = pytracik.TRAC_IK(BASE, TOOL, text, self.seconds, 1e-7, pytracik.SolveType.Speed)
        far = 4.0 * np.pi
        pytracik.set_joint_limits(self.solver, np.clip(robot.lower, -far, far), np.clip(robot.upper, -far, far))

    def solve(self, pose: np.ndarray, start: np.ndarray) -> np.ndarray | None:
        found = pytracik.ik(self.solver, start, *pose[:3, 3], *quaternion(pose[:3, :3]))
        return found[1:] if found[0] >= 0 else None


class Short(Peer):
    seconds = 0.005


def quaternion(R: np.ndarray) -> tuple[float, float, float, float]:
    """x, y, z, w of a rotation, by the eigenvector of the largest eigenvalue of a matrix that is linear in it."""
    K = np.empty((4, 4))
    K[:3, :3] = R + R.T - np.trace(R) * np.eye(3)
    K[:3, 3] = K[3, :3] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    K[3, 3] = np.trace(R)
    x, y, z, w = np.linalg.eigh(K)[1][:, -1]
    return x, y, z, w
