"""A survey in a process of its own, to be killed or measured."""

import sys
from pathlib import Path

import stillreach as sr

SETTINGS = {"k": 2, "chunk": 100, "seed": 7, "metrics": ("relative", "speed", "depth"), "keep": "all"}


def survey(folder, count, **settings):
    return sr.tolerance.survey(sr.arms.nasa_modular(), folder, samples=count, **{**SETTINGS, **settings})


def peak() -> float:
    """[MB] the most memory that this process has had."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return float(next(line for line in lines if line.startswith("VmHWM")).split()[1]) / 1024


if __name__ == "__main__":
    if sys.argv[3:]:
        sr.tolerance.survey(sr.arms.nasa_modular(), sys.argv[1], samples=int(sys.argv[2]), metrics="relative", k=1)
        print(peak())
    else:
        survey(sys.argv[1], int(sys.argv[2]))
