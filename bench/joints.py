"""Which joint can real arms not lose: the table in the README. ``python -m bench.joints --write``.

At 1,000 random configurations within the position limits: the relative manipulability of each joint for the full pose
of the tool (``sr.tolerance.report``). Arms by name, and files of the packages in requirements/robots.txt.
"""

import argparse
from pathlib import Path

import numpy as np

import stillreach as sr
from bench.page import put
from stillreach.arm.limits import sampling_range
from tests.robots.catalogue import ROBOTS

FILES = (
    "Panda",
    "iiwa 14",
    "Kinova Gen3",
    "xArm7",
    "TALOS, torso and arm",
    "Valkyrie, waist to palm",
    "Valkyrie, waist to thumb",
    "human, pelvis to hand",
)
CONFIGURATIONS, SEED = 1000, 1994
README = Path(__file__).parents[1] / "README.md"


def medians(arm: sr.Arm) -> tuple[np.ndarray, np.ndarray, int]:
    """(n,) median relative manipulability of each joint, how often its loss costs a direction, 0 to 1, and how many
    configurations are left out because the whole arm is singular there.
    """
    rng = np.random.default_rng(SEED)
    low, high = sampling_range(arm.kinds, *arm.position_limits.T)
    reports = [sr.tolerance.report(arm, q, k=1) for q in rng.uniform(low, high, (CONFIGURATIONS, arm.n))]
    found = [report for report in reports if report.rank == 6]
    left = [np.where(report.loses[0], 0.0, report.relative[0]) for report in found]
    lost = np.mean([report.loses[0] for report in found], axis=0)
    return np.median(left, axis=0), lost, len(reports) - len(found)


def row(name: str, arm: sr.Arm) -> str:
    left, lost, singular = medians(arm)
    cells = " ".join(f"{100 * value:.0f}" if value >= 0.01 or value == 0.0 else "<1" for value in left)
    worst = int(np.argmin(left))
    never = [joint for joint, share in zip(arm.joint_names, lost, strict=True) if share > 0.99]
    text = f"never {', '.join(never)}" if never else f"{arm.joint_names[worst]}, {100 * left[worst]:.2g} %"
    return f"| {name} | {arm.n} | {cells} | {text} | {singular} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--write", action="store_true", help="into README.md")
    arguments = parser.parse_args()
    arms = {name: ROBOTS[name].make() for name in FILES}
    arms |= {"Canadarm2": sr.arms.canadarm2(), "the paper's arm": sr.arms.nasa_modular()}
    lines = [
        "| arm | joints | remains without each joint, from the base on [%] | costs most | left out |",
        "|---|---|---|---|---|",
    ]
    for name, arm in sorted(arms.items(), key=lambda pair: pair[1].n):
        lines.append(row(name, arm))
        print(lines[-1], flush=True)
    if arguments.write:
        put(README, "joints", "\n".join(lines))


if __name__ == "__main__":
    main()
