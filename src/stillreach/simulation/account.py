"""A summary in words: names and sentences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stillreach._words import direction, shown, shown_angle, shown_length, shown_time, tidy
from stillreach.faults import Fault
from stillreach.simulation.held import BOUND_WORDS
from stillreach.simulation.scenario import Scenario
from stillreach.status import IN_WORDS, Status

if TYPE_CHECKING:
    from stillreach.simulation.summary import Summary, Unnoticed

TOO_FAST = "but drives cannot follow rates above their limits"


def account(found: Summary) -> list[tuple[str, str]]:
    """The lines of a run's summary: names and sentences."""
    rows = [("arrived", verdict(found)), *([("why", found.why.sentence)] if found.why else [])]
    rows += [("gave way", _gave_way(found)), *_deviations(found), ("largest rate", _worst_rate(found))]
    rows += [("unnoticed", text) if k == 0 else ("", text) for k, text in enumerate(map(_unnoticed, found.unnoticed))]
    rows += [("faults", text) if k == 0 else ("", text) for k, text in enumerate(fault_lines(found.run.scenario))]
    return [*rows, ("status", _statuses(found)), ("limited by", _held(found)), ("lost at the end", _lost(found))]


def verdict(found: Summary) -> str:
    """Whether the tool arrived."""
    if found.run.interrupted:
        return f"interrupted at {found.end:g} s"
    away = apart(found, found.goal_distance, found.goal_angle)
    allowed = apart(found, found.allowed_distance, found.allowed_angle)
    beyond = f"; {TOO_FAST}" if beyond_limits(found) else ""
    return f"{'yes' if found.finished else 'NO'}, {away} from the goal (allowed: {allowed}){beyond}"


def beyond_limits(found: Summary) -> bool:
    """Whether rates exceeded the limits, so that real drives could not follow the run."""
    return str(Status.OVER_LIMIT) in found.statuses


def apart(found: Summary, distance: float, angle: float, word: str = ", ") -> str:
    """A distance [m] and an angle [rad], each if the task has such rows."""
    parts = [shown_length(distance)] if found.linear else []
    return word.join([*parts, shown_angle(angle)] if found.angular else parts)


def is_late(found: Summary) -> bool:
    """Whether the tool was far from its target mostly because of delay."""
    return found.linear and found.distance.value > max(found.allowed_distance, 5.0 * found.beside)


def held_faults(scenario: Scenario) -> list[tuple[Fault, bool]]:
    """Each fault with the end of its time, and whether its joint works then; a later one of a joint replaces others."""
    held, index = [], scenario.arm.joint_index
    for place, fault in enumerate(scenario.faults):
        same = [(one.at, k) for k, one in enumerate(scenario.faults) if index(one.joint) == index(fault.joint)]
        replaced = min((at for at, k in same if (at, k) > (fault.at, place)), default=np.inf)
        end = min(replaced, np.inf if fault.until is None else fault.until)
        if end > fault.at:
            held.append((replace(fault, until=end if end < np.inf else None), end < replaced))
    return held


def fault_groups(scenario: Scenario, names: Sequence[str]) -> list[tuple[str, Fault]]:
    """Faults in words, grouped by kind and time: ``j2, j4 locked``, each with the first fault of the group.

    Args:
        scenario: with the faults.
        names: (n,) names of its joints.
    """
    found: dict[tuple[str, float, float | None], tuple[list[str], Fault]] = {}
    for fault, _ in held_faults(scenario):
        joint = scenario.arm.joint_index(fault.joint)
        what = fault.kind.sentence(slides=bool(scenario.arm.kinds[joint]))
        found.setdefault((what, fault.at, fault.until), ([], fault))[0].append(names[joint])
    return [(f"{', '.join(joints)} {what}", fault) for (what, _, _), (joints, fault) in found.items()]


def fault_lines(scenario: Scenario) -> list[str]:
    """The faults, one line for each kind and time."""
    lines = []
    for text, fault in fault_groups(scenario, scenario.arm.joint_names):
        since = f"from {fault.at:g} s on" if fault.at else "from the start"
        lines.append(f"{text} {since}{'' if fault.until is None else f', until {fault.until:g} s'}")
    return lines or ["none"]


def _worst_rate(found: Summary) -> str:
    """The largest rate relative to its limit."""
    unit = found.run.joint_units[found.run.joint_names.index(found.rate_joint)]
    value = shown(abs(found.rate_value), unit, rate=True)
    if found.rate is None:
        return f"{found.rate_joint} {value}, no limit"
    return f"{tidy(100 * found.rate.value)} % of its limit: {found.rate_joint}, {value} at {found.rate.time:g} s"


def _gave_way(found: Summary) -> str:
    """The parts of the task with errors above the allowed ones, and the errors."""
    amounts = {
        "position": (shown_length(found.distance.value), shown_length(found.goal_distance)),
        "orientation": (shown_angle(found.angle.value), shown_angle(found.goal_angle)),
    }
    texts = [
        f"{part} by {most} ({last} at the end)" for part, (most, last) in amounts.items() if part in found.gave_way
    ]
    return ", ".join(texts) or "nothing"


def _deviations(found: Summary) -> list[tuple[str, str]]:
    def when(shown: str, time: float) -> str:  # for rounding errors the time has no meaning
        return shown if shown.split()[0].rstrip("°") == "0" else f"{shown} at {time:g} s"

    far = [when(shown_length(found.distance.value), found.distance.time)] if found.linear else []
    far += [when(shown_angle(found.angle.value), found.angle.time)] if found.angular else []
    error = when(f"{tidy(found.task_error.value)} (weighted twist)", found.task_error.time)
    beside = [("off its path", f"at most {shown_length(found.beside)}")] if found.linear else []
    return [("farthest off", "; ".join(far)), *beside, ("task error", error)]


def _unnoticed(late: Unnoticed) -> str:
    """What the controller learned later, and what it cost."""
    off = [shown_length(late.distance), shown_angle(late.angle)]
    before = [shown_length(late.distance_before), shown_angle(late.angle_before)]
    what = f"{late.joint} {late.what or 'restored'}"
    moved = f"the tool {off[0]} and {off[1]} from its target (before: {before[0]} and {before[1]})"
    if not late.noticed:
        return f"{what}: the controller never knew; at the end {moved}"
    return f"{what}: the controller knew after {shown_time(late.until - late.since)}; then {moved}"


def _statuses(found: Summary) -> str:
    return ", ".join(f"{100 * share:.3g} % {IN_WORDS[Status[name]]}" for name, share in found.statuses.items())


def _held(found: Summary) -> str:
    longest = found.longest
    if longest is None:
        return "no joint limit"
    joint, bound, time = longest
    others = len(found.held) - 1
    more = f"; {others} other joint{'s' if others > 1 else ''} for a shorter time" if others else ""
    return f"{joint}, {time:.3g} s at its {BOUND_WORDS.get(bound, bound)} limit{more}"


def _lost(found: Summary) -> str:
    if not len(found.lost):
        weakest = f"{found.singular_values[-1]:.3g}" if len(found.singular_values) else "0"
        return f"no direction (smallest singular value {weakest})"
    task = found.run.task
    along = "" if task.frame == "base" else " (tool axes)"
    return "; ".join(direction(twist, task.indices, signed=False) for twist in found.lost) + along
