"""Figures 1 to 12 of the paper, and two more, from the saved runs.

Which figure shows what is known for 1, 4, 5 and 11; the rest of the order is inferred (see ``notes``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

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
            picture.draw(evidence).savefig(out / picture.file)


def _panels(rows: int, height: float = 2.3) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.8, height * rows + 0.3), layout="constrained")
    return figure, list(np.atleast_1d(figure.subplots(rows, 1, sharex=True)))


def _arms(of: Evidence) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.6))
    starts = ((examples.EXAMPLE_1_FREE, "Example 1"), (examples.EXAMPLE_2_FREE, "Example 2"))
    for place, (name, title) in enumerate(starts):
        ax = figure.add_axes((0.50 * place - 0.01, 0.02, 0.50, 0.94), projection="3d")
        arm3d.draw(ax, of.arm, of[name].q[0], look=PRINT)
        ax.view_init(elev=20, azim=-60)
        ax.set(xlabel="x [in]", ylabel="y [in]", zlabel="z [in]")
        ax.text2D(0.06, 0.95, title, transform=ax.transAxes)
    return figure


def _angles(name: str) -> Callable[[Evidence], Figure]:
    def draw(of: Evidence) -> Figure:
        figure, axes = _panels(2)
        for ax, joints, kind in zip(axes, (PITCHES, ROLLS), ("pitch joints", "roll joints"), strict=True):
            plots.angles(of[name], ax, joints=joints, look=PRINT)
            ax.set_title(kind)
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
    """Keep a panel of rates readable: no further than ``shown``, and say what lies beyond; no narrower than 1 deg/s."""
    peak = float(np.rad2deg(np.max(np.abs(run.rates[:, joints]))))
    if shown is not None and peak > shown:
        ax.set_ylim(-shown, shown)
        ax.set_title(f"{ax.get_title(loc='left')} (peaks reach {peak:.0f} deg/s)")
    elif peak < 0.5:
        ax.set_ylim(-1, 1)
        ax.set_title(f"{ax.get_title(loc='left')} (at rest)" if peak < 1e-6 else ax.get_title(loc="left"))


def _tool(name: str) -> Callable[[Evidence], Figure]:
    def draw(of: Evidence) -> Figure:
        figure, (place, turn) = _panels(2)
        run = of[name]
        plots.position(run, place, relative=True, look=PRINT)
        commanded = measure.commanded_displacement(run)[0]
        place.plot(run.time[[0, -1]], [0, commanded], color="0.6", linewidth=0.9, zorder=0.5, label="x commanded")
        plots.legend(place)
        plots.attitude(run, turn, relative=True, look=PRINT)
        for ax, least in ((place, 10.0), (turn, 2.0)):
            low, high = ax.get_ylim()
            ax.set_ylim(min(low, -least), max(high, least))
        return figure

    return draw


def _damping(of: Evidence) -> Figure:
    figure, (kappa, rate, error) = _panels(3)
    runs = [of[examples.EXAMPLE_2_CLOSED_FORM], of[examples.EXAMPLE_2_EXACT]]
    names = ["closed form, eq. (16)", "exact, eq. (10)"]
    plots.damping(runs, kappa, names=names, log=True, look=PRINT)
    plots.largest_rate(runs, rate, names=names, limit=RATE_LIMIT, look=PRINT)
    plots.task_error(runs, error, names=names, look=PRINT)
    for ax in (kappa, rate, error):
        ax.get_legend().remove()
    figure.legend(*kappa.get_legend_handles_labels(), loc="outside upper left", ncols=2)
    return figure


def _paths(of: Evidence) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 3.9), layout="constrained")
    ax = figure.subplots()
    shown = {
        "free": examples.EXAMPLE_2_FREE,
        "pseudoinverse": examples.EXAMPLE_2_PSEUDOINVERSE,
        "closed form": examples.EXAMPLE_2_CLOSED_FORM,
        "exact": examples.EXAMPLE_2_EXACT,
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
    Picture("figure-04.png", "Figure 4. Example 1, joint angles, joints 1, 6, 7 failed.", _angles(examples.EXAMPLE_1_FAILED)),
    Picture("figure-05.png", "Figure 5. Example 1, joint rates, joints 1, 6, 7 failed.", _rates(examples.EXAMPLE_1_FAILED)),
    Picture("figure-06.png", "Figure 6. Example 2, joint angles, all joints free.", _angles(examples.EXAMPLE_2_FREE)),
    Picture("figure-07.png", "Figure 7. Example 2, joint rates, all joints free.", _rates(examples.EXAMPLE_2_FREE)),
    Picture(
        "figure-08.png",
        "Figure 8. Example 2, joint rates of the pseudoinverse, joints 2, 4, 7 failed; grey: the limit of 50 deg/s.",
        _rates(examples.EXAMPLE_2_PSEUDOINVERSE, PSEUDOINVERSE_SHOWN),
    ),
    Picture(
        "figure-09.png",
        "Figure 9. Example 2, motion of the tool under the pseudoinverse, joints 2, 4, 7 failed.",
        _tool(examples.EXAMPLE_2_PSEUDOINVERSE),
    ),
    Picture(
        "figure-10.png",
        "Figure 10. Example 2, joint rates of the singularity-robust law, joints 2, 4, 7 failed; grey: the limit of 50 deg/s.",
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
        "Closed-form and exact damping in example 2, joints 2, 4, 7 failed: damping factor, largest rate, task error.",
        _damping,
    ),
    Picture("figure-paths.png", "Paths of the tool in example 2, seen from the side; a dot where each ends.", _paths),
)
"""The paper's figures in order, then the ones beside them."""
