"""A run's summary, for people as a table and for machines as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stillreach.simulation import Run, Scenario
    from stillreach.simulation.summary import Summary

FLAGS = {
    "OK": "no limit active",
    "SATURATED": "a joint at a limit",
    "SCALED": "slowed down",
    "DAMPED": "damped",
    "SINGULAR": "singular",
    "OVER_LIMIT": "over a limit",
    "NO_WORKING_JOINT": "no joint left to move",
    "FAULT_NOT_COMPENSATED": "fault not made up for",
    "CLIPPED": "rates cut to their bounds",
    "LIMIT_GIVEN_UP": "a limit given up",
    "ITERATION_LIMIT": "search cut short",
    "INVALID_INPUT": "invalid input",
}
"""Status flags in words."""


TOO_FAST = "but drives cannot follow rates above their limits"


def facts(scenario: Scenario, run: Run, found: Summary) -> dict[str, Any]:
    """What --json prints of a run; docs/command-line.md explains the keys."""
    from stillreach.simulation.data import fault_data, law_data, task_data

    longest = found.longest
    return {
        "scenario": str(run.attrs["title"]),
        "arm": scenario.arm.name,
        "law": law_data(scenario),
        "task": task_data(scenario),
        "period": scenario.period,
        "duration": scenario.duration,
        "finished": found.finished,
        "interrupted": found.interrupted,
        "end": found.end,
        "ticks": len(run),
        "goal_distance": found.goal_distance if found.linear else None,
        "goal_angle": found.goal_angle if found.angular else None,
        "allowed_distance": found.allowed_distance if found.linear else None,
        "allowed_angle": found.allowed_angle if found.angular else None,
        "way": found.way,
        "turn": found.turn,
        "gave_way": found.gave_way,
        "why": found.why and vars(found.why),
        "largest_distance": _peak(found.distance) if found.linear else None,
        "largest_angle": _peak(found.angle) if found.angular else None,
        "largest_distance_from_path": found.beside if found.linear else None,
        "largest_task_error": _peak(found.task_error),
        "largest_rate": {
            "joint": found.rate_joint,
            "rate": found.rate_value,
            "of_limit": found.rate and found.rate.value,
            "time": found.rate and found.rate.time,
        },
        "faults": [fault_data(scenario, fault) for fault in scenario.faults],
        "statuses": found.statuses,
        "held": found.held,
        "held_longest": longest and dict(zip(("joint", "bound", "time"), longest, strict=True)),
        "singular_values_at_end": found.singular_values,
        "lost_directions_at_end": found.lost,
    }


def print_summary(scenario: Scenario, run: Run, found: Summary) -> None:
    """The table that a person reads."""
    from stillreach.cli._terminal import console
    from stillreach.cli._terminal import facts as table

    out = console()
    out.print(str(run.attrs["title"]), style="bold")
    out.print(
        f"{scenario.arm.name}, {type(scenario.law).__name__}, {len(run)} ticks of {1000 * scenario.period:g} ms\n"
    )
    if description := _first_paragraph(scenario.description):
        out.print(f"{description}\n")
    rows = [("arrived", verdict(found)), *([("why", found.why.sentence)] if found.why else [])]
    rows += [("gave way", gave_way(found)), *_deviations(found), ("largest rate", worst_rate(scenario, found))]
    rows += [("faults", text) if k == 0 else ("", text) for k, text in enumerate(fault_lines(scenario))]
    rows += [("status", _statuses(found)), ("limited by", _held(found)), ("lost at the end", _lost(scenario, found))]
    out.print(table(rows))


def verdict(found: Summary) -> str:
    """Did the tool arrive?"""
    if found.interrupted:
        return f"interrupted at {found.end:g} s"
    away = apart(found, found.goal_distance, found.goal_angle)
    allowed = apart(found, found.allowed_distance, found.allowed_angle)
    beyond = "; " + TOO_FAST if beyond_limits(found) else ""
    return f"{'yes' if found.finished else 'NO'}, {away} from the goal (allowed: {allowed}){beyond}"


def beyond_limits(found: Summary) -> bool:
    """Whether a law asked for more than the limits, so that drives would not have done what the run shows."""
    return "OVER_LIMIT" in found.statuses


def apart(found: Summary, distance: float, angle: float) -> str:
    """A distance [m] and an angle [rad], each where the task asks for it."""
    from stillreach.show.words import shown_angle, shown_length

    parts = [shown_length(distance)] if found.linear else []
    return ", ".join([*parts, shown_angle(angle)] if found.angular else parts)


def worst_rate(scenario: Scenario, found: Summary) -> str:
    """The largest rate against its limit."""
    from stillreach.show.words import shown, tidy

    joint = scenario.arm.joint_index(str(found.rate_joint))
    value = shown(abs(found.rate_value), "m" if scenario.arm.kinds[joint] else "rad", rate=True)
    if found.rate is None:
        return f"{found.rate_joint} {value}, no limit"
    return f"{tidy(100 * found.rate.value)} % of its limit: {found.rate_joint}, {value} at {found.rate.time:g} s"


def gave_way(found: Summary) -> str:
    """Which part of the task was farther off than what counts as arrived, and by how much."""
    from stillreach.show.words import shown_angle, shown_length

    amounts = {
        "position": (shown_length(found.distance.value), shown_length(found.goal_distance)),
        "orientation": (shown_angle(found.angle.value), shown_angle(found.goal_angle)),
    }
    texts = [
        f"{part} by {most} ({last} at the end)" for part, (most, last) in amounts.items() if part in found.gave_way
    ]
    return ", ".join(texts) or "nothing"


def is_late(found: Summary) -> bool:
    """Whether the tool was far from where it should be mostly because it came later."""
    return found.linear and found.distance.value > max(found.allowed_distance, 5.0 * found.beside)


def _first_paragraph(text: str) -> str:
    """In one line; a console breaks it where it needs to."""
    return " ".join(text.strip().partition("\n\n")[0].split())


def _deviations(found: Summary) -> list[tuple[str, str]]:
    from stillreach.show.words import shown_angle, shown_length, tidy

    def when(shown: str, time: float) -> str:  # rounding is at its largest at no time in particular
        return shown if shown.split()[0].rstrip("°") == "0" else f"{shown} at {time:g} s"

    far = [when(shown_length(found.distance.value), found.distance.time)] if found.linear else []
    far += [when(shown_angle(found.angle.value), found.angle.time)] if found.angular else []
    error = when(f"{tidy(found.task_error.value)} (weighted twist)", found.task_error.time)
    beside = [("off its path", f"at most {shown_length(found.beside)}")] if found.linear else []
    return [("farthest off", "; ".join(far)), *beside, ("task error", error)]


def fault_lines(scenario: Scenario) -> list[str]:
    """What fails when, a line for each kind and time."""
    from stillreach.show.moments import fault_groups

    lines = []
    for text, fault in fault_groups(scenario, scenario.arm.joint_names):
        since = f"from {fault.at:g} s on" if fault.at else "from the start"
        lines.append(f"{text} {since}{'' if fault.until is None else f', until {fault.until:g} s'}")
    return lines or ["none"]


def _statuses(found: Summary) -> str:
    return ", ".join(f"{100 * share:.3g} % {FLAGS[name]}" for name, share in found.statuses.items())


def _held(found: Summary) -> str:
    longest = found.longest
    if longest is None:
        return "no joint limit"
    joint, bound, time = longest
    others = len(found.held) - 1
    more = f"; {others} other joint{'s' if others > 1 else ''} for less" if others else ""
    return f"{joint}, {time:.3g} s at its {bound} limit{more}"


def _lost(scenario: Scenario, found: Summary) -> str:
    from stillreach.simulation.ability import in_words

    if not len(found.lost):
        weakest = f"{found.singular_values[-1]:.3g}" if len(found.singular_values) else "0"
        return f"no direction (smallest singular value {weakest})"
    indices = scenario.task.indices if scenario.task is not None else range(6)
    along = "" if scenario.task is None or scenario.task.frame == "base" else " (tool axes)"
    return "; ".join(in_words(twist, indices, signed=False) for twist in found.lost) + along


def _peak(peak: Any) -> dict[str, float]:
    return {"value": peak.value, "time": peak.time}
