"""NumPy on many configurations at once: kinematics joint by joint over all rows, batched 6 x 6 solves.

In blocks that stay in the processor's cache.
"""

import numpy as np

from bench.peers.base import Robot

BLOCK = 256
DAMPING = 1e-12


class Peer:
    packages = ("numpy",)

    def __init__(self, robot: Robot) -> None:
        self.robot, self.damping = robot, DAMPING * np.eye(6)

    def batch_jacobian(self, q: np.ndarray) -> np.ndarray:
        """(N, 6, k) for q (N, k) of the joints that work."""
        R, p = np.broadcast_to(np.eye(3), (len(q), 3, 3)), np.zeros((len(q), 3))
        origins, axes = np.empty((len(q), q.shape[1], 3)), np.empty((len(q), q.shape[1], 3))
        for joint, (T, axis) in enumerate(zip(self.robot.placements, self.robot.axes, strict=True)):
            p = p + R @ T[:3, 3]
            R = R @ T[:3, :3]
            origins[:, joint], axes[:, joint] = p, R @ axis
            R = R @ turns(axis, q[:, joint])
        tool = p + R @ self.robot.tool[:3, 3]
        return np.concatenate([np.cross(axes, tool[:, None] - origins), axes], axis=2).transpose(0, 2, 1)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        return self.batch_jacobian(q[None, self.robot.working])[0]

    def solve(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        rates = np.zeros_like(q)
        for start in range(0, len(q), BLOCK):
            part = slice(start, start + BLOCK)
            J = self.batch_jacobian(q[part][:, self.robot.working])
            Jt = J.transpose(0, 2, 1)
            found = (Jt @ np.linalg.solve(J @ Jt + self.damping, twist[part, :, None]))[:, :, 0]
            largest = np.abs(found).max(axis=1, keepdims=True)
            rates[part, self.robot.working] = found * np.minimum(1.0, self.robot.limit / largest)
        return rates


def turns(axis: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """(N, 3, 3) rotations about one axis (Rodrigues)."""
    K = np.cross(np.eye(3), axis)
    s, c = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3) + s * K + (1.0 - c) * (K @ K)
