"""The common work: the paper's arm with joints 2, 4 and 7 failed, at many poses along short paths."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import stillreach as sr
from bench.peers.base import TOOL, Robot

FAILED = {"j2": 0.4, "j4": -0.7, "j7": 1.1}
"""The joints that failed, and where [rad] they stand."""
LIMIT = np.deg2rad(50.0)
POSES, STEPS = 16, 16
OVER = 1.5
"""How far the pseudoinverse's largest rate is over the limit, in the ticks where the limit bites."""
FAR = 1000.0
"""[rad] A position limit that is never met: several readers make a joint without one into a pair (cos, sin)."""


@dataclass(frozen=True)
class Workload:
    """q (ticks, n) [rad] along the paths, twist (ticks, 6) [m/s, rad/s]."""

    q: np.ndarray
    twist: np.ndarray

    def __len__(self) -> int:
        return len(self.q)


def arm() -> sr.Arm:
    """The paper's arm."""
    return sr.arms.nasa_modular()


def locked_joints() -> np.ndarray:
    """Indices of the failed joints."""
    return np.array([arm().joint_index(name) for name in FAILED])


def working_joints() -> np.ndarray:
    """Indices of the others."""
    return np.setdiff1d(np.arange(arm().n), locked_joints())


def paths(count: int, length: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """q (count · length, n) along paths of small steps and twists (count · length, 6) of any size, one a path."""
    random, n, locked = np.random.default_rng(seed), arm().n, locked_joints()
    start, along = random.uniform(-2.0, 2.0, (count, n)), random.uniform(-1.0, 1.0, (count, n))
    start[:, locked], along[:, locked] = list(FAILED.values()), 0.0
    q = start[:, None] + 1e-3 * np.arange(length)[:, None] * along[:, None]
    return q.reshape(-1, n), np.repeat(random.normal(size=(count, 6)), length, axis=0)


def workload(part: float, seed: int = 1) -> Workload:
    """Twists as long as the pseudoinverse needs for a largest rate of `part` times the limit."""
    q, twist = paths(POSES, STEPS, seed)
    rates = np.linalg.pinv(arm().jacobian(q)[:, :, working_joints()]) @ twist[:, :, None]
    return Workload(q, twist * (part * LIMIT / np.max(np.abs(rates), axis=1)))


def controller(law: sr.Law) -> sr.Controller:
    """A controller with the failed joints, past its transition."""
    ctl = sr.Controller(arm(), law=law, velocity_limits=LIMIT)
    for joint in FAILED:
        ctl.fail(joint)
    ctl.reset()
    return ctl


def robot(folder: Path, limit: float = float(LIMIT)) -> Robot:
    """The arm as peers take it; writes its URDF file into the folder."""
    limited = arm().with_limits(position=(-FAR, FAR), velocity=LIMIT)
    left = sr.Arm.from_urdf(limited.to_urdf(), tip=TOOL, fixed=FAILED)
    left.to_urdf(folder / "working.urdf")
    chain = (np.array([j.placement for j in left.joints]), np.array([j.axis for j in left.joints]), left.tool)
    return Robot(str(folder / "working.urdf"), arm().n, working_joints(), locked_joints(), limit, *chain)
