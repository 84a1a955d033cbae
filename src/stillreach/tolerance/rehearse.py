"""Rehearse a task: every failure of every joint, at many moments, in closed loop.

Each case begins at its onset from one healthy run, with the controller and the plant as they are then, and goes on as
``simulate`` would: the ticks, the feedback and the delay of knowing are those of a run with that fault.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._core import SimulatedPlant, frames, pose_distances
from stillreach._door import FloatArray
from stillreach.batch import threads_of
from stillreach.errors import InputError
from stillreach.faults import FaultKind
from stillreach.plants import KinematicPlant
from stillreach.recordings import Recording
from stillreach.simulation import Scenario
from stillreach.simulation.commanded import along_tool, asked, commanded
from stillreach.simulation.document import check_whole
from stillreach.simulation.orders import Part, parts_of
from stillreach.simulation.progress import Progress
from stillreach.simulation.record import empty_record
from stillreach.simulation.schedule import Change, break_joints, fault_changes, tell
from stillreach.simulation.summary import allowed_errors
from stillreach.tolerance.cause import Cause, Missed, causes_of, missed
from stillreach.tolerance.failures import Failures
from stillreach.tolerance.rehearsal import Rehearsal


def rehearse(
    task: Scenario | Recording,
    *,
    kinds: Sequence[str | FaultKind] | str | FaultKind = ("locked",),
    k: int = 1,
    joints: Sequence[str | int] | None = None,
    onsets: int | npt.ArrayLike = 100,
    known_after: float = 0.0,
    allowed_distance: float | None = None,
    allowed_angle: float | None = None,
    threads: int | None = None,
    progress: bool | None = None,
    **settings: Any,
) -> Rehearsal:
    """Which failures an arm survives on a task, and when.

    A failure is survived if from its onset on the tool stays within the allowed distance and angle of its target, until
    the end. Whether the arm without a failure does so is ``healthy_survives``; it does not change what counts.

    Args:
        task: a scenario with ``clock="time"``, whose own faults hold as well, or a recording.
        kinds: words of ``KINDS``, or faults such as ``Derated(0.2)``.
        k: how many joints fail, all at once and in the same way.
        joints: names or indices of those that may fail; None: all that the scenario leaves healthy.
        onsets: how many moments, evenly spaced from the start on, or moments [s].
        known_after: [s] until the controller knows of the failure; inf: it never does.
        allowed_distance: [m] None: 1 % of the path, at least 1 mm.
        allowed_angle: [rad] None: 1 % of the turn, at least 1 deg.
        threads: how many; None: as for ``solve_batch``.
        progress: show a bar; None: on a terminal, after one second.
        settings: replace those of the scenario, e.g. ``law=`` or ``null_motion=``.

    Returns:
        What became of each failure. After Ctrl-C those that are done, and ``interrupted`` is True.

    Raises:
        InputError: if an argument is invalid.
        UnknownJointError: if the arm has no such joint.
    """
    scenario = _scenario(task, settings)
    cases = Failures.of(scenario, kinds, k, joints, onsets, known_after)
    way = commanded(scenario).length()
    limits = allowed_errors(way, allowed_distance, allowed_angle)
    return rehearsed(scenario, cases, limits, way, threads=threads, progress=progress)


def rehearsed(
    scenario: Scenario,
    cases: Failures,
    limits: tuple[float, float],
    way: tuple[float, float],
    *,
    threads: int | None,
    progress: bool | None,
) -> Rehearsal:
    """The rehearsal of some cases; limits [m, rad] on the errors, way [m, rad] along the path."""
    began = time.perf_counter()
    found = Rehearsal.empty(scenario, cases, limits, way)
    _run(_Course(scenario, cases.known_after), cases, found, threads_of(threads) or _processors(), progress)
    found.seconds = time.perf_counter() - began
    return found


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _scenario(task: Any, settings: Mapping[str, Any]) -> Scenario:
    if isinstance(task, Recording):
        scenario = task.scenario(**settings)
    elif isinstance(task, Scenario):
        names = set(Scenario.__dataclass_fields__)
        for name in settings:
            if name not in names:
                raise TypeError(f"rehearse() got an unexpected keyword argument {name!r}")
        scenario = replace(task, **settings) if settings else task
    else:
        raise InputError("task", _door.describe(task), "a Scenario or a Recording")
    if scenario.clock != "time":
        raise InputError("task", f'clock = "{scenario.clock}"', 'clock = "time": each case must have the same targets')
    if not isinstance(scenario.plant, KinematicPlant):
        raise InputError("task", f"a scenario with {type(scenario.plant).__name__}", "one with KinematicPlant")
    check_whole(scenario)
    return scenario


RECORDED = ("measured", "rates", "pose", "command", "task_error", "lower", "upper", "known", "active")
"""What a case keeps of its ticks, until it is judged."""
OVER = 1e-9
"""Relative; a rate this much beyond its bounds is rounding."""


def targets(scenario: Scenario) -> FloatArray:
    """(ticks, 4, 4) [m] the commanded poses of a scenario."""
    return np.concatenate([part.targets for part in parts_of(scenario)])


@dataclass(frozen=True)
class _Moment:
    """The healthy run just before a tick, and the tick from which the controller knows of a failure then."""

    q: FloatArray
    informed: int
    memory: Any
    plant: SimulatedPlant | None


class _Course:
    """What all cases share: commands and targets by tick, the errors of the encoders, the healthy run."""

    def __init__(self, scenario: Scenario, known_after: float) -> None:
        self.scenario, self.ticks, self.n = scenario, scenario.steps + 1, scenario.arm.n
        self.last = self.ticks - 1
        self.parts = parts_of(scenario)
        self.stages = 2 if scenario.integrator == "rk4" else 1
        self.target = np.concatenate([part.targets for part in self.parts])
        closed = scenario.loop == "closed"
        self.frames = {part.first: frames(part.poses) if closed else None for part in self.parts}
        plant = scenario.plant
        assert isinstance(plant, KinematicPlant)
        faults = scenario.faults
        self.has_plant = not plant.exact or known_after > 0.0 or any(fault.known_after for fault in faults)
        self.noise = plant.errors(self.ticks, self.n)
        self.known_after = known_after
        task = scenario.task
        assert task is not None
        self.asked, self.along_tool = asked(task).ravel(), along_tool(task)

    def new_plant(self) -> SimulatedPlant | None:
        plant = self.scenario.plant
        assert isinstance(plant, KinematicPlant)
        return plant.simulated(self.n, self.scenario.period) if self.has_plant else None

    def distances(self, pose: FloatArray, first: int) -> FloatArray:
        """(2, K) distances [m] and angles [rad] from the targets from a tick on."""
        wanted = self.target[first : first + len(pose)]
        return np.asarray(pose_distances(pose, wanted, self.asked, self.along_tool))

    def moments(self, ticks: npt.NDArray[np.int64], found: Rehearsal) -> list[_Moment]:
        """The healthy run just before some ticks; its errors go into the rehearsal."""
        worker = _Worker(self)
        q, plant = self.scenario.start.copy(), self.new_plant()
        changes = fault_changes(self.scenario, self.scenario.faults)
        moments: list[_Moment] = []
        tick = 0
        for until in [*ticks.tolist(), self.ticks]:
            worker.go(tick, until, q, plant, *changes)
            tick = until
            if until < self.ticks:
                found.q[len(moments)] = q
                informed = self.scenario.tick_at(until * self.scenario.period + self.known_after)
                state = worker.controller.memory(), plant.copy() if plant else None
                moments.append(_Moment(q.copy(), min(informed, self.ticks), *state))
        off = self.distances(worker.record["pose"], 0)
        found.healthy_distance[:], found.healthy_angle[:] = off
        return moments


class _Worker:
    """A controller and memory for a record, of one thread."""

    def __init__(self, course: _Course) -> None:
        self.course = course
        self.controller = course.scenario.controller()
        self.record = empty_record(course.ticks, course.n)

    def go(
        self,
        first: int,
        until: int,
        q: FloatArray,
        plant: SimulatedPlant | None,
        changes: Mapping[int, Sequence[Change]],
        known: Mapping[int, Sequence[Change]],
    ) -> None:
        """The ticks from ``first`` to ``until``, as ``simulate`` has them."""
        course = self.course
        breaks = sorted({tick for tick in (*changes, *known) if first < tick < until})
        for a, b in _pieces(first, until, breaks, course.parts):
            tell(self.controller, known.get(a, ()))
            if plant:
                break_joints(plant, changes.get(a, ()))
            part = next(part for part in course.parts if part.first <= a < part.end)
            last = a == course.last
            given = course.frames[part.first]
            from_, to = course.stages * (a - part.first), course.stages * (b - part.first)
            rows = slice(from_, to + (course.stages == 2 and not last))
            rows = slice(0, 1) if last else rows
            self.controller.rollout(
                q,
                part.twists[rows],
                None if given is None else given[rows],
                integrator=course.scenario.integrator,
                advance=not last,
                plant=plant,
                noise=None if course.noise is None or plant is None else course.noise[a:b],
                record={name: self.record[name][a:b] for name in RECORDED},
            )


def _outside(record: Mapping[str, np.ndarray], first: int) -> tuple[int, int]:
    """The first tick, from one on, whose rates are outside their bounds, and the joint; or -1, -1."""
    rates, lower, upper = (record[name][first:] for name in ("rates", "lower", "upper"))
    room = OVER * (upper - lower)
    out = (rates < lower - room) | (rates > upper + room)
    ticks = np.flatnonzero(out.any(axis=1))
    return (first + int(ticks[0]), int(np.argmax(out[ticks[0]]))) if len(ticks) else (-1, -1)


def _pieces(first: int, until: int, breaks: list[int], parts: Sequence[Part]) -> Iterator[tuple[int, int]]:
    """Ranges of ticks without a change of faults or motion."""
    cuts = sorted({first, until, *breaks, *(part.first for part in parts if first < part.first < until)})
    return pairwise(cuts)


def _run(course: _Course, cases: Failures, found: Rehearsal, threads: int, progress: bool | None) -> None:
    """All cases, an onset at a time in each thread."""
    moments = course.moments(cases.ticks, found)
    own, stop = threading.local(), threading.Event()

    def onset(place: int) -> int:
        if not hasattr(own, "worker"):
            own.worker = _Worker(course)
        count = 0
        lost: dict[tuple[int, int, int], Missed] = {}
        for kind, which in np.ndindex(*cases.shape[:2]):
            if stop.is_set():
                break
            tick = _case(own.worker, cases, found, moments[place], (kind, which, place))
            if tick:
                lost[kind, which, place] = tick
            count += 1
        if lost:
            causes = causes_of(found.scenario, list(lost.values()))
            for case, (cause, joint) in zip(lost, causes, strict=True):
                found.cause[case], found.limited_by[case] = cause, joint
        return count

    total, done = int(np.prod(cases.shape)), 0
    name = found.scenario.name or "rehearsing"
    with ThreadPoolExecutor(max_workers=min(threads, len(cases.ticks))) as pool, Progress(name, total, progress) as bar:
        waiting: set[Future[int]] = {pool.submit(onset, place) for place in range(len(cases.ticks))}
        try:
            while waiting:
                ended, waiting = wait(waiting, timeout=0.2, return_when=FIRST_COMPLETED)
                done += sum(future.result() for future in ended)
                bar.update(done)
        except KeyboardInterrupt:
            found.interrupted = True
        finally:
            stop.set()
            for future in waiting:
                future.cancel()


def _case(
    worker: _Worker,
    cases: Failures,
    found: Rehearsal,
    moment: _Moment,
    place: tuple[int, int, int],
) -> Missed | None:
    """One case, from its onset to the end; what became of it goes into the rehearsal.

    Returns:
        Where its cause is still to be found, the tick that tells it.
    """
    course, first, informed = worker.course, int(cases.ticks[place[2]]), moment.informed
    scenario = course.scenario
    if scenario.faults:
        changes, known = fault_changes(scenario, (*scenario.faults, *cases.faults(scenario, place, moment.q)))
    else:  # the same, sooner
        told: list[Change] = list(cases.broken(scenario, place, moment.q))
        changes, known = {first: told}, {informed: told}
    worker.controller.recall(moment.memory)
    plant = moment.plant.copy() if moment.plant else None
    worker.go(first, course.ticks, moment.q.copy(), plant, changes, known)
    off = course.distances(worker.record["pose"][first:], first)
    informed = min(informed, course.last)
    distance, angle = off
    farthest = int(distance.argmax())
    worst = distance[farthest], angle[angle.argmax()]
    found.worst_distance[place], found.worst_angle[place] = worst
    found.worst_time[place] = (first + farthest) * scenario.period
    found.final_distance[place], found.final_angle[place] = off[:, -1]
    found.delay_distance[place], found.delay_angle[place] = off[:, informed - first]
    tick = course.ticks
    if not (worst[0] <= found.limits[0] and worst[1] <= found.limits[1]):
        tick = first + int(np.argmax(~((distance <= found.limits[0]) & (angle <= found.limits[1]))))
    assert scenario.law is not None
    if not scenario.law.keeps_bounds:
        outside, joint = _outside(worker.record, first)
        if 0 <= outside < tick:
            found.failed_time[place] = outside * scenario.period
            found.cause[place], found.limited_by[place] = Cause.LIMITS, joint
            return None
    if tick == course.ticks:
        found.cause[place] = Cause.SURVIVES
        return None
    found.failed_time[place] = tick * scenario.period
    if tick >= informed:
        return missed(worker.record, informed, tick)
    found.cause[place] = Cause.DELAY
    return None
