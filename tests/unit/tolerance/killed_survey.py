"""A survey in a process of its own, to be killed or measured."""

import sys
from pathlib import Path

import numpy as np

import stillreach as sr

SETTINGS = {"k": 2, "chunk": 100, "seed": 7, "metrics": ("relative", "speed", "depth"), "keep": "all"}


def survey(folder, count, **settings):
    return sr.tolerance.survey(sr.arms.nasa_modular(), folder, samples=count, **{**SETTINGS, **settings})


def of_poses(folder, count):
    """Of a planar arm: each tenth pose is out of reach."""
    random = np.random.default_rng(9)
    arm = sr.arms.planar(4)
    poses = arm.forward(random.uniform(-2.0, 2.0, (count, 4)))
    poses[::10, 0, 3] += 9.0
    task = sr.Task(rows=(True, True, False, False, False, False))
    settings = {"k": 1, "chunk": 50, "metrics": ("relative", "reach", "positions"), "starts": 5, "threads": 1}
    return sr.tolerance.survey(arm, folder, poses=poses, task=task, **settings)


def peak() -> float:
    """[MB] the most memory that this process has had."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return float(next(line for line in lines if line.startswith("VmHWM")).split()[1]) / 1024


if __name__ == "__main__":
    if sys.argv[3:] == ["poses"]:
        of_poses(sys.argv[1], int(sys.argv[2]))
    elif sys.argv[3:]:
        sr.tolerance.survey(sr.arms.nasa_modular(), sys.argv[1], samples=int(sys.argv[2]), metrics="relative", k=1)
        print(peak())
    else:
        survey(sys.argv[1], int(sys.argv[2]))
