"""stillreach: every pose alone, and all in one call, on one thread."""

import numpy as np

import stillreach as sr
from bench.poses.base import TOOL, Robot

STARTS = 300


class Peer:
    packages = ("stillreach",)

    def __init__(self, robot: Robot) -> None:
        self.arm = sr.Arm.from_urdf(robot.urdf, tip=TOOL)

    def solve(self, pose: np.ndarray, start: np.ndarray) -> np.ndarray | None:
        result = self.arm.inverse(pose, start, starts=STARTS, threads=1)
        return result.q if result.reached else None


class Batch(Peer):
    def solve_all(self, poses: np.ndarray, starts: np.ndarray) -> np.ndarray:
        result = self.arm.inverse(poses, starts, starts=STARTS, threads=1)
        return np.where(result.reached[:, None], result.q, np.nan)
