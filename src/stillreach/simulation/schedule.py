"""A scenario in ticks: when each part of its motion is commanded, and when faults begin and end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stillreach._door import FloatArray
from stillreach.control import Controller
from stillreach.faults import FaultKind
from stillreach.simulation.motion import Motion, checked_motion, ends
from stillreach.simulation.path import Stretch, led_to, stretches

if TYPE_CHECKING:
    from stillreach.simulation.scenario import Scenario

Change = tuple[int, FaultKind | None]
"""A joint (index) and its new fault, or None where it is restored."""


@dataclass(frozen=True, eq=False)
class Schedule:
    """The plan of a scenario, made once for all that need it.

    Args:
        motion: parts of the motion.
        starts: (parts + 1,) the tick from which on each part is commanded; the last is the rest after the motion.
        steps: number of steps.
        period: time between ticks [s].
        T_start: (4, 4) [m] pose of the task's point at the start.
        stretches: the courses among the parts, by the index of the part.
        changes: for each tick at which faults begin or end, the changes in the joints' order.
    """

    motion: tuple[Motion, ...]
    starts: tuple[int, ...]
    steps: int
    period: float
    T_start: FloatArray
    stretches: Mapping[int, Stretch]
    changes: Mapping[int, Sequence[Change]]

    @property
    def has_function(self) -> bool:
        """Whether the last part is a function of time."""
        return any(callable(part) for part in self.motion)

    def part(self, tick: float) -> int:
        """Index of the part that is commanded at a tick; the number of parts after the last one's end."""
        return sum(start <= tick for start in self.starts) - 1

    def poses(self, at: FloatArray) -> FloatArray:
        """(K, 4, 4) [m] where the motion leads, at ticks (K,) that do not fall, which may lie between whole ones."""
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

    def change_faults(self, controller: Controller, tick: int) -> None:
        """Tell a controller what fails and what works again at a tick."""
        for joint, kind in self.changes.get(tick, ()):
            if kind is None:
                controller.restore(joint)
            else:
                controller.fail(joint, kind)

    def spans(self) -> list[tuple[int, int]]:
        """First and last tick of each part and of the rest; the two are equal for a part that is never begun."""
        last = [min(start, self.steps) for start in self.starts[1:]] + [self.steps]
        return [(first, max(first, end)) for first, end in zip(self.starts, last, strict=True)]


def schedule_of(scenario: Scenario) -> Schedule:
    """The schedule of a scenario.

    Raises:
        InputError: a course is shorter than a tick, or cannot begin where the parts before it lead.
    """
    motion, T_start = checked_motion(scenario.motion), scenario.task_pose(scenario.start)
    starts = (0, *(scenario.tick_at(float(end)) for end in ends(motion)))
    courses = stretches(motion, starts, scenario.period, T_start)
    return Schedule(motion, starts, scenario.steps, scenario.period, T_start, courses, _fault_changes(scenario))


def _fault_changes(scenario: Scenario) -> dict[int, list[Change]]:
    """What changes at which tick.

    Faults may overlap on one joint: the one that began last holds, and when it ends, the one before it holds again.
    """
    arm, last = scenario.arm, scenario.steps
    spans = []
    for place, fault in enumerate(scenario.faults):
        first = scenario.tick_at(fault.at)
        end = last + 1 if fault.until is None else scenario.tick_at(fault.until)
        if first < end:
            spans.append((first, place, end, arm.joint_index(fault.joint), fault.kind))
    changes: dict[int, list[Change]] = {}
    for joint in sorted({span[3] for span in spans}):
        own = sorted((span for span in spans if span[3] == joint), key=lambda span: span[:2])
        now: FaultKind | None = None
        for tick in sorted({tick for span in own for tick in (span[0], span[2])}):
            active = [span for span in own if span[0] <= tick < span[2]]
            then = active[-1][4] if active else None
            if tick <= last and then != now:
                changes.setdefault(tick, []).append((joint, then))
            now = then
    return changes
