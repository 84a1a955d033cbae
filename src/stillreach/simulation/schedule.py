"""A scenario in ticks: start of each part of its motion, start and end of faults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stillreach._core import SimulatedPlant
from stillreach._door import FloatArray
from stillreach.control import Controller
from stillreach.faults import Fault, FaultKind
from stillreach.simulation.motion import Motion, checked_motion, ends
from stillreach.simulation.path import Stretch, led_to, stretches
from stillreach.status import Health

if TYPE_CHECKING:
    from stillreach.simulation.scenario import Scenario

Change = tuple[int, FaultKind | None]
"""A joint (index) and its new fault, or None when it is restored."""


@dataclass(frozen=True, eq=False)
class Schedule:
    """The plan of a scenario, made once.

    Args:
        motion: parts of the motion.
        starts: (parts + 1,) first tick of each part; the last one begins the rest after the motion.
        steps: number of steps.
        period: time between ticks [s].
        T_start: (4, 4) [m] pose of the task's point at the start.
        stretches: the courses among the parts, by the index of the part.
        changes: for each tick at which faults begin or end, the changes in the joints' order.
        known: the same for each tick at which the controller learns of changes.
    """

    motion: tuple[Motion, ...]
    starts: tuple[int, ...]
    steps: int
    period: float
    T_start: FloatArray
    stretches: Mapping[int, Stretch]
    changes: Mapping[int, Sequence[Change]]
    known: Mapping[int, Sequence[Change]]

    @property
    def has_function(self) -> bool:
        """Whether the last part is a function of time."""
        return any(callable(part) for part in self.motion)

    def part(self, tick: float) -> int:
        """Index of the commanded part at a tick; the number of parts after the end of the last one."""
        return sum(start <= tick for start in self.starts) - 1

    def poses(self, at: FloatArray) -> FloatArray:
        """(K, 4, 4) [m] commanded poses at non-decreasing ticks (K,), which may be fractional."""
        T = self.T_start
        poses = np.repeat(T[None], len(at), axis=0)
        for part, (first, end) in enumerate(self.spans()):
            if first == end:
                continue
            here = np.flatnonzero((at > first) & (at <= end))
            ticks = np.concatenate([[first], at[here], [end]])
            course = self.stretches.get(part)
            led = course.at(ticks)[0] if course else led_to(T, self.motion, part, ticks * self.period)
            poses[here], T = led[1:-1], led[-1]
        return poses

    def spans(self) -> list[tuple[int, int]]:
        """First and last tick of each part and of the rest; the two are equal for a part that never begins."""
        last = [min(start, self.steps) for start in self.starts[1:]] + [self.steps]
        return [(first, max(first, end)) for first, end in zip(self.starts, last, strict=True)]


def tell(controller: Controller, changes: Sequence[Change]) -> None:
    """Tell a controller of faults and restorations."""
    for joint, kind in changes:
        if kind is None:
            controller.restore(joint)
        else:
            controller.fail(joint, kind)


def break_joints(plant: SimulatedPlant, changes: Sequence[Change]) -> None:
    """Joints of a kinematic plant fail or are whole again, whether or not the controller knows."""
    for joint, kind in changes:
        if kind is None:
            plant.set_fault(joint, Health.HEALTHY, 0.0, 0.0)
        else:
            plant.set_fault(joint, kind.health, *kind.numbers)


def schedule_of(scenario: Scenario) -> Schedule:
    """The schedule of a scenario.

    Raises:
        InputError: if a course is shorter than a tick, or cannot begin at the final pose of the previous parts.
    """
    motion, T_start = checked_motion(scenario.motion), scenario.task_pose(scenario.start)
    starts = (0, *(scenario.tick_at(float(end)) for end in ends(motion)))
    courses = stretches(motion, starts, scenario.period, T_start)
    changes = fault_changes(scenario, scenario.faults)
    return Schedule(motion, starts, scenario.steps, scenario.period, T_start, courses, *changes)


def fault_changes(scenario: Scenario, faults: Sequence[Fault]) -> tuple[dict[int, list[Change]], ...]:
    """Changes of faults by tick: the true ones, and those that the controller knows of."""
    true: list[_Span] = []
    known: list[_Span] = []
    for place, fault in enumerate(faults):
        joint = scenario.arm.joint_index(fault.joint)
        for spans, delay in ((true, 0.0), (known, fault.known_after)):
            first = scenario.tick_at(fault.at + delay)
            end = scenario.steps + 1 if fault.until is None else scenario.tick_at(fault.until + delay)
            if first < end:
                spans.append(_Span(first, place, end, joint, fault.kind))
    return _changes(true, scenario.steps), _changes(known, scenario.steps)


class _Span(NamedTuple):
    """The ticks of a fault, and its place in the list."""

    first: int
    place: int
    end: int
    joint: int
    kind: FaultKind


def _changes(spans: list[_Span], last: int) -> dict[int, list[Change]]:
    """Changes by tick.

    Faults may overlap on one joint: the later one holds, and when it ends, the earlier one holds again.
    """
    changes: dict[int, list[Change]] = {}
    for joint in sorted({span.joint for span in spans}):
        own = sorted((span for span in spans if span.joint == joint), key=lambda span: span[:2])
        now: FaultKind | None = None
        for tick in sorted({tick for span in own for tick in (span.first, span.end)}):
            active = [span for span in own if span.first <= tick < span.end]
            then = active[-1].kind if active else None
            if tick <= last and then != now:
                changes.setdefault(tick, []).append((joint, then))
            now = then
    return changes
