"""When faults begin and end, in ticks."""

from __future__ import annotations

from typing import Any

from stillreach.simulation.scenario import Scenario

Change = tuple[int, Any]
"""A joint (index) and its new fault, or None where it is restored."""


def fault_changes(scenario: Scenario) -> dict[int, list[Change]]:
    """What changes at which tick.

    Faults may overlap on one joint: the one that began last holds, and when it ends, the one before it holds again.

    Args:
        scenario: whose faults.

    Returns:
        For each tick at which something changes, the changes in the joints' order.
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
        now = None
        for tick in sorted({tick for span in own for tick in (span[0], span[2])}):
            active = [span for span in own if span[0] <= tick < span[2]]
            then = active[-1][4] if active else None
            if tick <= last and then != now:
                changes.setdefault(tick, []).append((joint, then))
            now = then
    return changes
