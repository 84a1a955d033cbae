"""How many poses inverse kinematics reaches, and how long it takes.

``python -m bench.reach [ARM ...]`` measures ten arms with all joints and with each one locked, ``--peers`` other
libraries on the same poses as ours, ``--unreachable`` poses that no configuration reaches, and ``--solutions`` how many
of a pose's configurations are found. ``--write`` puts the tables into docs/inverse.md.
"""

import argparse
import datetime
import math
import platform
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import stillreach as sr
from bench.page import put
from bench.report import markdown, processor
from bench.timing import machine_note, pin_to_one_core
from stillreach.arm.limits import sampling_range

PAGE = Path(__file__).parents[1] / "docs" / "inverse.md"
STARTS = (10, 30, 100, 300)
BY_NAME = ("panda", "iiwa14", "gen3", "xarm7", "canadarm2")
BY_FILE = {
    "talos 9": "TALOS, torso and arm",
    "valkyrie 10": "Valkyrie, waist to palm",
    "human 13": "human, pelvis to hand",
}
MADE = ("nasa_modular", "snake30")
ARMS = (*BY_NAME, *BY_FILE, *MADE)
"""In the order of the table."""
ELBOWS = {("xarm7", 3), ("gen3", 3)}
"""Of arms whose shoulder and wrist are spherical up to the rounding of their files: nearly singular everywhere."""
NEARLY_SPHERICAL = "†"
LEGEND = f"{NEARLY_SPHERICAL}: the elbow of a nearly spherical arm; without it the arm is nearly singular everywhere."


def arm_of(name: str) -> sr.Arm:
    """An arm by name, or of a robot file of the packages in requirements/robots.txt."""
    if name not in BY_FILE:
        return sr.arms.by_name(name)
    from tests.robots.catalogue import ROBOTS

    return ROBOTS[BY_FILE[name]].make()


class Measured:
    """One arm, one set of locked joints: shares solved by number of starts, and times on one core."""

    def __init__(self, arm: sr.Arm, locked: tuple[int, ...], count: int) -> None:
        random = np.random.default_rng(5)
        span = sampling_range(arm.kinds, *arm.position_limits.T)
        goal, start = random.uniform(*span, (2, count, arm.n))
        start[:, locked] = goal[:, locked]
        poses = arm.forward(goal)
        arm.inverse(poses[:8], start[:8], locked=locked)
        began = time.process_time()
        result = arm.inverse(poses, start, locked=locked, starts=STARTS[-1], threads=1)
        self.mean = (time.process_time() - began) / count * 1e6
        off = np.abs(arm.forward(result.q) - poses)[result.reached].max(initial=0.0)
        assert off < 1e-8, f"claimed to be reached, and {off} off"
        self.shares = [float(np.mean(result.reached & (result.starts <= most))) for most in STARTS]
        self.steps = float(result.steps.mean())
        self.worst = one_alone(arm, poses, start, locked, int(result.steps.argmax()))
        mark = NEARLY_SPHERICAL if (arm.name, *locked) in ELBOWS else ""
        self.name = (" ".join(arm.joint_names[i] for i in locked) or "-") + mark

    def __str__(self) -> str:
        shares = "  ".join(f"{share:9.3%}" for share in self.shares)
        return f"{self.name:>26}  {shares}  {self.steps:6.1f}  {self.mean:8.1f}  {self.worst:9.0f}"


def one_alone(
    arm: sr.Arm,
    poses: np.ndarray,
    start: np.ndarray | None,
    locked: tuple[int, ...],
    row: int,
    *,
    starts: int = STARTS[-1],
) -> float:
    """[µs] the pose that took most steps, in a call of its own; the least of three."""

    def once() -> float:
        began = time.process_time()
        arm.inverse(poses[row], None if start is None else start[row], locked=locked, starts=starts, threads=1)
        return (time.process_time() - began) * 1e6

    return min(once() for _ in range(3))


def of_arms(names: tuple[str, ...], count: int) -> str:
    """A table of all arms; the parts of each are printed on the way."""
    rows = []
    for name in names:
        arm = arm_of(name)
        print(f"\n{name}\n{'locked':>26}  {'  '.join(f'{most:>9}' for most in STARTS)}   steps   mean µs   worst µs")
        found = []
        for locked in ((), *((i,) for i in range(arm.n))):
            found.append(Measured(arm, locked, count))
            print(found[-1], flush=True)
        rows.append(summary(name, found))
    return f"{markdown(COLUMNS, rows)}\n\n{LEGEND}"


COLUMNS = (
    "arm",
    "all joints: reached with 10 / 30 / 100 / 300 starts",
    "µs a pose",
    "worst, ms",
    "one joint locked, the hardest: 10 / 30 / 100 / 300 starts",
    "µs a pose: mean, hardest",
    "worst, ms",
)


def summary(name: str, found: list[Measured]) -> list[str]:
    """The row of an arm."""
    whole, *locked = found
    hard = min(locked, key=lambda one: one.shares[::-1])
    mean, slow = np.mean([one.mean for one in locked]), max(one.mean for one in locked)
    return [
        name,
        percent(whole.shares),
        f"{whole.mean:.0f}",
        f"{whole.worst / 1e3:.2f}",
        f"{hard.name}: {percent(hard.shares)}",
        f"{mean:.0f}, {slow:.0f}",
        f"{max(one.worst for one in locked) / 1e3:.1f}",
    ]


def percent(shares: list[float]) -> str:
    """Rounded down: only all of them are 100."""
    return (
        " / ".join(f"{math.floor(1e5 * share + 1e-6) / 1e3:.3f}" if share < 1.0 else "100" for share in shares) + " %"
    )


def of_peers(count: int, keys: list[str] | None) -> str:
    """The tables of bench/poses."""
    from bench.poses import POSES
    from bench.poses.base import BUDGET, TOLERANCE
    from bench.poses.race import CASES, race

    entries = tuple(entry for entry in POSES if keys is None or entry.ours or entry.key in keys)
    versions: dict[str, str] = {}
    parts, out = [], []
    for case in CASES:
        table, left_out = race(case, entries, count, versions)
        parts += [table, ""]
        out += left_out
    listed = ", ".join(f"{name} {version}" for name, version in sorted(versions.items()) if name != "stillreach")
    rule = (
        f"Solved: to {TOLERANCE:g} m and rad by stillreach's forward kinematics, inside the limits. Processor time; "
        f"loops have {BUDGET * 1e3:g} ms a pose."
    )
    return "\n".join([*parts, rule, *out, f"{listed}."])


def of_unreachable(count: int) -> str:
    """A table of poses that no configuration of an iiwa 14 reaches: how many are claimed, and the times of the rest."""
    from tests.oracles import spherical_arm as exact

    arm, random = sr.arms.iiwa14(), np.random.default_rng(1994)
    narrow = arm.with_limits(position=0.5 * arm.position_limits)
    most, least = exact.UPPER + exact.LOWER, exact.distance_at(arm.position_limits[3, 1])
    half = count // 2
    kinds = {
        "the wrist farther from the shoulder than the links are long": (
            arm,
            np.concatenate(
                [
                    exact.random_poses(random, half, most + 1e-4, most + exact.TOOL),
                    exact.random_poses(random, count - half, most + exact.TOOL, 2.0),
                ]
            ),
        ),
        "closer than the elbow's limit leaves it": (arm, exact.random_poses(random, half, 0.0, least - 1e-4)),
        "excluded by half of the limits, by the closed form at 720 places of the elbow": (
            narrow,
            exact.excluded_poses(count - half, *narrow.position_limits.T),
        ),
    }
    rows = []
    for title, (own, poses) in kinds.items():
        began = time.process_time()
        result = own.inverse(poses, starts=30, threads=1)
        mean = (time.process_time() - began) / len(poses) * 1e6
        worst = one_alone(own, poses, None, (), int(result.steps.argmax()), starts=30)
        claimed, seen = int(result.reached.sum()), int(result.too_far.sum())
        rows.append([title, f"{len(poses)}", f"{claimed}", f"{seen}", f"{mean:.0f}", f"{worst / 1e3:.2f}"])
    return markdown(("iiwa 14, 30 starts", "poses", "claimed", "`too_far`", "µs a pose", "worst, ms"), rows)


FEW, MANY = {"solutions": 8, "starts": 200}, {"solutions": 64, "starts": 2000}
SAME = 1e-2
"""[rad] configurations of a pose that are closer than this, joint by joint, count as one."""


def of_solutions(count: int) -> str:
    """A table of a Panda's solution sets with each joint locked: those of 200 starts among those of 2,000."""
    arm, random = sr.arms.panda(), np.random.default_rng(5)
    q = random.uniform(*arm.position_limits.T, (count, arm.n))
    poses, rows = arm.forward(q), []
    for joint, name in enumerate(arm.joint_names):
        began = time.process_time()
        few = arm.inverse(poses, q, locked=[joint], **FEW, threads=1)
        mean = (time.process_time() - began) / count * 1e6
        many = arm.inverse(poses, q, locked=[joint], **MANY, seed=9)
        whole, held, total = held_by(few, many)
        rows.append(
            [name, f"{total / count:.2f}", f"{100 * held / total:.2f} %", f"{100 * whole / count:.1f} %", f"{mean:.0f}"]
        )
        print(*rows[-1], sep="  ", flush=True)
    head = (
        "panda, locked",
        "configurations a pose",
        "of them found by 200 starts",
        "poses with all of them",
        "µs a pose",
    )
    return f"{markdown(head, rows)}\n\n{second_opinion(count)}"


def second_opinion(count: int) -> str:
    """ssik's solution sets of a Panda without its fifth joint beside ours, in a sentence."""
    from bench.poses.race import CASES, Robot

    try:
        from bench.poses.ssik import All
    except ModuleNotFoundError as missing:
        return f"No second opinion: {missing}."
    arm, random = CASES[-1].arm(), np.random.default_rng(6)
    poses = arm.forward(random.uniform(*arm.position_limits.T, (count, arm.n)))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        arm.to_urdf(path)
        other = All(Robot("panda without a joint", str(path), *arm.position_limits.T))
    ours = arm.inverse(poses, **FEW)
    mine = theirs = common = 0
    for row, pose in enumerate(poses):
        own = ours.q[row, : ours.found[row]]
        found = np.array([one.q for one in other.solver.solve(pose)]).reshape(-1, arm.n)
        found = found[np.abs(arm.forward(found) - pose).max(axis=(1, 2), initial=0.0) < 1e-6]
        near = np.abs(own[:, None] - found[None]).max(axis=2) < SAME
        mine, theirs, common = mine + len(own), theirs + len(found), common + int(near.any(axis=0).sum())
    return (
        f"{CASES[-1].title}, {count} poses: 200 starts find {mine} configurations, ssik {theirs}; {common} of ssik's "
        f"are among ours."
    )


def held_by(few: sr.Inverse, many: sr.Inverse) -> tuple[int, int, int]:
    """Poses of which all configurations were found, of at most 8; configurations found; all configurations."""
    whole = held = total = 0
    for row in range(len(few)):
        own, wanted = few.q[row, : few.found[row]], many.q[row, : many.found[row]]
        apart = np.abs(own[:, None] - wanted[None]).max(axis=2).min(axis=0, initial=np.inf)
        most = min(len(wanted), FEW["solutions"])
        found = min(int((apart < SAME).sum()), most)
        whole, held, total = whole + (found == most), held + found, total + most
    return whole, held, total


def where(cores: int) -> str:
    """The date and the machine."""
    return (
        f"{datetime.date.today().isoformat()}, one core of {processor()} ({cores} cores; {machine_note(cores)}), "
        f"Python {platform.python_version()}."
    )


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m bench.reach", description=__doc__)
    parser.add_argument("arms", nargs="*", metavar="ARM", help=f"of {', '.join(ARMS)}")
    parser.add_argument("--poses", type=int, help="how many, of each kind")
    parser.add_argument("--peers", nargs="?", const="", metavar="A,B", help="other libraries, or these of them")
    parser.add_argument("--unreachable", action="store_true", help="poses that no configuration reaches")
    parser.add_argument("--solutions", action="store_true", help="how many configurations of a pose are found")
    parser.add_argument("--write", action="store_true", help="put what is measured into docs/inverse.md")
    given = parser.parse_args()
    cores = pin_to_one_core()
    made: tuple[str, Callable[[], str]]
    if given.peers is not None:
        keys = given.peers.split(",") if given.peers else None
        made = "reach-peers", lambda: of_peers(given.poses or 500, keys)
    elif given.unreachable:
        made = "reach-unreachable", lambda: of_unreachable(given.poses or 10_000)
    elif given.solutions:
        made = "reach-solutions", lambda: of_solutions(given.poses or 1000)
    else:
        made = "reach", lambda: of_arms(tuple(given.arms) or ARMS, given.poses or 100_000)
    name, measure = made
    text = f"{measure()}\n\n{where(cores)}"
    print(f"\n{text}")
    if given.write:
        put(PAGE, name, text)


if __name__ == "__main__":
    main()
