"""Figures beside the paper's: its pairs side by side, both ways of damping, and where stillreach goes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach.paper import examples, measure, panels, plots
from stillreach.paper.evidence import Evidence
from stillreach.paper.examples import INCH, RATE_LIMIT
from stillreach.paper.panels import Picture
from stillreach.show import arm3d
from stillreach.simulation import Run

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def _side_by_side(names: dict[str, str]) -> Callable[[Evidence], Figure]:
    """Position and attitude of two runs on the same axes, each column with its title."""

    def draw(of: Evidence) -> Figure:
        figure, columns = panels.panels(2, 2, sharey=True)
        runs = [of[name] for name in names.values()]
        for (place, turn), title, run in zip(columns, names, runs, strict=True):
            panels.tool(run, place, turn, like=runs)
            place.set_title(title)
        return figure

    return draw


def _rates_below(most: float) -> Callable[[Evidence], Figure]:
    """Figure 9 up to a rate [deg/s]."""

    def draw(of: Evidence) -> Figure:
        figure, (axes,) = panels.panels(2)
        panels.rates(of[examples.EXAMPLE_2_PSEUDOINVERSE], axes)
        axes[0].set_ylim(-most, most)
        return figure

    return draw


def _compared(of: Evidence, names: dict[str, str]) -> Figure:
    """Damping factor, largest rate and distance from the commanded pose of several runs over time."""
    figure, ((kappa, rate, away),) = panels.panels(3, right=0.25)
    runs = [of[name] for name in names.values()]
    plots.damping(runs, kappa, names=list(names), log=True)
    plots.largest_rate(runs, rate, names=list(names), limit=RATE_LIMIT)
    for place, run in enumerate(runs):
        away.plot(run.time, measure.off_target(run)[0], **plots.shade(place))
    away.set(xlabel="time [s]", ylabel="off the commanded pose [in]")
    for ax in (kappa, rate):
        ax.legend().remove()
    figure.subplots_adjust(right=0.97, top=0.94)
    figure.legend(*rate.get_legend_handles_labels(), loc="upper left", bbox_to_anchor=(0.1, 1.0), ncols=len(names))
    return figure


def _damping(of: Evidence) -> Figure:
    names = {"closed form, eq. (16)": examples.EXAMPLE_2_CLOSED_FORM, "exact, eq. (10)": examples.EXAMPLE_2_EXACT}
    return _compared(of, names)


def _stillreach(of: Evidence) -> Figure:
    """The arm where each law leaves it, and how far it then is from where it should be."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.4, 4.7))
    shown = (
        (examples.EXAMPLE_2_CLOSED_FORM, "singularity-robust, 1994"),
        (examples.EXAMPLE_2_STILLREACH, "stillreach"),
    )
    for place, (name, title) in enumerate(shown):
        ax: Any = figure.add_axes((0.335 * place, 0.02, 0.34, 0.90), projection="3d", computed_zorder=False)
        _reached(ax, of[name])
        done = -measure.displacement(of[name])[0]
        ax.text2D(0.5, 1.0, f"{title}: {done:.0f} of 100 in", transform=ax.transAxes, ha="center", fontsize=10)
    away, rate = (figure.add_axes((0.73, bottom, 0.25, 0.36)) for bottom in (0.57, 0.11))
    for place, (name, title) in enumerate(shown):
        line: dict[str, Any] = {"color": ("0.45", "#1b4f8a")[place], "label": title, "linewidth": 1.6}
        away.plot(of[name].time, measure.off_target(of[name])[0], **line)
        rate.plot(of[name].time, np.rad2deg(np.max(np.abs(of[name].rates), axis=1)), **line)
    rate.axhline(RATE_LIMIT, color="#c72a1a", linewidth=0.8)
    away.set_title("off the commanded pose [in]")
    away.legend(loc="upper left", handlelength=1.8)
    rate.set_title("largest joint rate [deg/s]; red: limit")
    for ax in (away, rate):
        ax.set(xlim=(0.0, of[examples.EXAMPLE_2_STILLREACH].time[-1]), xlabel="time [s]")
    away.set_xlabel("")
    return figure


def _reached(ax: Any, run: Run) -> None:
    """The arm at the start (pale) and at the end of a run, its path, and the line that it was told to follow."""
    failed = np.flatnonzero(run.health[-1])
    arm3d.draw(ax, run.scenario.arm, run.q[0], unit=INCH, labels=False, alpha=0.18)
    arm3d.draw(ax, run.scenario.arm, run.q[-1], unit=INCH, labels=False, failed=failed)
    start = run.pose[0, :3, 3]
    line = np.array([start, run.target[-1, :3, 3]])
    arm3d.path(ax, line, unit=INCH, color="black", linestyle=":", linewidth=1.2)
    arm3d.path(ax, run.pose[:, :3, 3], unit=INCH, color="#1b4f8a", linewidth=2.0)
    arm3d.path(ax, line[1:], unit=INCH, color="black", marker="o", markerfacecolor="none", markersize=6)
    ax.set(xlim=(-80, 70), ylim=(-50, 50), zlim=(0, 160))
    ax.set_box_aspect((150, 100, 160), zoom=1.15)
    ax.view_init(elev=14, azim=-62)
    ax.set(xticks=[], yticks=[], zticks=[])


def _paths(of: Evidence) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 3.9))
    ax = figure.add_axes((0.09, 0.13, 0.7, 0.83))
    shown = {
        "free": examples.EXAMPLE_2_FREE,
        "pseudoinverse": examples.EXAMPLE_2_PSEUDOINVERSE,
        "closed form": examples.EXAMPLE_2_CLOSED_FORM,
        "exact": examples.EXAMPLE_2_EXACT,
        "stillreach": examples.EXAMPLE_2_STILLREACH,
    }
    for place, (label, name) in enumerate(shown.items()):
        x, _, z = of[name].pose[:, :3, 3].T / INCH
        ax.plot(x, z, label=label, **plots.line(place))
        ax.plot(x[-1], z[-1], "o", color="black", markersize=3.5)
    ax.plot(x[0], z[0], "o", color="black", markerfacecolor="white", markersize=5, label="start")
    ax.set(xlabel="x [in]", ylabel="z [in]")
    ax.set_aspect("equal", adjustable="datalim")
    plots.legend(ax)
    return figure


ADDED = (
    Picture(
        "figure-02-beside-04.png",
        "Figures 2 and 4 side by side: example 1, all joints free and joints 1, 6, 7 failed.",
        _side_by_side(
            {
                "Figure 2: all joints free": examples.EXAMPLE_1_FREE,
                "Figure 4: joints 1, 6, 7 failed": examples.EXAMPLE_1_FAILED,
            }
        ),
    ),
    Picture(
        "figure-06-beside-08.png",
        "Figures 6 and 8 side by side: example 2, all joints free and joints 2, 4, 7 failed.",
        _side_by_side(
            {
                "Figure 6: all joints free": examples.EXAMPLE_2_FREE,
                "Figure 8: joints 2, 4, 7 failed": examples.EXAMPLE_2_PSEUDOINVERSE,
            }
        ),
    ),
    Picture(
        "figure-09-below-450.png",
        "Figure 9 up to 450 deg/s; the paper's rates reach 400 deg/s.",
        _rates_below(450.0),
    ),
    Picture("figure-damping.png", "Closed-form and exact damping in example 2, joints 2, 4, 7 failed.", _damping),
    Picture(
        "figure-stillreach.png",
        "Example 2, joints 2, 4, 7 failed (red): where the paper's law leaves the arm, and where stillreach does.",
        _stillreach,
    ),
    Picture("figure-paths.png", "Paths of the tool in example 2, seen from the side; a dot where each ends.", _paths),
)
"""What the paper does not have."""
