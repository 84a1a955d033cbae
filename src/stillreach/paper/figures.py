"""Figures 1 to 12 of the paper, and two more, from the saved runs.

Which figure shows what is known for 1, 4, 5 and 11; the rest of the order is inferred (see ``notes``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach.paper import examples, measure
from stillreach.paper.evidence import Evidence
from stillreach.paper.examples import RATE_LIMIT
from stillreach.show import arm3d, plots
from stillreach.show.style import PRINT, styled
from stillreach.simulate import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ROLLS, PITCHES = range(0, 11, 2), range(1, 11, 2)
STILL = 1.0
"""A panel of angles or rates reaches at least from minus to plus this [deg, deg/s]."""

PSEUDOINVERSE_SHOWN = 450.0
"""Rates of the pseudoinverse are drawn up to here [deg/s]; the paper speaks of up to 400."""


@dataclass(frozen=True)
class Picture:
    """A figure of the report: its file, its caption and what draws it."""

    file: str
    caption: str
    draw: Callable[[Evidence], Figure]


def write(evidence: Evidence, out: Path) -> None:
    """Draw every picture into a folder.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    with styled("the paper's figures"):
        for picture in PICTURES:
            picture.draw(evidence).savefig(out / picture.file, pil_kwargs={"compress_level": 2})


def _panels(rows: int, height: float = 2.3) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    size = (6.8, height * rows + 0.3)
    figure = Figure(figsize=size)
    # fixed margins: room for the legend on the right; laying out by measuring takes twice the time
    figure.subplots_adjust(left=0.11, right=0.86, top=1 - 0.28 / size[1], bottom=0.48 / size[1], hspace=0.5 / height)
    return figure, list(np.atleast_1d(figure.subplots(rows, 1, sharex=True)))


def _arms(of: Evidence) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 5.0))
    starts = ((examples.EXAMPLE_1_FREE, "Example 1"), (examples.EXAMPLE_2_FREE, "Example 2"))
    for place, (name, title) in enumerate(starts):
        ax: Any = figure.add_axes((0.50 * place - 0.01, 0.07, 0.50, 0.90), projection="3d")
        arm3d.draw(ax, of.arm, of[name].q[0], look=PRINT)
        ax.view_init(elev=20, azim=-60)
        ax.patch.set_alpha(0.0)  # hides nothing of its neighbour
        ax.set(xlabel="x [in]", ylabel="y [in]", zlabel="z [in]")
        ax.text2D(0.06, 0.95, title, transform=ax.transAxes)
    return figure


def _angles(name: str) -> Callable[[Evidence], Figure]:
    def draw(of: Evidence) -> Figure:
        figure, axes = _panels(2)
        for ax, joints, kind in zip(axes, (PITCHES, ROLLS), ("pitch joints", "roll joints"), strict=True):
            plots.angles(of[name], ax, joints=joints, look=PRINT)
            ax.set_title(kind)
            _no_narrower(ax, STILL)
        return figure

    return draw


def _rates(name: str, shown: float | None = None) -> Callable[[Evidence], Figure]:
    def draw(of: Evidence) -> Figure:
        figure, axes = _panels(2)
        limit = RATE_LIMIT if measure.largest_rate(of[name]) > 0.5 * RATE_LIMIT else None
        for ax, joints, kind in zip(axes, (PITCHES, ROLLS), ("pitch joints", "roll joints"), strict=True):
            plots.rates(of[name], ax, joints=joints, limit=limit, look=PRINT)
            ax.set_title(kind)
            _cut(ax, of[name], joints, shown)
        return figure

    return draw


def _cut(ax: Axes, run: Run, joints: range, shown: float | None) -> None:
    """Keep a panel of rates readable: no further than ``shown``, and say what lies beyond."""
    peak = float(np.rad2deg(np.max(np.abs(run.rates[:, joints]))))
    if shown is not None and peak > shown:
        ax.set_ylim(-shown, shown)
        ax.set_title(f"{ax.get_title(loc='left')} (peaks reach {peak:.0f} deg/s)")
    _no_narrower(ax, STILL)
    if peak < 1e-3:
        ax.set_title(f"{ax.get_title(loc='left')} (at rest)")


def _no_narrower(ax: Axes, least: float) -> None:
    """The vertical axis reaches from -least to +least at least, so that rounding errors do not fill the panel."""
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, -least), max(high, least))


def _tool(name: str) -> Callable[[Evidence], Figure]:
    def draw(of: Evidence) -> Figure:
        figure, (place, turn) = _panels(2)
        run = of[name]
        plots.position(run, place, relative=True, look=PRINT)
        commanded = measure.commanded_displacement(run)[0]
        place.plot(run.time[[0, -1]], [0, commanded], color="0.6", linewidth=0.9, zorder=0.5, label="x commanded")
        plots.legend(place)
        plots.attitude(run, turn, relative=True, look=PRINT)
        _no_narrower(place, 10.0)
        _no_narrower(turn, 2.0)
        figure.subplots_adjust(right=0.78)
        return figure

    return draw


def _compared(of: Evidence, names: dict[str, str]) -> Figure:
    """Damping factor, largest rate and distance from the commanded pose of several runs over time."""
    figure, (kappa, rate, away) = _panels(3)
    runs = [of[name] for name in names.values()]
    plots.damping(runs, kappa, names=list(names), log=True, look=PRINT)
    plots.largest_rate(runs, rate, names=list(names), limit=RATE_LIMIT, look=PRINT)
    for place, run in enumerate(runs):
        away.plot(run.time, measure.off_target(run)[0], **PRINT.compared(place))
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
        _reached(ax, of, of[name])
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


def _reached(ax: Any, of: Evidence, run: Run) -> None:
    """The arm at the start (pale) and at the end of a run, its path, and the line that it was told to follow."""
    failed = np.flatnonzero(run.health[-1])
    arm3d.draw(ax, of.arm, run.q[0], look=PRINT, labels=False, alpha=0.18)
    arm3d.draw(ax, of.arm, run.q[-1], look=PRINT, labels=False, failed=failed)
    start = run.pose[0, :3, 3]
    line = start + np.outer([0.0, 1.0], measure.commanded_displacement(run) * examples.INCH)
    arm3d.path(ax, line, look=PRINT, color="black", linestyle=":", linewidth=1.2)
    arm3d.path(ax, run.pose[:, :3, 3], look=PRINT, color="#1b4f8a", linewidth=2.0)
    arm3d.path(ax, line[1:], look=PRINT, color="black", marker="o", markerfacecolor="none", markersize=6)
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
        x, _, z = of[name].pose[:, :3, 3].T / examples.INCH
        ax.plot(x, z, label=label, **PRINT.line(place))
        ax.plot(x[-1], z[-1], "o", color="black", markersize=3.5)
    ax.plot(x[0], z[0], "o", color="black", markerfacecolor="white", markersize=5, label="start")
    ax.set(xlabel="x [in]", ylabel="z [in]")
    ax.set_aspect("equal", adjustable="datalim")
    plots.legend(ax)
    return figure


PICTURES = (
    Picture("figure-01.png", "Figure 1. The arm in the start positions of both examples.", _arms),
    Picture("figure-02.png", "Figure 2. Example 1, joint angles, all joints free.", _angles(examples.EXAMPLE_1_FREE)),
    Picture("figure-03.png", "Figure 3. Example 1, joint rates, all joints free.", _rates(examples.EXAMPLE_1_FREE)),
    Picture(
        "figure-04.png", "Figure 4. Example 1, joint angles, joints 1, 6, 7 failed.", _angles(examples.EXAMPLE_1_FAILED)
    ),
    Picture(
        "figure-05.png", "Figure 5. Example 1, joint rates, joints 1, 6, 7 failed.", _rates(examples.EXAMPLE_1_FAILED)
    ),
    Picture("figure-06.png", "Figure 6. Example 2, joint angles, all joints free.", _angles(examples.EXAMPLE_2_FREE)),
    Picture("figure-07.png", "Figure 7. Example 2, joint rates, all joints free.", _rates(examples.EXAMPLE_2_FREE)),
    Picture(
        "figure-08.png",
        "Figure 8. Example 2, joint rates of the pseudoinverse, joints 2, 4, 7 failed; grey: 50 deg/s.",
        _rates(examples.EXAMPLE_2_PSEUDOINVERSE, PSEUDOINVERSE_SHOWN),
    ),
    Picture(
        "figure-09.png",
        "Figure 9. Example 2, motion of the tool under the pseudoinverse, joints 2, 4, 7 failed.",
        _tool(examples.EXAMPLE_2_PSEUDOINVERSE),
    ),
    Picture(
        "figure-10.png",
        "Figure 10. Example 2, joint rates of the singularity-robust law, joints 2, 4, 7 failed; grey: 50 deg/s.",
        _rates(examples.EXAMPLE_2_CLOSED_FORM),
    ),
    Picture(
        "figure-11.png",
        "Figure 11. Example 2, joint angles under the singularity-robust law, joints 2, 4, 7 failed.",
        _angles(examples.EXAMPLE_2_CLOSED_FORM),
    ),
    Picture(
        "figure-12.png",
        "Figure 12. Example 2, motion of the tool under the singularity-robust law, joints 2, 4, 7 failed.",
        _tool(examples.EXAMPLE_2_CLOSED_FORM),
    ),
    Picture(
        "figure-damping.png",
        "Closed-form and exact damping in example 2, joints 2, 4, 7 failed.",
        _damping,
    ),
    Picture(
        "figure-stillreach.png",
        "Example 2, joints 2, 4, 7 failed (red): where the paper's law leaves the arm, and where stillreach does.",
        _stillreach,
    ),
    Picture("figure-paths.png", "Paths of the tool in example 2, seen from the side; a dot where each ends.", _paths),
)
"""The paper's figures in order, then the ones beside them."""
