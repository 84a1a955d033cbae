"""The peers on the same poses, one after the other on one core, each in a process of its own; ours judges the answers.

Times are those of the processor, so that other load counts little. An answer counts as solved whose pose, by
stillreach's forward kinematics of the same file, is the wanted one to TOLERANCE, inside the position limits.
"""

import multiprocessing
import os
import tempfile
import time
from dataclasses import dataclass
from importlib import metadata
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

import stillreach as sr
from bench.field import ONE_THREAD
from bench.peers import Entry
from bench.poses import BY_KEY
from bench.poses.base import BASE, TOLERANCE, TOOL, Robot
from bench.report import markdown
from stillreach.arm.limits import sampling_range

PATIENCE = 900.0
"""[s] how long a peer may take for all of its poses."""
ROUNDING = 1e-9
"""[rad] by how much an answer may be outside the limits."""


@dataclass(frozen=True)
class Case:
    """An arm, perhaps with a joint held, and its name in the table."""

    name: str
    title: str
    held: tuple[int, float] | None = None

    def arm(self) -> sr.Arm:
        arm = sr.arms.by_name(self.name)
        fixed = {} if self.held is None else {arm.joint_names[self.held[0]]: self.held[1]}
        plain = arm.with_limits(acceleration=np.inf)  # their URDF is version 1.2, which not all read
        return sr.Arm.from_urdf(plain.to_urdf(), tip=TOOL, base=BASE, fixed=fixed)


CASES = (
    Case("panda", "Panda"),
    Case("iiwa14", "iiwa14"),
    Case("xarm7", "xArm7"),
    Case("panda", "Panda, joint 5 locked at 0.3 rad", (4, 0.3)),
)


@dataclass
class Answers:
    """Of one peer: joint positions (N, n), NaN where it has none; seconds (N,) or the mean's (1,); or why there are
    none.
    """

    q: np.ndarray | None = None
    seconds: np.ndarray | None = None
    versions: dict[str, str] | None = None
    reason: str | None = None


def serve(key: str, robot: Robot, poses: np.ndarray, starts: np.ndarray, parent: Connection) -> None:
    """Answers all poses, and the times, or why there are none."""
    os.dup2(2, 1)  # solvers print, from C
    poses, starts = poses.astype(float), starts.astype(float)
    try:
        make = BY_KEY[key].load()
        peer = make(robot)
        versions = {name: metadata.version(name) for name in make.packages}
        if hasattr(peer, "solve_all"):
            peer.solve_all(poses[:8], starts[:8])
            began = time.process_time()
            q = peer.solve_all(poses, starts)
            seconds = np.array([(time.process_time() - began) / len(poses)])
        else:
            peer.solve(poses[0], starts[0])
            q, seconds = np.full_like(starts, np.nan), np.empty(len(poses))
            for i, (pose, start) in enumerate(zip(poses, starts, strict=True)):
                began = time.process_time()
                answer = peer.solve(pose, start)
                seconds[i] = time.process_time() - began
                if answer is not None:
                    q[i] = answer
    except Exception as error:
        parent.send(Answers(reason=f"{type(error).__name__}: {error}"))
        raise
    parent.send(Answers(q, seconds, versions))


def answers(entry: Entry, robot: Robot, poses: np.ndarray, starts: np.ndarray) -> Answers:
    """What a peer's process answers."""
    os.environ.update(ONE_THREAD)
    context = multiprocessing.get_context("spawn")
    pipe, child = context.Pipe()
    process = context.Process(target=serve, args=(entry.key, robot, poses, starts, child), daemon=True)
    process.start()
    child.close()
    try:
        return pipe.recv() if pipe.poll(PATIENCE) else Answers(reason=f"no answer for {PATIENCE:g} s")
    except (EOFError, OSError):
        process.join()
        return Answers(reason=f"its process ended with {process.exitcode}")
    finally:
        process.kill()
        process.join()


def solved(arm: sr.Arm, poses: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(N,) whether joint positions (N, n) inside the limits reach the poses."""
    lower, upper = arm.position_limits.T
    found = np.isfinite(q).all(axis=1)
    inside = ((q >= lower - ROUNDING) & (q <= upper + ROUNDING)).all(axis=1)
    at = np.where(found[:, None], q, 0.0)
    return found & inside & (np.abs(arm.forward(at) - poses).max(axis=(1, 2)) <= TOLERANCE)


def race(case: Case, entries: tuple[Entry, ...], count: int, versions: dict[str, str]) -> tuple[str, list[str]]:
    """The table of one arm, and who is left out."""
    arm, random = case.arm(), np.random.default_rng(1994)
    span = sampling_range(arm.kinds, *arm.position_limits.T)
    goal, starts = random.uniform(*span, (2, count, arm.n))
    poses = arm.forward(goal)
    lines, out, ours = [], [], np.nan
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.urdf"
        arm.to_urdf(path)
        name = case.name if case.held is None else f"{case.name} with a joint held"
        robot = Robot(name, str(path), *span)
        for entry in entries:
            found = answers(entry, robot, poses, starts)
            if found.q is None or found.seconds is None:
                out.append(f"{case.title}, left out: {entry.title}: {(found.reason or '').splitlines()[0]}.")
                print(out[-1], flush=True)
                continue
            versions |= found.versions or {}
            mean = float(found.seconds.mean()) * 1e6
            ours = mean if np.isnan(ours) else ours
            worst = "-" if len(found.seconds) == 1 else f"{found.seconds.max() * 1e6:,.0f}"
            share = f"{100 * float(solved(arm, poses, found.q).mean()):.2f} %"
            lines.append([entry.title, share, f"{mean:,.0f}", worst, f"{mean / ours:,.1f}"])
            print(case.title, *lines[-1], sep="  ", flush=True)
    head = (f"{case.title}, {count} poses", "solved", "mean [µs]", "worst [µs]", "times ours")
    return markdown(head, lines), out
