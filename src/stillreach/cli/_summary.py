"""A run's summary, for people as a table and for machines as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stillreach.faults import Fault
    from stillreach.simulation import Scenario, Summary


def facts(found: Summary) -> dict[str, Any]:
    """The output of --json for a run; docs/command-line.md explains the keys."""
    from stillreach.simulation.document import scenario_data

    scenario, longest = found.run.scenario, found.longest
    data = scenario_data(scenario)
    return {
        "scenario": scenario.title,
        "arm": scenario.arm.name,
        **{key: data[key] for key in ("law", "task", "period", "duration")},
        "finished": found.finished,
        "interrupted": found.run.interrupted,
        "end": found.end,
        "ticks": len(found.run),
        "goal_distance": found.goal_distance if found.linear else None,
        "goal_angle": found.goal_angle if found.angular else None,
        "allowed_distance": found.allowed_distance if found.linear else None,
        "allowed_angle": found.allowed_angle if found.angular else None,
        "way": found.way,
        "turn": found.turn,
        "gave_way": found.gave_way,
        "why": found.why and vars(found.why),
        "largest_distance": vars(found.distance) if found.linear else None,
        "largest_angle": vars(found.angle) if found.angular else None,
        "largest_distance_from_path": found.beside if found.linear else None,
        "largest_task_error": vars(found.task_error),
        "largest_rate": {
            "joint": found.rate_joint,
            "rate": found.rate_value,
            "of_limit": found.rate and found.rate.value,
            "time": found.rate and found.rate.time,
        },
        "unnoticed": [vars(late) for late in found.unnoticed],
        "faults": [_fault(scenario, fault) for fault in scenario.faults],
        "statuses": found.statuses,
        "held": found.held,
        "held_longest": longest and dict(zip(("joint", "bound", "time"), longest, strict=True)),
        "singular_values_at_end": found.singular_values,
        "lost_directions_at_end": found.lost,
    }


def _fault(scenario: Scenario, fault: Fault) -> dict[str, Any]:
    joint = scenario.arm.joint_names[scenario.arm.joint_index(fault.joint)]
    return {
        "joint": joint,
        "kind": fault.kind.word,
        **vars(fault.kind),
        "at": fault.at,
        "until": fault.until,
        "known_after": fault.known_after,
    }


def print_summary(found: Summary) -> None:
    """The table for people."""
    from stillreach.cli._terminal import console
    from stillreach.cli._terminal import facts as table
    from stillreach.simulation.account import account

    out, of = console(), found.run.scenario
    out.print(of.title, style="bold")
    out.print(f"{of.arm.name}, {type(of.law).__name__}, {len(found.run)} ticks of {1000 * of.period:g} ms\n")
    if description := _first_paragraph(of.description):
        out.print(f"{description}\n")
    out.print(table(account(found)))


def _first_paragraph(text: str) -> str:
    """The text in one line; the console wraps it."""
    return " ".join(text.strip().partition("\n\n")[0].split())
