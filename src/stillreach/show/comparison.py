"""A figure of several runs of one scenario: path, deviation and rates for each law."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm.shapes import stations
from stillreach.show import arm3d
from stillreach.show.moments import label_rows, mark, moments
from stillreach.show.outcome import LEAST_DEG, LEAST_MM, LINES, aside, ends_off
from stillreach.show.scene import commanded_path, drawn_ticks, fit
from stillreach.show.style import TITLE_LETTERS, in_picture, new_figure, styled
from stillreach.simulation.commanded import Commanded, commanded_in, deviation
from stillreach.simulation.comparison import Comparison
from stillreach.simulation.held import rate_shares
from stillreach.simulation.summary import Summary

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OUTLIER = 4.0
"""A run whose peak exceeds the next one by this factor does not set the scale of a panel."""
ASTRAY = 3.0
"""The same factor for the scene."""

Curve = tuple[FloatArray, FloatArray]
"""Times [s] and values."""


def comparison(results: Comparison) -> Figure:
    """The figure of several runs.

    Args:
        results: one or more runs.

    Raises:
        MissingExtraError: if matplotlib is not installed.
    """
    with styled("a picture of several runs"):
        scenario = results.scenario
        goal = max((commanded_in(run) for run in results.values()), key=lambda goal: len(goal.ticks))
        end = max(float(run.time[-1]) for run in results.values())
        changes = moments(scenario, end)
        panels = _panels(results)
        figure = new_figure(13.0, 7.2)
        _scene(figure.add_axes((-0.06, 0.0, 0.50, 0.86), projection="3d"), results, goal)
        grid = figure.add_gridspec(
            len(panels), 1, left=0.50, right=0.975, top=0.84 - 0.018 * label_rows(changes, end), bottom=0.07, hspace=0.2
        )
        axes: list[Axes] = []
        for place, (name, curves, least) in enumerate(panels):
            ax = figure.add_subplot(grid[place], sharex=axes[0] if axes else None)
            axes.append(ax)
            ax.set_xlim(0.0, max(end, scenario.period))
            _panel(ax, results, name, curves, least)
            mark(ax, changes, label=place == 0)
            ax.tick_params(labelbottom=place == len(panels) - 1)
        axes[-1].set_xlabel("time [s]")
        title = scenario.name or f"{scenario.arm.name} under {len(results)} laws"
        figure.text(0.02, 0.965, in_picture(title, TITLE_LETTERS // 2), fontsize=13, fontweight="bold", va="center")
        ticks = f"{in_picture(scenario.arm.name)}, {1000 * scenario.period:g} ms a tick"
        figure.text(0.02, 0.93, ticks, fontsize=9.5, va="center")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="upper left", bbox_to_anchor=(0.49, 1.0))
    return figure


def _panels(results: Comparison) -> list[tuple[str, list[Curve], float]]:
    """Name, curves and least height of each panel."""
    distances, angles, shares, largest = [], [], [], []
    for run in results.values():
        ticks = drawn_ticks(run)
        distance, angle = (off[ticks] for off in deviation(run))
        distances.append((run.time[ticks], 1000 * distance))
        angles.append((run.time[ticks], np.rad2deg(angle)))
        shares.append((run.time[ticks], 100 * np.max(rate_shares(run), axis=1)[ticks]))
        largest.append((run.time[ticks], np.rad2deg(np.max(np.abs(run.rates), axis=1))[ticks]))
    panels = []
    found = next(iter(results.summaries.values()))
    if found.linear:
        panels.append(("off target [mm]", distances, LEAST_MM))
    if found.angular:
        panels.append(("off target [deg]", angles, LEAST_DEG))
    if any(np.any(share) for _, share in shares):
        panels.append(("largest rate [% of its limit]", shares, 105.0))
    else:
        panels.append(("largest rate [deg/s]", largest, LEAST_DEG))
    return panels


def _panel(ax: Axes, results: Comparison, name: str, curves: list[Curve], least: float) -> None:
    top = _top([float(np.max(curve)) for _, curve in curves], least)
    unit = name[name.index("[") + 1 : -1]
    cut = []
    for place, (law, found) in enumerate(results.summaries.items()):
        time, curve = curves[place]
        ax.plot(time, curve, label=f"{law}: {_verdict(found)}", **_line(place))
        if np.max(curve) > top:
            cut.append(f"{law} reaches {np.max(curve):,.0f} {unit}")
    if "limit" in name:
        ax.axhline(100, color="0.6", linewidth=0.8, zorder=0.5)
    ax.set(ylabel=name, ylim=(0.0, top))
    if cut:
        aside(ax, "\n".join(cut))


def _top(peaks: list[float], least: float, outlier: float = OUTLIER) -> float:
    """Upper end of a panel: the highest peak, or the second if the first is far above it."""
    ordered = sorted((max(peak, least / outlier) for peak in peaks), reverse=True)
    alone = len(ordered) > 1 and ordered[0] > outlier * ordered[1]
    return max(1.08 * ordered[int(alone)], least)


def _verdict(found: Summary) -> str:
    if found.run.interrupted:
        return f"interrupted at {found.end:g} s"
    if found.finished:
        return "arrived"
    return f"ends {ends_off(found)} off"


def _scene(ax: Any, results: Comparison, goal: Commanded) -> None:
    """The arm at the start, the commanded path, and the tool's under each law."""
    arm, q = results.scenario.arm, results.scenario.start
    arm3d.draw(ax, arm, q, labels=False, alpha=0.35)
    points, _ = stations(arm, q)
    commanded_path(ax, goal)
    arm_and_goal = np.concatenate([points, goal.poses[:, :3, 3]])
    paths = [one.pose[drawn_ticks(one), :3, 3] for one in results.values()]
    reach = _top([float(np.max(np.linalg.norm(path - goal.poses[-1, :3, 3], axis=1))) for path in paths], 0.0, ASTRAY)
    near = [path for path in paths if np.max(np.linalg.norm(path - goal.poses[-1, :3, 3], axis=1)) <= reach]
    fit(ax, np.concatenate([arm_and_goal, *near]))
    for place, path in enumerate(paths):
        _path_inside(ax, path, place)


def _path_inside(ax: Any, path: FloatArray, place: int) -> None:
    """The part of a path inside the axes, which do not clip, and its end."""
    box = np.array([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()])
    inside = np.all((path >= box[:, 0]) & (path <= box[:, 1]), axis=1)
    arm3d.path(ax, np.where(inside[:, None], path, np.nan), **_line(place))
    if inside[-1]:
        ax.plot(*path[-1], "o", color=LINES[place % len(LINES)], markersize=4)


def _line(place: int) -> dict[str, Any]:
    """Style of a law's lines: earlier ones are wider, so that equal lines stay visible."""
    dashes = "-" if place < len(LINES) else (0, (4, 1.6))
    return {"color": LINES[place % len(LINES)], "linestyle": dashes, "linewidth": max(3.0 - 0.6 * place, 1.2)}
