"""Where an arm can still go after it lost a joint: the share of its poses that it still reaches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._words import aligned, joined, share, shown
from stillreach.arm import Arm
from stillreach.arm.limits import sampling_range
from stillreach.errors import InputError
from stillreach.inverse_result import Inverse
from stillreach.task import Task

__all__ = ["ReachLeft", "reach"]

HEAD = ("joint", "locked at", "still reached")


@dataclass(frozen=True, eq=False, repr=False)
class ReachLeft:
    """The poses that an arm still reaches with one joint locked; ``str()`` returns a table and a verdict.

    Args:
        arm: the arm.
        q: (n,) where each joint is locked [rad, m].
        poses: (N, 4, 4) [m] the given ones, or those of random configurations of the whole arm.
        before: (N,) whether the whole arm reaches a pose.
        by_joint: for each joint, the configurations that reach the poses with it locked.
    """

    arm: Arm
    q: FloatArray
    poses: FloatArray
    before: npt.NDArray[np.bool_]
    by_joint: dict[str, Inverse]

    @property
    def shares(self) -> FloatArray:
        """(n,) the share of the poses that is reached without each joint."""
        return _door.frozen([result.share for result in self.by_joint.values()])

    def lost(self, joint: str) -> npt.NDArray[np.intp]:
        """Indices of the poses that only the whole arm reaches.

        Args:
            joint: name of the joint that is locked.
        """
        return np.flatnonzero(self.before & ~self.by_joint[joint].reached)

    @property
    def verdict(self) -> str:
        """The loss that costs most, and the one that costs least, in words; and joints that hardly can be lost."""
        order = np.argsort(self.shares, kind="stable")
        least, most = (float(self.shares[i]) for i in (order[0], order[-1]))
        worst, best = (
            joined([name for name, part in zip(self.arm.joint_names, self.shares, strict=True) if part == end], "or")
            for end in (least, most)
        )
        low, high = share(least), share(most)
        text = f"The loss of {worst} costs most: {low} of the poses stay within reach. Without {best} it is {high}"
        if low == high:
            text = f"With any one joint locked, {low} of the poses stay within reach"
        if not self.before.all():
            text += f", with all joints {share(float(self.before.mean()))}"
        warnings = [result.warning for result in self.by_joint.values() if not result.reached.all()]
        return " ".join([f"{text}.", *filter(None, warnings)])

    def table(self) -> list[tuple[str, str, str]]:
        """Cells of the table below HEAD, one row for each joint."""
        at = [shown(value, unit) for value, unit in zip(self.q, self.arm.joint_units, strict=True)]
        return [
            (name, place, share(result.share)) for (name, result), place in zip(self.by_joint.items(), at, strict=True)
        ]

    def __str__(self) -> str:
        return "\n".join([aligned([HEAD, *self.table()]), "", self.verdict])

    def __repr__(self) -> str:
        parts = ", ".join(f"{name} {share(result.share)}" for name, result in self.by_joint.items())
        return f"<ReachLeft of {self.arm.name}: {parts}>"


def reach(
    arm: Arm,
    q: npt.ArrayLike,
    *,
    poses: npt.ArrayLike | None = None,
    task: Task | None = None,
    samples: int = 1000,
    starts: int = 100,
    tolerance: float = 1e-6,
    seed: int = 1994,
    threads: int | None = None,
) -> ReachLeft:
    """The share of an arm's poses that it still reaches after each joint is locked.

    Without ``poses`` they are those of random configurations within the position limits, so that the whole arm reaches
    all of them. A pose counts as lost if no start of ``arm.inverse`` reaches it: for arms of ordinary size, that is
    wrong for fewer than 1 pose in 1000 with 100 starts.

    Args:
        arm: the arm.
        q: (n,) where each joint is locked [rad, m], or by joint name.
        poses: (N, 4, 4) [m] the poses that the arm is for, at the task's point; None: random ones.
        task: rows, frame and point; None: all six rows at the arm's tool.
        samples: number of random poses.
        starts: the most searches for a pose.
        tolerance: [m, rad] largest entry of the error of a pose that counts as reached.
        seed: of the random configurations and starts.
        threads: how many to use; None: the environment's STILLREACH_THREADS, or the processors at hand.

    Raises:
        InputError: if an argument is invalid.
    """
    at = _door.vector("q", q, arm.n, labels=arm.labels)
    count = _door.count("samples", samples)
    random = np.random.default_rng(_door.count("seed", seed, minimum=0))
    settings: dict[str, Any] = {"task": task, "starts": starts, "tolerance": tolerance, "seed": seed}
    settings["threads"] = threads
    if poses is None:
        configurations = random.uniform(*sampling_range(arm.kinds, *arm.position_limits.T), (count, arm.n))
        own = arm if task is None or task.tool is None else arm.with_tool(arm.tool @ task.tool)
        places, before = own.forward(configurations), np.ones(count, dtype=bool)
    else:
        places = _door.array("poses", poses, "poses (N, 4, 4)")
        if places.ndim != 3:
            raise InputError("poses", _door.describe(places), "poses (N, 4, 4)")
        before = np.array(arm.inverse(places, **settings).reached)
    by_joint = {name: arm.inverse(places, locked={name: at[i]}, **settings) for i, name in enumerate(arm.joint_names)}
    for result in by_joint.values():
        before |= result.reached
    return ReachLeft(arm, at, places, before, by_joint)
