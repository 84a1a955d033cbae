"""pytorch-kinematics: its batched Jacobian, PyTorch's batched solve, float64, on the CPU.

Its URDF reader keeps angles with the seven digits of float32, whatever type is asked for.
"""

from pathlib import Path

import numpy as np
import pytorch_kinematics as pk
import torch

from bench.peers.base import TOOL, Robot

DAMPING = 1e-12


class Peer:
    packages = ("pytorch-kinematics", "torch")
    same_arm = 1e-6

    def __init__(self, robot: Robot) -> None:
        torch.set_num_threads(1)
        torch.set_default_dtype(torch.float64)
        text = Path(robot.urdf).read_bytes()
        self.chain = pk.build_serial_chain_from_urdf(text, TOOL).to(dtype=torch.float64)
        self.working, self.limit = robot.working, robot.limit
        self.damping = DAMPING * torch.eye(6)

    @torch.inference_mode()
    def jacobian(self, q: np.ndarray) -> np.ndarray:
        return self.chain.jacobian(torch.from_numpy(q[None, self.working]))[0].numpy()

    @torch.inference_mode()
    def solve(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        J = self.chain.jacobian(torch.from_numpy(q[:, self.working]))
        Jt = J.transpose(1, 2)
        found = (Jt @ torch.linalg.solve(J @ Jt + self.damping, torch.from_numpy(twist)[:, :, None]))[:, :, 0]
        found *= torch.clamp(self.limit / found.abs().amax(dim=1, keepdim=True), max=1.0)
        rates = np.zeros_like(q)
        rates[:, self.working] = found.numpy()
        return rates
