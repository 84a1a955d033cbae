"""The share of failures that a Panda survives under several laws: ``python -m bench.survival --write``.

Three tasks, three kinds of failures, each joint at each of 100 moments, known after 40 ms, 5 mm and 1 deg allowed. A
case whose rates leave their limits is not survived: drives cannot do it.
"""

import argparse
from pathlib import Path

import numpy as np

import stillreach as sr
from bench.page import put

PAGE = Path(__file__).parents[1] / "docs" / "rehearsal.md"
ARM = sr.arms.panda()
BENT = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
PICKING = np.deg2rad([-20, -20, -10, -110, 0, 95, 45])
STOPS = [[0, 0, -0.18], [0, 0, 0.02], [0.05, 0.42, 0], [0.05, 0.42, -0.18], [0.05, 0.42, 0], [0, 0, 0]]
KINDS = {"locked": "locked", "reduced range": "confined", "reduced speed": "derated"}
LAWS = {
    "minimum norm": sr.Pseudoinverse(),
    "fixed damping": sr.SingularityRobust(damping=5e-6),
    "box QP": sr.LeastError(price=None),
    "keep direction": sr.KeepDirection(),
    "default": sr.LeastError(),
    "position first": sr.LeastError(price="position-first"),
}


def tasks() -> dict[str, sr.Scenario]:
    """A circle, a line with a turn, and a pick-and-place."""
    turn = [[np.cos(0.6), -np.sin(0.6), 0], [np.sin(0.6), np.cos(0.6), 0], [0, 0, 1]]
    circle = sr.Circle(centre=[0, 0.12, 0], axis=[1, 0, 0], duration=10.0, relative=True, profile="minimum-jerk")
    line = sr.Line([0.12, -0.25, 0.15], orientation=turn, duration=6.0, relative=True, profile="minimum-jerk")
    stops = sr.Waypoints(STOPS, times=1.5 * np.arange(1, 7), profile="minimum-jerk", relative=True)
    motions = {"circle": (BENT, circle), "line with a turn": (BENT, line), "pick and place": (PICKING, stops)}
    return {
        name: sr.Scenario(arm=ARM, start=start, motion=motion, loop="closed", name=name)
        for name, (start, motion) in motions.items()
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--write", action="store_true", help="into docs/rehearsal.md")
    arguments = parser.parse_args()
    lines = [f"| task | failure | {' | '.join(LAWS)} |", f"|---|---|{'---|' * len(LAWS)}"]
    for name, task in tasks().items():
        for words, kind in KINDS.items():
            shares = []
            for law in LAWS.values():
                found = sr.tolerance.rehearse(
                    task, kinds=[kind], known_after=0.04, allowed_distance=0.005, allowed_angle=np.deg2rad(1), law=law
                )
                shares.append(f"{100 * found.share:.0f} %")
            lines.append(f"| {name} | {words} | {' | '.join(shares)} |")
            print(lines[-1], flush=True)
    if arguments.write:
        put(PAGE, "survival", "\n".join(lines))


if __name__ == "__main__":
    main()
