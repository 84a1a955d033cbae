"""A survey as a figure: where losses can be afforded, joints by rank, how many can be lost, what is reached."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach.show.left import depth_labels
from stillreach.show.style import COLOURS, in_picture, matplotlib_or_error, new_figure, styled, wrapped
from stillreach.tolerance.surveys.arrays import CELLS, EDGES, PLANES, SPEED_EDGES, quantile

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stillreach.tolerance import Survey

PURPOSE = "a picture of a survey"
MOST_BARS = 16
"""Joints or sets of a panel."""
SEEN = ("from above", "from the side")
"""From where each plane is seen."""
PALE, STRONG = "#9db8d6", COLOURS[0]


def survey_figure(found: Survey) -> Figure:
    """A panel for each metric that the survey has, below its verdict.

    Raises:
        MissingExtraError: if matplotlib is not installed.
    """
    matplotlib_or_error(PURPOSE)
    panels: list[Any] = []
    if "relative" in found.metrics:
        maps = _maps(found)
        panels += [lambda axes, plane=plane: _map(axes, found, maps, plane) for plane in maps]
        label = "remaining relative manipulability [%]"
        panels.append(lambda axes: _ranking(axes, found, "relative", 100.0 * EDGES, label))
    if "depth" in found.metrics:
        panels.append(lambda axes: _depth(axes, found))
    if "speed" in found.metrics:
        panels.append(
            lambda axes: _ranking(axes, found, "speed_joint", SPEED_EDGES, "speed in every direction [m/s, rad/s]")
        )
    if "reach" in found.metrics:
        panels.append(lambda axes: _reach(axes, found))
    if "positions" in found.metrics:
        panels.append(lambda axes: _positions(axes, found))
    rows = -(-len(panels) // 2)
    with styled(PURPOSE):
        verdict = wrapped(f"{in_picture(found.arm.name)}: {found.verdict}", 120)
        height = 0.4 + 0.2 * len(verdict) + 3.4 * rows
        figure = new_figure(10.0, height)
        figure.text(0.02, 1.0 - 0.12 / height, "\n".join(verdict), va="top", fontsize=10.5)
        figure.subplots_adjust(
            left=0.12, right=0.93, bottom=0.55 / height, top=1.0 - (0.55 + 0.2 * len(verdict)) / height,
            wspace=0.42, hspace=0.42,
        )  # fmt: skip
        for place, panel in enumerate(panels):
            axes = figure.add_subplot(rows, 2, place + 1)
            axes.set_axisbelow(True)
            panel(axes)
    return figure


def _maps(found: Survey) -> dict[int, np.ndarray]:
    """The mean of what the worst joint leaves [%], NaN in empty cells, by plane.

    Only planes in which the tool moves along both axes; all if there is none.
    """
    counts, totals = found.total("map_count"), found.total("map_sum")
    wide = [plane for plane in range(len(PLANES)) if all(np.any(counts[plane], axis=axis).sum() > 1 for axis in (0, 1))]
    mean = np.where(counts > 0, 100.0 * totals / np.maximum(counts, 1), np.nan)
    return {plane: mean[plane] for plane in wide or range(len(PLANES))}


def _map(axes: Axes, found: Survey, maps: dict[int, np.ndarray], plane: int) -> None:
    """One plane; all have the same colours."""
    mean, every = maps[plane], np.concatenate([own[np.isfinite(own)] for own in maps.values()])
    edges = found.arm.reach * (2.0 * np.arange(CELLS + 1) / CELLS - 1.0)
    most = float(np.quantile(every, 0.98)) if len(every) else 1.0  # single configurations stand out at the rim
    image = axes.pcolormesh(edges, edges, mean, cmap="viridis", vmin=0.0, vmax=most, rasterized=True)
    across, up = PLANES[plane].split("-")
    axes.set(xlabel=f"{across} [m]", ylabel=f"{up} [m]", aspect="equal")
    used = np.argwhere(np.isfinite(mean))
    if len(used):
        (low_up, low), (high_up, high) = used.min(axis=0), used.max(axis=0) + 1
        axes.set(xlim=(edges[low], edges[high]), ylim=(edges[low_up], edges[high_up]))
    axes.set_title(f"what the worst joint leaves, {SEEN[plane]}")
    axes.grid(visible=False)
    figure = axes.get_figure()
    assert figure is not None
    bar = figure.colorbar(image, ax=axes, fraction=0.046, pad=0.03, extend="max")
    bar.set_label("relative manipulability, mean [%]")


def _ranking(axes: Axes, found: Survey, name: str, edges: np.ndarray, label: str) -> None:
    """Joints, that whose loss costs most first: medians, and the middle 90 % of the configurations."""
    order = found.ranking[:MOST_BARS]
    rows = found.total(name)
    values = np.array([[quantile(rows[joint], edges, part) for part in (0.05, 0.5, 0.95)] for joint in order])
    places = np.arange(len(order))
    axes.hlines(places, values[:, 0], values[:, 2], color=PALE, lw=5)
    axes.plot(values[:, 1], places, "o", color=STRONG, ms=5)
    axes.set_yticks(places, [in_picture(found.arm.joint_names[joint], 16) for joint in order])
    axes.set(xlabel=label, ylim=(len(order) - 0.5, -0.5))
    axes.set_xlim(left=0.0)
    axes.grid(visible=False, axis="y")
    axes.set_title("without each joint: median, and 5 to 95 %")


def _depth(axes: Axes, found: Survey) -> None:
    counts = found.total("depth")
    shares = 100.0 * counts / max(int(counts.sum()), 1)
    labels = [label.replace(" ", "\n", 1) for label in depth_labels(found)]
    bars = axes.bar(np.arange(len(counts)), shares, color=STRONG)
    axes.bar_label(bars, [f"{value:.3g} %" if value else "" for value in shares], fontsize=8.5, padding=1)
    axes.set_xticks(np.arange(len(counts)), labels)
    axes.set(xlabel="joints that can fail, whichever they are", ylabel="configurations [%]", ylim=(0.0, 110.0))
    axes.grid(visible=False, axis="x")
    axes.set_title("how many losses keep every direction")


def _reach(axes: Axes, found: Survey) -> None:
    """Shares of poses before and after each joint's loss, or that of sets where no joint fails alone; worst first."""
    before = 100.0 * float(found.total("reach_before")) / max(found.configurations, 1)
    own = [place for place, joints in enumerate(found.sets) if len(joints) == 1] or list(range(len(found.sets)))
    _bars(axes, [" + ".join(found.sets[place]) for place in own], 100.0 * found.reached[own], before)
    axes.set(xlabel="poses reached [%]")
    axes.set_title("reach before and after each loss")


def _positions(axes: Axes, found: Survey) -> None:
    """Shares of the positions that all joints reach, the worst loss first."""
    left = 100.0 * found.positions
    own = [joint for joint in found.singles if np.isfinite(left[joint])]
    _bars(axes, [found.arm.joint_names[joint] for joint in own], left[own], 100.0)
    axes.set(xlabel="positions reached, in any attitude [%]")
    axes.set_title("positions before and after each loss")


def _bars(axes: Axes, names: list[str], shares: np.ndarray, before: float) -> None:
    """A bar for all joints and for each loss, the worst first [%]."""
    order = np.argsort(shares, kind="stable")[:MOST_BARS]
    places = np.arange(len(order) + 1)
    values = [before, *shares[order]]
    bars = axes.barh(places, values, color=[PALE, *[STRONG] * len(order)])
    axes.bar_label(bars, [f"{value:.3g} %" for value in values], fontsize=8.5, padding=2)
    axes.set_yticks(places, ["all joints", *(in_picture(names[place], 16) for place in order)])
    axes.set(ylim=(len(places) - 0.5, -0.5), xlim=(0.0, 115.0))
    axes.grid(visible=False, axis="y")
