"""A figure of a run: arm and path, deviation, rates, joints and limits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stillreach._door import FloatArray
from stillreach.show.moments import label_rows, mark, moments
from stillreach.show.scene import drawn_ticks, scene
from stillreach.show.style import COLOURS, TITLE_LETTERS, in_picture, new_figure, styled
from stillreach.show.timeline import timeline, timeline_rows, unknown
from stillreach.simulation import Run
from stillreach.simulation.account import apart
from stillreach.simulation.commanded import commanded_in, deviation
from stillreach.simulation.held import rate_shares
from stillreach.simulation.summary import Summary
from stillreach.status import Health

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINES = ("#1b4f8a", "#c8501e", "#2f7d4f", "#8a3f8f", "#b58900", "#3b3b3b", "#4fa3c7", "#d17ba6")
FAILING = (0, (4, 1.6))
NAMED = len(LINES)
"""Number of joints with their own lines and names; the others are grey."""
WHY_LETTERS = 190
RATE_TOP = 300.0
"""Upper end of the panel of rates [% of limit]."""
LEAST_MM, LEAST_DEG = 1.0, 0.1
"""Smallest upper end of a panel of deviations, which hides rounding errors."""


def outcome(run: Run, found: Summary | None = None) -> Figure:
    """The figure of a run.

    Args:
        run: the run.
        found: its summary; None: computed.

    Raises:
        MissingExtraError: if matplotlib is not installed.
    """
    with styled("a picture of a run"):
        found = run.summary() if found is None else found
        scenario, goal = run.scenario, commanded_in(run)
        ticks = drawn_ticks(run)
        changes = moments(scenario, run.time[-1])
        rows = timeline_rows(run)
        figure = new_figure(13.0, 7.6)
        grid = figure.add_gridspec(
            4,
            1,
            height_ratios=(1.0, 1.0, 1.0, min(0.35 + 0.085 * rows, 1.9)),
            left=0.475,
            right=0.885 - 0.0058 * max(len(in_picture(name)) for name in run.joint_names),
            top=(0.885 if found.why is None else 0.865) - 0.018 * label_rows(changes, run.time[-1]),
            bottom=0.065,
            hspace=0.26,
        )
        scene(figure.add_axes((-0.06, 0.015, 0.49, 0.87), projection="3d"), run, goal)
        axes = [figure.add_subplot(grid[0])]
        axes += [figure.add_subplot(grid[k], sharex=axes[0]) for k in (1, 2, 3)]
        axes[0].set_xlim(0.0, max(float(run.time[-1]), scenario.period))
        off_target(axes[0], run, ticks, found)
        unknown(axes[0], run, ticks)
        chosen = named_joints(run)
        rates(axes[1], run, chosen, ticks)
        values(axes[2], run, chosen, ticks)
        timeline(axes[3], run, ticks)
        for k, ax in enumerate(axes):
            mark(ax, changes, label=k == 0)
            if k < 3:
                ax.tick_params(labelbottom=False)
        axes[3].set_xlabel("time [s]")
        figure.text(
            0.02,
            0.965,
            in_picture(scenario.title, TITLE_LETTERS),
            fontsize=13,
            fontweight="bold",
            va="center",
        )
        figure.text(0.02, 0.93, caption(found), fontsize=9.5, va="center")
        if found.why is not None:
            figure.text(0.02, 0.905, in_picture(found.why.sentence, WHY_LETTERS), fontsize=9.5, va="center")
    return figure


def caption(found: Summary) -> str:
    """Arm, law and result in one line."""
    of = found.run.scenario
    if found.run.interrupted:
        verdict = f"interrupted at {found.end:g} s"
    else:
        verdict = (
            f"the tool {'arrived' if found.finished else 'did not arrive'}: it ends {ends_off(found)} from its goal"
        )
    return f"{in_picture(of.arm.name)}, {type(of.law).__name__}, {1000 * of.period:g} ms a tick; {verdict}"


def ends_off(found: Summary) -> str:
    """Distance and angle of the tool from its goal at the end, in the rows of the task."""
    return apart(found, found.goal_distance, found.goal_angle, " and ")


def off_target(ax: Axes, run: Run, ticks: np.ndarray, found: Summary) -> None:
    """Distance [mm] and angle [deg] of the tool from its target, each if the task has such rows."""
    distance, angle = (off[ticks] for off in deviation(run))
    time = run.time[ticks]
    if found.linear:
        _deviation(ax, time, 1000 * distance, LEAST_MM, "off target [mm]", COLOURS[0])
    if found.angular:
        other = ax.twinx() if found.linear else ax
        _deviation(other, time, np.rad2deg(angle), LEAST_DEG, "off target [deg]", COLOURS[1])
        if found.linear:
            other.grid(visible=False)
            other.spines["right"].set_visible(True)


def _deviation(ax: Axes, time: FloatArray, off: FloatArray, least: float, name: str, colour: str) -> None:
    ax.plot(time, off, color=colour)
    ax.set_ylabel(name, color=colour)
    ax.tick_params(axis="y", labelcolor=colour)
    ax.set_ylim(0.0, max(1.06 * float(np.max(off)), least))


def named_joints(run: Run) -> list[int]:
    """The joints with their own lines: those that fail, then those nearest to their limits."""
    failed = [int(j) for j in np.flatnonzero(np.any(run.health != Health.HEALTHY, axis=0))]
    share = np.max(rate_shares(run), axis=0)
    effort = share if np.any(share) else np.max(np.abs(run.rates), axis=0)
    busiest = [int(j) for j in np.argsort(-effort, kind="stable") if j not in failed]
    return sorted((failed + busiest)[:NAMED])


def rates(ax: Axes, run: Run, chosen: Sequence[int], ticks: np.ndarray) -> None:
    """Rates as a share of their limits [%]; in [deg/s] and [mm/s] without limits."""
    limited = rate_shares(run)
    if np.any(limited):
        signed = 100 * limited * np.sign(run.rates)
        ax.axhspan(-100, 100, color="#f1f1ee", zorder=0)
        for limit in (-100, 100):
            ax.axhline(limit, color="0.6", linewidth=0.8, zorder=0.5)
        name = "rate [% of limit]"
        peak = float(np.max(np.abs(signed)))
        top = min(max(105.0, 1.06 * peak), RATE_TOP)
        ax.set_ylim(-top, top)
        if peak > top:
            aside(ax, f"reaches {peak:,.0f} %")
    else:
        signed, name = run.rates * _factors(run), f"rate [{_unit_name(run, '/s')}]"
    _joint_lines(ax, run, signed, chosen, ticks)
    ax.set_ylabel(name)
    ax.legend(loc="upper left", bbox_to_anchor=(1.06, 1.03), borderaxespad=0.0, title="joint", alignment="left")


def aside(ax: Axes, text: str) -> None:
    """A note in the upper right corner of a panel."""
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 2.0}
    ax.text(0.99, 0.95, text, transform=ax.transAxes, ha="right", va="top", fontsize=8.5, bbox=box, zorder=10)


def values(ax: Axes, run: Run, chosen: Sequence[int], ticks: np.ndarray) -> None:
    """Joint values [deg], slides [mm]."""
    _joint_lines(ax, run, run.q * _factors(run), chosen, ticks)
    ax.set_ylabel(f"joints [{_unit_name(run)}]")


def _joint_lines(ax: Axes, run: Run, columns: FloatArray, chosen: Sequence[int], ticks: np.ndarray) -> None:
    others = [j for j in range(columns.shape[1]) if j not in chosen]
    for k, j in enumerate(others):
        ax.plot(
            run.time[ticks],
            columns[ticks, j],
            color="0.75",
            linewidth=0.8,
            label=f"{len(others)} more" if k == 0 else None,
        )
    for place, j in enumerate(chosen):
        fails = bool(np.any(run.health[:, j] != Health.HEALTHY))
        name = in_picture(run.joint_names[j]) + (" fails" if fails else "")
        ax.plot(run.time[ticks], columns[ticks, j], label=name, color=LINES[place], linestyle=FAILING if fails else "-")


def _factors(run: Run) -> FloatArray:
    return np.array([1000.0 if unit == "m" else np.rad2deg(1.0) for unit in run.joint_units])


def _unit_name(run: Run, suffix: str = "") -> str:
    kinds = set(run.joint_units)
    return ", ".join(name + suffix for unit, name in (("rad", "deg"), ("m", "mm")) if unit in kinds)
