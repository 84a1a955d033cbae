"""The failure-tolerant workspace: where the tool can still go, whichever joint locks, wherever it then stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations, product
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._words import shown_length
from stillreach.arm import Arm
from stillreach.arm.limits import sampling_range
from stillreach.errors import InputError
from stillreach.task import Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ANGLES = 9
"""Places between its limits at which each joint is locked."""
STARTS = 30
MOST_POINTS = 10_000_000
"""Of a grid."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Workspace:
    """The poses of an arm that are reached before and after the loss of one joint or two.

    Args:
        arm: the arm.
        limits: (n, 2) [rad, m] artificial limits before the failure.
        poses: (P, 4, 4) [m].
        task: rows that count.
        before: (P,) whether a pose is reached within the artificial limits.
        after: (P, n) whether it is reached with each joint locked anywhere within them, the others within their own
            limits; True for a joint that does not fail.
        joints: indices of those that may fail.
        pairs: (P, n, n) the same with each two joints locked, each anywhere within its artificial limits; on the
            diagonal ``after``. None where one failure is all that counts.
        spacing: [m] of the grid of points; None where the poses were given.
    """

    arm: Arm
    limits: FloatArray
    poses: FloatArray
    task: Task
    before: npt.NDArray[np.bool_]
    after: npt.NDArray[np.bool_]
    joints: tuple[int, ...]
    pairs: npt.NDArray[np.bool_] | None = None
    spacing: float | None = None

    @property
    def tolerant(self) -> npt.NDArray[np.bool_]:
        """(P,) whether a pose is reached before the failure, and after that of any joint, or of any two."""
        single = self.before & self.after.all(axis=1)
        return np.asarray(single if self.pairs is None else single & self.pairs.all(axis=(1, 2)))

    @property
    def size(self) -> float:
        """[m^3], or [m^2] of a task in a plane: of the tolerant workspace, to the resolution of the grid.

        NaN without a grid.
        """
        cell = np.nan if self.spacing is None else self.spacing ** len(self.task.indices)
        return float(np.count_nonzero(self.tolerant) * cell)

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

    def __str__(self) -> str:
        what = "any joint" if self.pairs is None else "any two joints"
        text = (
            f"{int(self.tolerant.sum())} of {len(self.poses)} poses tolerate the failure of {what}, "
            f"{int(self.before.sum())} are reached before one"
        )
        if self.spacing is None:
            return text
        rows = len(self.task.indices)
        unit = "m" if rows == 1 else f"m^{rows}"
        return f"{text}; {self.size:.4g} {unit} on a grid of {shown_length(self.spacing)}"

    def __repr__(self) -> str:
        return f"<Workspace of {self.arm.name}: {self}>"


def workspace(
    arm: Arm,
    poses: npt.ArrayLike | None,
    limits: npt.ArrayLike | Mapping[str | int, tuple[float, float]] | None = None,
    *,
    joints: Any = None,
    failures: int = 1,
    spacing: float | None = None,
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
        poses: (P, 4, 4), or (P, 3) points for a task of positions [m]; None with a ``spacing``.
        limits: (n, 2) [rad, m], or by joint; joints that are not named, and None, keep their own.
        joints: names or indices of those that may fail; None: those with limits on both sides.
        failures: how many joints are locked together, 1 or 2, each anywhere within its limits.
        spacing: [m] between points of a grid over the whole reach, along the axes of a task of positions.
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
    places, chosen = _grid(arm, poses, spacing, task) if spacing is not None else _poses(poses, task)
    bounds = _limits(arm, limits)
    count = _door.count("angles", angles)
    if _door.count("failures", failures) > 2:
        raise InputError("failures", str(failures), "1 or 2")
    failing = _failing(arm, bounds, joints)
    settings: dict[str, Any] = {"task": chosen, "starts": starts, "seed": seed, "threads": threads}
    before = np.asarray(arm.with_limits(position=bounds).inverse(places, **settings).reached)
    stops = {joint: _stops(bounds[joint, 0], bounds[joint, 1], count) for joint in failing}
    after = np.ones((len(places), arm.n), dtype=bool)

    def still(reached: npt.NDArray[np.bool_], lost: tuple[int, ...]) -> npt.NDArray[np.bool_]:
        """Those of the poses that are reached wherever these joints are locked."""
        reached = reached.copy()
        for at in product(*(stops[joint] for joint in lost)):
            left = np.flatnonzero(reached)
            if len(left):
                locked = {joint: float(value) for joint, value in zip(lost, at, strict=True)}
                reached[left] = arm.inverse(places[left], locked=locked, **settings).reached
        return reached

    for joint in failing:
        after[:, joint] = still(before, (joint,))
    pairs = None
    if failures == 2:
        pairs = np.ones((len(places), arm.n, arm.n), dtype=bool)
        pairs[:, range(arm.n), range(arm.n)] = after
        for first, second in combinations(failing, 2):
            both = still(after[:, first] & after[:, second] & before, (first, second))
            pairs[:, first, second] = pairs[:, second, first] = both
        pairs[~before] = False
    after[~before] = False
    return Workspace(
        arm=arm,
        limits=_door.frozen(bounds),
        poses=_door.frozen(places),
        task=chosen,
        before=before,
        after=after,
        joints=tuple(failing),
        pairs=pairs,
        spacing=spacing,
    )


def _failing(arm: Arm, bounds: FloatArray, joints: Any) -> list[int]:
    """Indices of the joints that may fail, each with limits on both sides."""
    finite = [joint for joint in range(arm.n) if np.isfinite(bounds[joint]).all()]
    failing = finite if joints is None else [arm.joint_index(joint) for joint in joints]
    for joint in failing:
        if joint not in finite:
            raise InputError(
                "joints", f"{arm.joint_names[joint]}, whose limits are endless", "limits for each that may fail"
            )
    return failing


def _stops(low: float, high: float, count: int) -> FloatArray:
    """Where a joint is locked: evenly from one limit to the other, or in their middle."""
    return np.unique(np.linspace(low, high, count) if count > 1 else [0.5 * (low + high)])


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


def _grid(arm: Arm, poses: Any, spacing: Any, task: Task | None) -> tuple[FloatArray, Task]:
    """Points within the stretched arm's length of its first joint, and the task of positions."""
    if poses is not None:
        raise InputError("spacing", "poses, too", "one of them")
    chosen = Task(rows="position") if task is None else task
    axes = list(chosen.indices)
    if max(axes) > 2 or chosen.frame != "base":
        raise InputError("task", f"rows {', '.join(chosen.row_names)}", "with a spacing, positions along base axes")
    step = _door.positive("spacing", spacing)
    own = arm if chosen.tool is None else arm.with_tool(arm.tool @ chosen.tool)
    first = own.joints[0].placement[:3, 3]
    length = own.reach - float(np.linalg.norm(first))
    most = np.floor(length / step)
    if not (2.0 * most + 1.0) ** len(axes) <= MOST_POINTS:
        got = f"{step:g} m, {(2.0 * most + 1.0) ** len(axes):.3g} points"
        raise InputError("spacing", got, f"at most {MOST_POINTS} points")
    across = np.arange(-most, most + 1.0)
    cells = np.stack(np.meshgrid(*[across] * len(axes), indexing="ij"), axis=-1).reshape(-1, len(axes)) * step
    cells = cells[np.einsum("ij,ij->i", cells, cells) <= length**2]
    places = np.tile(own.forward(np.zeros(arm.n)), (len(cells), 1, 1))
    places[:, axes, 3] = first[axes] + cells
    return places, chosen


def _poses(poses: Any, task: Task | None) -> tuple[FloatArray, Task]:
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
