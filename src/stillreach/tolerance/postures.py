"""Postures and places that can afford to lose a joint: for one pose of the tool, and for a whole task."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.arm.dexterity import task_jacobian
from stillreach.arm.relative import failure_sets, null_basis
from stillreach.control import Controller
from stillreach.errors import InputError
from stillreach.null_motions import GuaranteedSpeed, Tolerance
from stillreach.simulation import Scenario
from stillreach.simulation.pose_table import PoseTable
from stillreach.simulation.progress import Progress
from stillreach.task import Task
from stillreach.tolerance.failures import Failures
from stillreach.tolerance.losses import least_everywhere, relative
from stillreach.tolerance.rehearsal import Rehearsal
from stillreach.tolerance.rehearse import rehearsed, targets

SAMPLES, CLIMBED = 256, 6
"""Configurations of the tool's pose that are looked at, and the best of them that are improved."""
STEPS, PERIOD = 400, 0.02
GAIN, LARGEST = 0.3, 0.3
APART = 0.1
"""[rad, m] of some joint between two postures."""
LONGEST, SHORTEST = 0.05, 1e-4
"""[rad, m] steps of the last search."""
SHIFTS = 0.1 * np.concatenate([np.eye(3), -np.eye(3)])
"""[m] where else a task may be."""
LOOKS = 12
"""Moments at which a start is rehearsed before the best is rehearsed in full."""


@dataclass(frozen=True, eq=False)
class Posture:
    """A posture that can afford to lose any one joint, or any set of several.

    Args:
        q: (n,) [rad] or [m].
        worst: what the worst loss leaves, there: relative manipulability from 0 to 1, or guaranteed speed.
        joints: names of those that are lost.
        before: the same at the start.
    """

    q: FloatArray
    worst: float
    joints: tuple[str, ...]
    before: float


def best_posture(
    arm: Arm,
    pose: npt.ArrayLike,
    start: npt.ArrayLike,
    *,
    task: Task | None = None,
    climb: Tolerance | GuaranteedSpeed | None = None,
    seed: int = 1994,
) -> Posture:
    """The configuration of a pose of the tool in which the worst loss costs least.

    Random configurations of the pose within the position limits, and the start itself; the best of them follow the
    gradient of what the worst loss leaves, with the tool in place. Never worse than the start.

    Args:
        arm: the arm.
        pose: (4, 4) [m] of the task's point.
        start: (n,) [rad] or [m], which has that pose.
        task: rows, frame and point; None: the full pose.
        climb: what the worst loss shall leave most of: the manipulability of ``Tolerance(failures=k)``, or the speed of
            ``GuaranteedSpeed()``; with its gain and largest rate. None: ``Tolerance()``, for any one joint.
        seed: of the random configurations.

    Raises:
        InputError: if an argument is invalid, or the start does not have the pose.
    """
    if not isinstance(arm, Arm):
        raise InputError("arm", _door.describe(arm), "an Arm")
    chosen = Task() if task is None else task
    target = _door.pose("pose", pose)
    q = _door.vector("start", start, arm.n, labels=arm.labels)
    reached = arm.inverse(target, q, task=chosen, nearest=True)
    if not reached.reached or float(np.max(np.abs(reached.q - q))) > 1e-6:
        raise InputError("start", "a configuration that does not have the pose", "one with the tool at the pose")
    motion = Tolerance(gain=GAIN, max_rate=LARGEST) if climb is None else climb
    if not isinstance(motion, Tolerance | GuaranteedSpeed):
        raise InputError("climb", _door.describe(climb), "a Tolerance or a GuaranteedSpeed")
    motion.check(arm.n, chosen.m)
    number = _door.count("seed", seed, minimum=0)

    found = arm.inverse(target, q, task=chosen, solutions=SAMPLES, starts=4 * SAMPLES, seed=number)
    samples = np.vstack([q, found.q[: int(found.found)]])
    marks, _ = _marks(arm, samples, chosen, motion)
    before = float(marks[0])
    order = np.argsort(marks, kind="stable")[::-1][:CLIMBED]
    tried = [
        samples[order[0]],
        *(at for place in order for at in _climbed(arm, samples[place], target, chosen, motion)),
    ]
    best = tried[int(np.argmax(_marks(arm, np.array(tried), chosen, motion)[0]))]
    best = _polished(arm, best, target, chosen, motion)
    left, joints = _marks(arm, best[None], chosen, motion)
    return Posture(_door.frozen(best), float(left[0]), tuple(arm.joint_names[joint] for joint in joints[0]), before)


def _marks(
    arm: Arm, q: FloatArray, task: Task, motion: Tolerance | GuaranteedSpeed
) -> tuple[FloatArray, npt.NDArray[np.int64]]:
    """(N,) what the worst loss leaves of configurations (N, n), and (N, k) the joints; 0 where the arm is singular."""
    if isinstance(motion, GuaranteedSpeed):
        joint = least_everywhere(arm, q, 1, task=task).joint
        place = np.argmin(joint, axis=1)
        return np.nan_to_num(joint[np.arange(len(q)), place]), place[:, None]
    found = relative(arm, q, motion.failures, task=task)
    sets = failure_sets(range(arm.n), motion.failures)
    return np.nan_to_num(found.worst[:, -1]), sets[found.which[:, -1]]


def _climbed(
    arm: Arm, q: FloatArray, target: FloatArray, task: Task, motion: Tolerance | GuaranteedSpeed
) -> Iterator[FloatArray]:
    """Configurations of the same pose along the gradient of what the worst loss leaves."""
    controller = Controller(arm, task=task, null_motion=motion, period=PERIOD)
    at = q.copy()
    for step in range(1, STEPS + 1):
        at = at + PERIOD * controller.track(at, target).rates
        if step % (STEPS // 4) == 0:
            there = arm.inverse(target, at, task=task, nearest=True, starts=1)
            if there.reached:
                yield np.asarray(there.q)


def _polished(
    arm: Arm, q: FloatArray, target: FloatArray, task: Task, motion: Tolerance | GuaranteedSpeed
) -> FloatArray:
    """The best configuration nearby: small steps along the self-motion, where the gradient's smooth minimum ends."""
    mark, step = float(_marks(arm, q[None], task, motion)[0][0]), LONGEST
    while step > SHORTEST:
        axes = null_basis(task_jacobian(arm, q, task)).T
        starts = q + step * np.vstack([axes, -axes])
        there = arm.inverse(np.tile(target, (len(starts), 1, 1)), starts, task=task, nearest=True, starts=1)
        marks = np.where(there.reached, _marks(arm, np.ascontiguousarray(there.q), task, motion)[0], -1.0)
        best = int(np.argmax(marks))
        if marks[best] > mark:
            q, mark = np.asarray(there.q[best]), float(marks[best])
        else:
            step /= 2.0
    return q


def better_start(
    rehearsal: Rehearsal,
    *,
    count: int = 64,
    seed: int = 1994,
    threads: int | None = None,
    progress: bool | None = None,
) -> Rehearsal | None:
    """The same task and failures, from the start posture from which most are survived.

    Postures of the tool's first pose within the position limits are drawn at random, and all failures are rehearsed
    from each, at a few moments; where the scenario has no null motion, from the best ones also with ``Tolerance``. The
    best one is rehearsed in full.

    Args:
        rehearsal: of the task from its own start.
        count: how many postures.
        seed: of the random postures.
        threads: how many; None: as for ``rehearse``.
        progress: show a bar; None: on a terminal, after one second.

    Returns:
        The rehearsal from the best of them, also as ``rehearsal.better``; None where none is better.

    Raises:
        InputError: if an argument is invalid.
    """
    scenario, failures, few = rehearsal.scenario, rehearsal.failures, _few(rehearsal)
    number, ways = _door.count("seed", seed, minimum=0), _door.count("count", count)
    first = rehearsed(scenario, few, rehearsal.limits, rehearsal.way, threads=threads, progress=False)
    found = scenario.arm.inverse(
        scenario.schedule.T_start,
        scenario.start,
        task=scenario.task,
        solutions=ways,
        starts=8 * ways,
        seed=number,
        apart=APART,
        tolerance=1e-9,
    )
    tried = [scenario]
    for q in found.q[: int(found.found)]:
        with suppress(InputError):  # a course that cannot begin with the attitude of this posture
            tried.append(replace(scenario, start=q))
    marks: list[tuple[tuple[float, float], Scenario]] = [(_mark(first), scenario)]
    with Progress("other postures", len(tried) + CLIMBED, progress) as bar:

        def look(others: Iterable[Scenario]) -> None:
            for other in others:
                looked = rehearsed(other, few, rehearsal.limits, rehearsal.way, threads=threads, progress=False)
                if looked.healthy_survives:
                    marks.append((_mark(looked), other))
                bar.update(len(marks))

        look(tried[1:])
        best = [other for _, other in sorted(marks, key=lambda pair: pair[0], reverse=True)[:CLIMBED]]
        if scenario.null_motion is None:
            look(replace(other, null_motion=Tolerance(gain=GAIN, max_rate=LARGEST)) for other in best)
    chosen = max(marks, key=lambda pair: pair[0])[1]
    if chosen is scenario:
        return None
    whole = rehearsed(chosen, failures, rehearsal.limits, rehearsal.way, threads=threads, progress=progress)
    if not whole.healthy_survives or whole.share <= rehearsal.share:
        return None
    rehearsal.better = whole
    return whole


def better_place(
    rehearsal: Rehearsal,
    shifts: npt.ArrayLike = SHIFTS,
    *,
    threads: int | None = None,
    progress: bool | None = None,
) -> Rehearsal | None:
    """The same task moved to where most failures are survived, as one moves a workpiece.

    At each place the arm begins in the posture nearest to its own. The failures are rehearsed at a few moments, and at
    the best place in full.

    Args:
        rehearsal: of the task where it is.
        shifts: (K, 3) [m] along the base axes; by default 0.1 m along each axis, either way.
        threads: how many; None: as for ``rehearse``.
        progress: show a bar; None: on a terminal, after one second.

    Returns:
        The rehearsal at the best of them, also as ``rehearsal.moved`` with ``rehearsal.shift``; None where none is
        better.

    Raises:
        InputError: if an argument is invalid.
    """
    places = _door.matrix("shifts", shifts, (None, 3))
    scenario, few = rehearsal.scenario, _few(rehearsal)
    target, task = targets(scenario), scenario.task
    first = rehearsed(scenario, few, rehearsal.limits, rehearsal.way, threads=threads, progress=False)
    best, mark, chosen = None, _mark(first), places[:0]
    with Progress("other places", len(places), progress) as bar:
        for done, shift in enumerate(places, start=1):
            poses = target.copy()
            poses[:, :3, 3] += shift
            start = scenario.arm.inverse(poses[0], scenario.start, task=task, nearest=True)
            with suppress(InputError):  # out of reach, or a posture with another attitude
                other = replace(
                    scenario, start=start.q, motion=_table(poses, scenario.period), duration=scenario.duration
                )
                looked = rehearsed(other, few, rehearsal.limits, rehearsal.way, threads=threads, progress=False)
                if looked.healthy_survives and _mark(looked) > mark:
                    best, mark, chosen = other, _mark(looked), shift
            bar.update(done)
    if best is None:
        return None
    whole = rehearsed(best, rehearsal.failures, rehearsal.limits, rehearsal.way, threads=threads, progress=progress)
    if not whole.healthy_survives or whole.share <= rehearsal.share:
        return None
    rehearsal.moved, rehearsal.shift = whole, _door.frozen(chosen)
    return whole


def _table(poses: FloatArray, period: float) -> PoseTable:
    """A motion through poses (T, 4, 4), one a tick."""
    return PoseTable(np.arange(len(poses)) * period, poses[:, :3, 3], orientations=poses[:, :3, :3])


def _few(rehearsal: Rehearsal) -> Failures:
    """The failures at a few moments."""
    ticks = rehearsal.failures.ticks
    return replace(rehearsal.failures, ticks=ticks[np.unique(np.linspace(0, len(ticks) - 1, LOOKS).astype(int))])


def _mark(found: Rehearsal) -> tuple[float, float]:
    """What makes a rehearsal better: more is survived, then smaller errors."""
    return found.share, -float(np.nanmean(np.log1p(found.excess)))
