"""The common work: the paper's arm with joints 2, 4 and 7 failed, at many poses along short paths."""

from dataclasses import dataclass

import numpy as np

import stillreach as sr

FAILED = ("j2", "j4", "j7")
LIMIT = np.deg2rad(50.0)
POSES, STEPS = 16, 16
OVER = 1.5
"""How far the pseudoinverse's largest rate is over the limit, in the ticks where the limit bites."""


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


def workload(part: float, seed: int = 1) -> Workload:
    """Random poses, from each of them a path of small steps, commanded in one direction.

    Twists are as long as the pseudoinverse needs for a largest rate of `part` times the limit.
    """
    random, robot = np.random.default_rng(seed), arm()
    working = [i for i, name in enumerate(robot.joint_names) if name not in FAILED]
    paths, twists = [], []
    for _ in range(POSES):
        start, along = random.uniform(-2.0, 2.0, robot.n), random.uniform(-1.0, 1.0, robot.n) * 1e-3
        direction = random.normal(size=6)
        for step in range(STEPS):
            q = start + step * along
            rates = np.linalg.pinv(robot.jacobian(q)[:, working]) @ direction
            paths.append(q)
            twists.append(direction * (part * LIMIT / np.max(np.abs(rates))))
    return Workload(np.array(paths), np.array(twists))


def controller(law: sr.Law) -> sr.Controller:
    """A controller with the failed joints, past its transition."""
    ctl = sr.Controller(arm(), law=law, velocity_limits=LIMIT)
    for joint in FAILED:
        ctl.fail(joint)
    ctl.reset()
    return ctl
