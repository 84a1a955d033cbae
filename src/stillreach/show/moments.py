"""Marks of faults and restorations in the panels of a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stillreach.show.style import HEALTH_COLOURS, in_picture
from stillreach.simulation import Scenario
from stillreach.simulation.account import fault_groups, held_faults
from stillreach.status import Health

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RECOVERY = "#2f7d4f"
ROWS = 3
"""Number of rows for labels that would overlap."""
LETTER = 0.0125
"""Width of a letter, relative to a panel's."""


@dataclass(frozen=True)
class Moment:
    """A change of faults: time [s], words, colour, whether it is a restoration."""

    time: float
    text: str
    colour: str = HEALTH_COLOURS[Health.LOCKED]
    better: bool = False


def moments(scenario: Scenario, end: float) -> list[Moment]:
    """The changes up to a time [s], in order; changes at the same time are one moment."""
    failing: dict[float, list[tuple[str, str]]] = {}
    working: dict[float, list[str]] = {}
    names = [in_picture(name) for name in scenario.arm.joint_names]
    for text, fault in fault_groups(scenario, names):
        if fault.at <= end:
            failing.setdefault(fault.at, []).append((text, HEALTH_COLOURS[fault.kind.health]))
    for fault, works in held_faults(scenario):
        if works and fault.until is not None and fault.until <= end:
            working.setdefault(fault.until, []).append(names[scenario.arm.joint_index(fault.joint)])
    # several kinds at one time share the colour of the first
    found = [Moment(time, ", ".join(text for text, _ in faults), faults[0][1]) for time, faults in failing.items()]
    for time, these in working.items():
        found.append(
            Moment(time, f"{', '.join(these)} work{'s' if len(these) == 1 else ''} again", RECOVERY, better=True)
        )
    return sorted(found, key=lambda moment: moment.time)


def mark(ax: Axes, changes: Sequence[Moment], *, label: bool = False) -> None:
    """Lines at moments in a panel over time; with ``label`` the words above it, in rows if they are close."""
    low, high = ax.get_xlim()
    for change, (left, row) in zip(changes, _places(changes, low, high), strict=True):
        ax.axvline(change.time, color=change.colour, linewidth=0.9, linestyle=(0, (4, 2)), zorder=1.5)
        if label:
            ax.annotate(
                change.text,
                (left, 1.0),
                (0, 4 + 11 * row),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                color=change.colour,
                fontsize=8.5,
            )


def label_rows(changes: Sequence[Moment], end: float) -> int:
    """Number of label rows above a panel that ends at a time [s]."""
    return 1 + max((row for _, row in _places(changes, 0.0, float(end))), default=-1)


def _places(changes: Sequence[Moment], low: float, high: float) -> list[tuple[float, int]]:
    """Left end [s] and row of each label, without overlaps as long as rows are free."""
    free_from = [-math.inf] * ROWS
    found = []
    for change in changes:
        width = LETTER * (high - low) * len(change.text)
        left = max(min(change.time - width / 2, high - width), low)
        row = next((k for k in range(ROWS) if left >= free_from[k]), ROWS - 1)
        free_from[row] = left + width + LETTER * (high - low)
        found.append((left, row))
    return found
