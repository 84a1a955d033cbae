"""Panels of the paper's figures: a picture's name and caption, and how tool, angles and rates of a run are drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stillreach.paper import plots
from stillreach.paper.evidence import Evidence
from stillreach.paper.examples import INCH, RATE_LIMIT
from stillreach.simulation import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ROLLS, PITCHES = range(0, 11, 2), range(1, 11, 2)
STILL = 1.0
"""A panel of angles or rates reaches at least from minus to plus this [deg, deg/s]: rounding errors do not fill it."""

PANEL_HEIGHT = 2.3


@dataclass(frozen=True)
class Picture:
    """A figure of the report: its file, its caption and what draws it."""

    file: str
    caption: str
    draw: Callable[[Evidence], Figure]


def panels(
    rows: int, columns: int = 1, *, right: float = 0.95, sharey: bool = False
) -> tuple[Figure, list[list[Axes]]]:
    """A figure and its axes, column by column, with room of ``right`` inches for the legend beside each column.

    ``sharey``: each row has one vertical axis.
    """
    from matplotlib.figure import Figure

    width, height = columns * (5.9 + right), PANEL_HEIGHT * rows + 0.3
    figure = Figure(figsize=(width, height))
    # fixed margins: laying out by measuring takes twice the time
    figure.subplots_adjust(
        left=0.8 / width,
        right=1.0 - right / width,
        top=1.0 - 0.28 / height,
        bottom=0.48 / height,
        hspace=0.5 / PANEL_HEIGHT,
        wspace=(right + 0.8) / 5.1,
    )
    axes = figure.subplots(rows, columns, sharex=True, sharey="row" if sharey else False, squeeze=False)
    return figure, [list(column) for column in axes.T]


def tool(run: Run, place: Axes, turn: Axes, *, like: Sequence[Run]) -> None:
    """Position and attitude of the tool, on the axes that all runs of ``like`` fit into."""
    plots.position(run, place)
    plots.attitude(run, turn)
    place.set_ylim(_limits([other.pose[:, :3, 3] / INCH for other in like]))
    turn.set_ylim(_limits([plots.attitude_degrees(other) for other in like]))


def angles(run: Run, axes: Sequence[Axes]) -> None:
    """Joint angles, pitch joints in the first panel and roll joints in the second."""
    for ax, (kind, joints) in zip(axes, _kinds(), strict=True):
        plots.angles(run, ax, joints)
        ax.set_title(kind)
        _no_narrower(ax)


def rates(run: Run, axes: Sequence[Axes], *, limited: bool = False) -> None:
    """Joint rates likewise; ``limited`` draws the rate limit."""
    for ax, (kind, joints) in zip(axes, _kinds(), strict=True):
        plots.rates(run, ax, joints, limit=RATE_LIMIT if limited else None)
        still = np.max(np.abs(run.rates[:, joints])) < 1e-5
        ax.set_title(f"{kind} (at rest)" if still else kind)
        _no_narrower(ax)


def _kinds() -> tuple[tuple[str, range], ...]:
    return ("pitch joints", PITCHES), ("roll joints", ROLLS)


def _limits(curves: Sequence[np.ndarray]) -> tuple[float, float]:
    """Lower and upper end of an axis that all curves fit into."""
    low = min(float(np.min(values)) for values in curves)
    high = max(float(np.max(values)) for values in curves)
    margin = 0.06 * (high - low)
    return low - margin, high + margin


def _no_narrower(ax: Axes) -> None:
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, -STILL), max(high, STILL))
