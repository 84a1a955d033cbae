"""The states of joints as bars over time."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from stillreach.faults import FAULTS, Loses
from stillreach.show.style import HEALTH_COLOURS, in_picture
from stillreach.simulation import Run
from stillreach.simulation.held import bound_reasons
from stillreach.status import IN_WORDS, Health, Status

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STATES = {
    **{kind.word: HEALTH_COLOURS[kind.health] for kind in FAULTS},
    "at velocity limit": "#1b4f8a",
    "at position limit": "#5f8fc4",
    "at acceleration limit": "#b9cfe6",
}
"""The states of a joint and their colours."""

UNKNOWN, HATCH = "unknown to controller", "////"

FLAGS = (
    Status.SINGULAR,
    Status.DAMPED,
    Status.SCALED,
    Status.OVER_LIMIT,
    Status.NO_WORKING_JOINT,
    Status.FAULT_NOT_COMPENSATED,
    Status.LIMIT_GIVEN_UP,
    Status.ITERATION_LIMIT,
)
FLAG_COLOUR = "#6d6d6d"
BAR = 0.72
NAMED = 16
"""With more bars, only the first and last joint, failed joints and status flags are named."""

TOGETHER = 3
"""Largest number of names for adjacent bars; of more, only the first and last."""


def timeline(ax: Axes, run: Run, ticks: np.ndarray) -> None:
    """A bar for each joint and, below, for each status flag that was raised.

    Args:
        ax: the axes.
        run: the run.
        ticks: (K,) the ticks to draw, evenly spaced.
    """
    from matplotlib.patches import Patch

    codes, time = _joint_codes(run)[:, ticks], run.time[ticks]
    flags = _raised(run)
    names = [*map(in_picture, run.joint_names), *(IN_WORDS[flag] for flag in flags)]
    used: set[str] = set()
    for row, name in enumerate(run.joint_names):
        for layer, height in zip(codes, (BAR, BAR / 2 if codes[0, :, row].any() else BAR), strict=True):
            for code, (state, colour) in enumerate(STATES.items(), start=1):
                spans = _spans(time, layer[:, row] == code)
                if spans:
                    used.add(state)
                    ax.broken_barh(spans, (row - height / 2, height), facecolors=colour, linewidth=0, label=name)
        unknown = _spans(time, (run.health != run.known)[ticks, row])
        if unknown:
            used.add(UNKNOWN)
            ax.broken_barh(
                unknown, (row - BAR / 2, BAR), facecolors="none", edgecolors="black", linewidth=0, hatch=HATCH
            )
    for row, flag in enumerate(flags, start=len(run.joint_names)):
        spans = _spans(time, (run.status[ticks] & flag.value) != 0)
        ax.broken_barh(spans, (row - BAR / 2, BAR), facecolors=FLAG_COLOUR, linewidth=0)
    if flags:
        ax.axhline(len(run.joint_names) - 0.5, color="0.6", linewidth=0.8)
    failed = np.flatnonzero(np.any(run.health != Health.HEALTHY, axis=0))
    _label(ax, names, {0, *failed.tolist(), *range(len(run.joint_names) - 1, len(names))})
    patches = [Patch(color=STATES[state], label=state) for state in STATES if state in used]
    patches += [Patch(facecolor="none", edgecolor="black", linewidth=0, hatch=HATCH, label=UNKNOWN)] * (UNKNOWN in used)
    if patches:
        ax.legend(handles=patches, loc="upper left", bbox_to_anchor=(1.02, 1.03), borderaxespad=0.0, handlelength=1.2)


def unknown(ax: Axes, run: Run, ticks: np.ndarray) -> None:
    """Shades the times at which the controller took a joint for what it is not."""
    for begin, length in _spans(run.time[ticks], np.any(run.health != run.known, axis=1)[ticks]):
        ax.axvspan(begin, begin + length, facecolor="0.9", edgecolor="0.6", linewidth=0, hatch=HATCH, zorder=0)


def timeline_rows(run: Run) -> int:
    """Number of bars."""
    return len(run.joint_names) + len(_raised(run))


def _joint_codes(run: Run) -> np.ndarray:
    """(2, T, n) faults, and limits that joints are at, drawn thinner beside a fault: 0, or 1 + index in STATES."""
    reasons, faults = bound_reasons(run), np.zeros(run.health.shape, dtype=np.int64)
    limits = np.where(reasons > 0, reasons + len(FAULTS), 0)
    for code, kind in enumerate(FAULTS, start=1):
        faults[run.health == kind.health] = code
        if kind.loses is Loses.CHOICE:
            limits[run.health == kind.health] = 0
    return np.stack([faults, limits])


def _raised(run: Run) -> list[Status]:
    return [flag for flag in FLAGS if np.any(run.status & flag.value)]


def _spans(time: np.ndarray, true: np.ndarray) -> list[tuple[float, float]]:
    """Start and length [s] of each range of true ticks; a tick lasts until the next one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], true.astype(np.int8), [0]])))
    until = np.append(time, time[-1])
    return [(float(time[first]), float(until[end] - time[first])) for first, end in edges.reshape(-1, 2)]


def _apart(rows: list[int], room: float) -> list[list[int]]:
    """Groups of rows that are too close for separate names."""
    groups = [rows[:1]]
    for row in rows[1:]:
        if row - groups[-1][-1] < room:
            groups[-1].append(row)
        else:
            groups.append([row])
    return groups


def _together(names: list[str]) -> str:
    return ", ".join(names) if len(names) <= TOGETHER else f"{names[0]} … {names[-1]}"


def _label(ax: Axes, names: list[str], marked: Collection[int]) -> None:
    """Names at the bars; of many, only the marked ones."""
    ax.set_ylim(len(names) - 0.4, -0.6)
    rows = [[row] for row in range(len(names))] if len(names) <= NAMED else _apart(sorted(marked), len(names) / NAMED)
    ax.set_yticks([sum(near) / len(near) for near in rows], [_together([names[k] for k in near]) for near in rows])
    ax.tick_params(axis="y", labelsize=8.0)
    ax.tick_params(axis="y", length=0)
    ax.grid(visible=False, axis="y")
    ax.set_axisbelow(True)
