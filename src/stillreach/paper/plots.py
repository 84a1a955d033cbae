"""What the paper's figures show over time: black lines told apart by their dashes, in inches and degrees."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach._rotations import pitch_yaw_roll
from stillreach.paper.examples import INCH
from stillreach.simulation import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DASHES: tuple[Any, ...] = (
    "-",
    (0, (6, 2)),
    (0, (6, 1.8, 1.2, 1.8)),
    (0, (1.2, 1.6)),
    (0, (11, 2.5)),
    (0, (6, 1.6, 1.2, 1.6, 1.2, 1.6)),
)
"""Solid, dashed, dash-dot, dotted, long dashes, dash-dot-dot."""
SHADES = ("black", "0.62", "0.35", "0.8")
"""Of lines that may flicker, where dashes do not show."""


def line(place: int) -> dict[str, Any]:
    """Style of the line at a place in its panel."""
    return {"color": "black" if place < len(DASHES) else "0.55", "linestyle": DASHES[place % len(DASHES)]}


def shade(place: int) -> dict[str, Any]:
    """Style of the line of a run at a place among several."""
    return {"color": SHADES[place % len(SHADES)], "linewidth": 1.1}


def angles(run: Run, ax: Axes, joints: Sequence[int]) -> None:
    """Angles of some joints over time [deg]."""
    _lines(ax, run, np.rad2deg(run.q[:, joints]), [run.joint_names[j] for j in joints], DASHES)
    ax.set_ylabel("joint angle [deg]")


def rates(run: Run, ax: Axes, joints: Sequence[int], *, limit: float | None = None) -> None:
    """Rates of some joints over time [deg/s], with lines at plus and minus a limit [deg/s]."""
    _lines(ax, run, np.rad2deg(run.rates[:, joints]), [run.joint_names[j] for j in joints], DASHES)
    for value in () if limit is None else (-limit, limit):
        ax.axhline(value, color="0.6", linewidth=0.8, zorder=0.5)
    ax.set_ylabel("joint rate [deg/s]")


def position(run: Run, ax: Axes) -> None:
    """Position of the tool over time [in]."""
    _lines(ax, run, run.pose[:, :3, 3] / INCH, ("x", "y", "z"), ("-", "--", ":"))
    ax.set_ylabel("tool position [in]")


def attitude(run: Run, ax: Axes) -> None:
    """Attitude of the tool over time: pitch, yaw, roll [deg] with R = R_y(pitch) R_z(yaw) R_x(roll)."""
    _lines(ax, run, attitude_degrees(run), ("pitch", "yaw", "roll"), ("-", "--", ":"))
    ax.set_ylabel("attitude [deg]")


def attitude_degrees(run: Run) -> np.ndarray:
    """Pitch, yaw and roll (T, 3) [deg], without jumps by a full turn."""
    return np.rad2deg(np.unwrap(pitch_yaw_roll(run.pose), axis=0))


def damping(runs: Sequence[Run], ax: Axes, *, names: Sequence[str] = ("",), log: bool = False) -> None:
    """Damping factor over time, of one or several runs; on a logarithmic axis zero is not drawn."""
    for place, run in enumerate(runs):
        shown = np.where(run.damping > 0, run.damping, np.nan) if log else run.damping
        ax.plot(run.time, shown, label=names[place], **shade(place))
    if log:
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")  # the default one writes formulas, which are off
    else:
        ax.set_ylim(0.0, ax.get_ylim()[1])
    ax.set_ylabel("damping factor κ")
    _finish(ax)


def largest_rate(runs: Sequence[Run], ax: Axes, *, names: Sequence[str], limit: float) -> None:
    """Largest joint rate over time [deg/s] of several runs, with the limit [deg/s]."""
    for place, run in enumerate(runs):
        ax.plot(run.time, np.rad2deg(np.max(np.abs(run.rates), axis=1)), label=names[place], **shade(place))
    ax.axhline(limit, color="0.6", linewidth=0.8, zorder=0.5)
    ax.set_ylabel("largest rate [deg/s]")
    _finish(ax)


def legend(ax: Axes) -> None:
    """The legend beside the panel, where it hides no line."""
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.03), borderaxespad=0.3)


def _lines(ax: Axes, run: Run, columns: np.ndarray, names: Sequence[str], dashes: Sequence[Any]) -> None:
    for place, name in enumerate(names):
        ax.plot(run.time, columns[:, place], label=name, color="black", linestyle=dashes[place])
    _finish(ax)
    legend(ax)


def _finish(ax: Axes) -> None:
    """The time axis."""
    spec = ax.get_subplotspec()
    if spec is None or spec.is_last_row():
        ax.set_xlabel("time [s]")
    ax.margins(x=0.0)
    ax.locator_params(axis="x", nbins=10, steps=[1, 2, 5, 10])
