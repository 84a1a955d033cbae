"""The failure-tolerant workspace: where the tool can still go, whichever joint locks, wherever it then stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.arm.limits import sampling_range
from stillreach.errors import InputError
from stillreach.task import Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ANGLES = 9
"""Places between its limits at which each joint is locked."""
STARTS = 30


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Workspace:
    """The poses of an arm that are reached before and after the loss of a joint.

    Args:
        arm: the arm.
        limits: (n, 2) [rad, m] artificial limits before the failure.
        poses: (P, 4, 4) [m].
        task: rows that count.
        before: (P,) whether a pose is reached within the artificial limits.
        after: (P, n) whether it is reached with each joint locked anywhere within them, the others within their own
            limits; True for a joint that does not fail.
        joints: indices of those that may fail.
    """

    arm: Arm
    limits: FloatArray
    poses: FloatArray
    task: Task
    before: npt.NDArray[np.bool_]
    after: npt.NDArray[np.bool_]
    joints: tuple[int, ...]

    @property
    def tolerant(self) -> npt.NDArray[np.bool_]:
        """(P,) whether a pose is reached before the failure, and after that of any joint."""
        return np.asarray(self.before & self.after.all(axis=1))

    @property
    def share(self) -> float:
        """The share of the poses that are tolerant, 0 to 1."""
        return float(np.mean(self.tolerant))

    def plot(self) -> Figure:
        """A figure: the points seen from above and from the side, by what is reached.

        Raises:
            MissingExtraError: if matplotlib is not installed (extra ``plot``).
        """
        from stillreach.show.cloud import cloud

        return cloud(self)

    def __repr__(self) -> str:
        return f"<Workspace of {self.arm.name}: {int(self.tolerant.sum())} of {len(self.poses)} poses tolerant>"


def workspace(
    arm: Arm,
    poses: npt.ArrayLike,
    limits: npt.ArrayLike | Mapping[str | int, tuple[float, float]] | None = None,
    *,
    joints: Any = None,
    task: Task | None = None,
    angles: int = ANGLES,
    starts: int = STARTS,
    seed: int = 1994,
    threads: int | None = None,
) -> Workspace:
    """Which poses an arm reaches before a failure within artificial limits, and after it wherever the joint stands.

    After Lewis and Maciejewski (1997) and Bader and Maciejewski (2020): before a failure every joint stays within
    artificial limits; the joint that locks may then stand anywhere in them, and the others have their own limits.

    Args:
        arm: the arm.
        poses: (P, 4, 4), or (P, 3) points for a task of positions [m].
        limits: (n, 2) [rad, m], or by joint; joints that are not named, and None, keep their own.
        joints: names or indices of those that may fail; None: those with limits on both sides.
        task: rows that count; None: the full pose, or the position for points.
        angles: at how many places of its limits, the ends among them, each joint is locked.
        starts: the most searches for a pose. A pose that none of them reaches counts as not reached.
        seed: of the random starts.
        threads: how many; None: as for ``solve_batch``.

    Raises:
        InputError: if an argument is invalid.
        UnknownJointError: if the arm has no such joint.
    """
    if not isinstance(arm, Arm):
        raise InputError("arm", _door.describe(arm), "an Arm")
    places, chosen = _poses(poses, task)
    bounds = _limits(arm, limits)
    count = _door.count("angles", angles)
    finite = [joint for joint in range(arm.n) if np.isfinite(bounds[joint]).all()]
    failing = finite if joints is None else [arm.joint_index(joint) for joint in joints]
    for joint in failing:
        if joint not in finite:
            raise InputError(
                "joints", f"{arm.joint_names[joint]}, whose limits are endless", "limits for each that may fail"
            )
    settings: dict[str, Any] = {"task": chosen, "starts": starts, "seed": seed, "threads": threads}
    narrow = arm.with_limits(position=bounds)
    before = np.asarray(narrow.inverse(places, **settings).reached)
    after = np.ones((len(places), arm.n), dtype=bool)
    for joint in failing:
        low, high = bounds[joint]
        for at in np.unique(np.linspace(low, high, count) if count > 1 else [0.5 * (low + high)]):
            left = np.flatnonzero(before & after[:, joint])
            if len(left):
                found = arm.inverse(places[left], locked={joint: float(at)}, **settings)
                after[left, joint] = found.reached
    after[~before] = False
    return Workspace(
        arm=arm,
        limits=_door.frozen(bounds),
        poses=_door.frozen(places),
        task=chosen,
        before=before,
        after=after,
        joints=tuple(failing),
    )


def best_limits(
    arm: Arm,
    poses: npt.ArrayLike,
    *,
    joints: Any = None,
    task: Task | None = None,
    steps: int = 6,
    rounds: int = 3,
    angles: int = 5,
    starts: int = STARTS,
    seed: int = 1994,
    threads: int | None = None,
) -> Workspace:
    """The artificial limits within which most of the poses are failure-tolerant.

    One joint after the other gets the best pair of limits of a grid over its range, the others keeping theirs, from
    its whole range and from its middle half; until a round changes nothing. It need not find the best of all.

    Args:
        arm: the arm.
        poses: (P, 4, 4), or (P, 3) points [m]; a few hundred will do.
        joints: names or indices of those that may fail and get limits; None: all.
        task: as for ``workspace``.
        steps: of the grid over each range; endless joints have a turn.
        rounds: the most.
        angles: as for ``workspace``.
        starts: as for ``workspace``.
        seed: as for ``workspace``.
        threads: as for ``workspace``.

    Returns:
        The workspace with these limits.

    Raises:
        InputError: if an argument is invalid.
        UnknownJointError: if the arm has no such joint.
    """
    if not isinstance(arm, Arm):
        raise InputError("arm", _door.describe(arm), "an Arm")
    chosen = list(range(arm.n)) if joints is None else [arm.joint_index(joint) for joint in joints]
    cuts, most = _door.count("steps", steps, minimum=2), _door.count("rounds", rounds)
    settings: dict[str, Any] = {"joints": chosen, "task": task, "angles": angles, "starts": starts, "seed": seed}
    settings["threads"] = threads
    low, high = sampling_range(arm.kinds, *np.array(arm.position_limits).T)

    def judged(limits: FloatArray) -> Workspace:
        return workspace(arm, poses, limits, **settings)

    best: Workspace | None = None
    for room in (1.0, 0.5):
        limits = np.array(arm.position_limits)
        middle, half = 0.5 * (low + high), 0.5 * room * (high - low)
        limits[chosen] = np.column_stack([middle - half, middle + half])[chosen]
        now = judged(limits)
        for _ in range(most):
            before = now.share
            for joint in chosen:
                grid = np.linspace(low[joint], high[joint], cuts + 1)
                for pair in combinations(grid, 2):
                    tried = np.array(now.limits)
                    tried[joint] = pair
                    other = judged(tried)
                    now = other if other.share > now.share else now
            if now.share <= before:
                break
        best = now if best is None or now.share > best.share else best
    assert best is not None
    return best


def _poses(poses: npt.ArrayLike, task: Task | None) -> tuple[FloatArray, Task]:
    """Poses (P, 4, 4), and the task."""
    given = _door.array("poses", poses, "poses (P, 4, 4) or points (P, 3)")
    if given.ndim == 2 and given.shape[1] == 3:
        places = np.tile(np.eye(4), (len(given), 1, 1))
        places[:, :3, 3] = given
        return places, Task(rows="position") if task is None else task
    if given.ndim != 3 or given.shape[1:] != (4, 4):
        raise InputError("poses", _door.describe(poses), "poses (P, 4, 4) or points (P, 3)")
    return given, Task() if task is None else task


def _limits(arm: Arm, limits: Any) -> FloatArray:
    """(n, 2) artificial limits, within those of the arm."""
    own = np.array(arm.position_limits)
    if limits is None:
        return own
    if isinstance(limits, Mapping):
        for joint, pair in limits.items():
            own[arm.joint_index(joint)] = _door.vector("limits", pair, 2, one_for_all=False, allow_inf=True)
        given = own
    else:
        given = _door.matrix("limits", limits, (arm.n, 2), allow_inf=True)
    if np.any(given[:, 0] > given[:, 1]):
        joint = int(np.argmax(given[:, 0] > given[:, 1]))
        raise InputError(
            "limits", f"{given[joint].tolist()} for {arm.joint_names[joint]}", "lower limits below upper ones"
        )
    low, high = np.array(arm.position_limits).T
    return np.column_stack([np.maximum(given[:, 0], low), np.minimum(given[:, 1], high)])
