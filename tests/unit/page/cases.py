"""Run as a program: simulates tasks on the instruction set at hand, and writes them as a page has them, and the runs.

Arguments: the folder, and how many ticks each task takes.
"""

import sys
from pathlib import Path

import numpy as np

import stillreach as sr
from stillreach.laws import LeastError, Pseudoinverse, SingularityRobust
from stillreach.null_motions import Centring, Manipulability, Tolerance
from stillreach.page.pack import pack
from stillreach.page.task import task_of
from stillreach.plants import KinematicPlant

LAWS = {
    "least error": LeastError(),
    "bare": LeastError(price=None),
    "position first": LeastError(price="position-first"),
    "keep direction": sr.KeepDirection(),
    "exact damping": SingularityRobust(),
    "closed form": SingularityRobust(damping="closed-form"),
    "pseudoinverse": Pseudoinverse(),
}
ARRAYS = ("q", "measured", "rates", "pose", "command", "residual", "task_error", "damping", "scale", "lower", "upper")
ARRAYS += ("status", "health", "known", "active")
LOCKED = sr.Fault(3, at=0.4)
OTHERS = [
    sr.Fault(1, at=0.7, kind=sr.Derated(0.3), until=1.5),
    sr.Fault(5, at=0.9, kind=sr.OneWay(1.0), known_after=0.03),
    sr.Fault(4, at=1.1, kind=sr.Confined(-0.3, 0.4)),
    sr.Fault(6, at=1.3, kind=sr.Runaway(0.1), until=1.9),
]
PANDA = sr.arms.panda()
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
SNAKE = sr.arms.snake(11)
WAYS = {
    "tracking": {"loop": "closed", "null_motion": Centring(gain=1.0), "faults": [LOCKED]},
    "many faults": {"loop": "closed", "faults": OTHERS, "acceleration_limits": 6.0},
    "late drives": {
        "loop": "closed",
        "faults": [LOCKED],
        "plant": KinematicPlant(lag=0.02, dead_time=0.01, resolution=1e-4, noise=1e-4),
    },
    "away from singularities": {"null_motion": Manipulability(gain=0.3), "faults": [LOCKED], "velocity_limits": 0.4},
    "Runge-Kutta": {"integrator": "rk4", "null_motion": Tolerance(gain=0.1), "faults": [sr.Fault(6, at=0.5)]},
    "eleven joints": {"arm": SNAKE, "start": 0.3 * np.cos(np.arange(11)), "loop": "closed", "faults": [LOCKED]},
}


def scenario(law, way, ticks):
    """A task of so many ticks at 1 ms: constant twists and a circle, over and over."""
    settings = {"arm": PANDA, "start": START, **WAYS[way]}
    parts = []
    for k in range(1 + ticks // 2000):
        sign = 1.0 if k % 2 == 0 else -1.0
        parts.append(sr.ConstantTwist(sign * np.array([0.03, 0.1, -0.05, 0.1, 0.05, 0.0]), duration=1.0))
        parts.append(sr.Circle(centre=[0.05, 0.0, 0.0], axis=[0.0, 0.0, 1.0], relative=True, duration=1.0))
    return sr.Scenario(
        motion=parts, law=LAWS[law], period=0.001, duration=0.001 * ticks, allow_outside=True, **settings
    )


def main(folder, ticks):
    names = []
    for law in LAWS:
        for way in WAYS:
            task = scenario(law, way, ticks)
            run, name = sr.simulate(task, progress=False), f"{law}, {way}".replace(" ", "-")
            document, block = pack({"task": task_of(task, planned=True)[0]})
            (folder / f"{name}.json").write_text(document, encoding="utf-8")
            (folder / f"{name}.b64").write_text(block, encoding="utf-8")
            np.savez(folder / f"{name}.npz", **{array: getattr(run, array) for array in ARRAYS})
            names.append(name)
    (folder / "names.txt").write_text("\n".join(names), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
