"""Positions that an arm reaches before and after each loss: of a plane, and as a cloud in space."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stillreach.errors import InputError
from stillreach.show.style import in_picture, matplotlib_or_error, new_figure, styled, wrapped
from stillreach.tolerance.account import percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stillreach.tolerance import Survey
    from stillreach.tolerance.surveys.positions import Cells

PURPOSE = "a picture of positions"
OUTSIDE, UNTRIED, LOST, SELDOM, OFTEN, ALWAYS = range(6)
LEVELS = (
    ("#e6e9ed", "not reached with all joints"),
    ("#ffffff", "not tried"),
    ("#c8501e", "lost wherever the joint locks"),
    ("#f3b67f", "lost in most places of the joint"),
    ("#9cc3e8", "reached in most places of the joint"),
    ("#1b4f8a", "reached wherever the joint locks"),
)
"""Colours and meanings of a cell: orange and blue, which every eye tells apart."""
MOST_PANELS = 12
SIDE = 4
"""Panels beside each other."""
LEAST_CELLS, HOLES = 4, 0.1
"""Cells along an axis are not fewer; the share of cells without a try that a picture may have."""
WORST = 3
"""Losses whose clouds are drawn."""

Codes = npt.NDArray[np.int8]


class Seen(NamedTuple):
    """The counts of a slice or cloud as they are drawn.

    Args:
        cells: perhaps larger ones than the survey's.
        before: whether all joints reach a cell.
        tried: how often joints were locked to reach it again.
        after: (n, ...) how often it was reached without each joint.
    """

    cells: Cells
    before: npt.NDArray[np.bool_]
    tried: npt.NDArray[np.int64]
    after: npt.NDArray[np.int64]


def seen(found: Survey, name: str) -> Seen:
    """The counts by cell; with fewer configurations than cells, of larger cells, so that few are without a try.

    Args:
        found: a survey with positions.
        name: "slice" or "cloud".
    """
    cells = found.region.slice if name == "slice" else found.region.cloud
    assert cells is not None
    before = found.total(f"{name}_before") > 0
    tried, after = (found.total(f"{name}_{part}").astype(np.int64) for part in ("tried", "after"))
    while cells.count % 2 == 0 and cells.count > LEAST_CELLS and tried.any():
        if np.count_nonzero(before & (tried == 0)) <= HOLES * np.count_nonzero(before):
            break
        cells = replace(cells, count=cells.count // 2)
        before, tried, after = _blocks(before, cells) > 0, _blocks(tried, cells), _blocks(after, cells)
    return Seen(cells, before, tried, after)


def _blocks(counts: npt.NDArray[Any], cells: Cells) -> npt.NDArray[np.int64]:
    """Sums over blocks of two cells along each of the last axes."""
    axes = len(cells.axes)
    lead = counts.shape[: counts.ndim - axes]
    split = counts.reshape(*lead, *[size for _ in range(axes) for size in (cells.count, 2)])
    summed: npt.NDArray[np.int64] = split.sum(axis=tuple(len(lead) + 2 * axis + 1 for axis in range(axes)))
    return summed


def levels(of: Seen, joint: int | None) -> Codes:
    """The level of each cell: after the loss of a joint, by index, or with all."""
    code = np.where(of.before, ALWAYS, OUTSIDE).astype(np.int8)
    if joint is None:
        return code
    tried, after = of.tried, of.after[joint]
    code[of.before & (tried == 0)] = UNTRIED
    for level, own in (
        (LOST, after == 0),
        (SELDOM, (after > 0) & (2 * after < tried)),
        (OFTEN, (2 * after >= tried) & (after < tried)),
    ):
        code[of.before & (tried > 0) & own] = level
    return code


def kept(found: Survey, name: str, joint: int) -> float:
    """The share of the tries in which a position was still reached without a joint; NaN if none was."""
    tried = int(found.total(f"{name}_tried").sum())
    return float(found.total(f"{name}_after")[joint].sum()) / tried if tried else float("nan")


def by_cost(found: Survey, name: str) -> list[int]:
    """The joints that fail alone, that whose loss costs most positions first."""
    return sorted(found.singles, key=lambda joint: kept(found, name, joint))


def finding(found: Survey, name: str, where: str) -> str:
    """What the pictures show, in a sentence."""
    order, names = by_cost(found, name), found.arm.joint_names
    if not order or np.isnan(kept(found, name, order[0])):
        return f"No position {where} was tried."
    low, high = (percent(kept(found, name, order[place])) for place in (0, -1))
    first = f"Without {names[order[0]]} the tool still reaches {low} of its positions {where}"
    return f"{first}." if len(order) == 1 else f"{first}, without {names[order[-1]]} {high}."


def plane_of(cells: Cells) -> str:
    """``x-z``."""
    return "-".join("xyz"[axis] for axis in cells.axes)


def used(of: Seen) -> tuple[slice, ...]:
    """The part of the arrays that holds all cells which all joints reach, with a margin of one."""
    if not of.before.any():
        return tuple(slice(0, size) for size in of.before.shape)
    places = np.argwhere(of.before)
    low, high = np.maximum(places.min(axis=0) - 1, 0), np.minimum(places.max(axis=0) + 2, of.before.shape)
    return tuple(slice(int(a), int(b)) for a, b in zip(low, high, strict=True))


def slice_figure(found: Survey) -> Figure:
    """A panel for all joints, and one for each loss, that which costs most first.

    Raises:
        InputError: if the survey has no positions.
        MissingExtraError: if matplotlib is not installed.
    """
    own = seen(found, "slice")
    cells = own.cells
    matplotlib_or_error(PURPOSE)
    from matplotlib.colors import ListedColormap

    joints: list[int | None] = [None, *by_cost(found, "slice")[: MOST_PANELS - 1]]
    across, up = cells.axes
    part = used(own)
    rows, columns = -(-len(joints) // SIDE), min(len(joints), SIDE)
    colours = ListedColormap([colour for colour, _ in LEVELS])
    with styled(PURPOSE):
        text = wrapped(
            f"{in_picture(found.arm.name)}: {finding(found, 'slice', f'in the {plane_of(cells)} plane')}",
            int(36 * columns),
        )
        top, bottom, each = 0.45 + 0.2 * len(text), 1.15, 2.75
        width, height = 0.8 + 2.6 * columns, top + bottom + each * rows
        figure = new_figure(width, height)
        figure.text(0.02, 1.0 - 0.12 / height, "\n".join(text), va="top", fontsize=10.5)
        figure.subplots_adjust(
            left=0.75 / width, right=1.0 - 0.1 / width, bottom=bottom / height, top=1.0 - top / height,
            wspace=0.12, hspace=0.18,
        )  # fmt: skip
        for place, joint in enumerate(joints):
            axes = figure.add_subplot(rows, columns, place + 1)
            codes = levels(own, joint)[part]
            edges = [
                cells.edges(axis)[span.start : span.stop + 1] for axis, span in zip((up, across), part, strict=True)
            ]
            axes.pcolormesh(edges[1], edges[0], codes, cmap=colours, vmin=-0.5, vmax=len(LEVELS) - 0.5, rasterized=True)
            axes.plot(cells.centre[across], cells.centre[up], "^", color="black", ms=5, mec="white", mew=0.6)
            axes.set(aspect="equal")
            axes.grid(visible=False)
            axes.set_title(_title(found, joint, "slice"), fontsize=9.0)
            last = place + columns >= len(joints)
            axes.set_xlabel(f"{'xyz'[across]} [m]") if last else axes.tick_params(labelbottom=False)
            axes.set_ylabel(f"{'xyz'[up]} [m]") if place % columns == 0 else axes.tick_params(labelleft=False)
        _legend(figure, [levels(own, joint)[part] for joint in joints], columns, first_joint=True)
    return figure


def _title(found: Survey, joint: int | None, name: str) -> str:
    if joint is None:
        return "all joints"
    return f"without {in_picture(found.arm.joint_names[joint], 18)}: {percent(kept(found, name, joint))}"


def _legend(figure: Figure, codes: list[Codes], columns: int, *, first_joint: bool) -> None:
    """The levels that a figure has, and the triangle."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    present = set(np.unique(np.concatenate([code.ravel() for code in codes])).tolist())
    handles: list[Any] = [
        Patch(facecolor=colour, edgecolor="#888888", linewidth=0.5, label=text)
        for level, (colour, text) in enumerate(LEVELS)
        if level in present
    ]
    if first_joint:
        handles.append(
            Line2D([], [], marker="^", ls="", color="black", mec="white", mew=0.6, ms=6, label="the first joint")
        )
    side = {1: 1, 2: 2}.get(columns, 3)
    figure.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.01, 0.0), ncols=side, handlelength=1.4)


def cloud_figure(found: Survey) -> Figure:
    """The cloud of positions with all joints, and after the losses that cost most; a quarter is cut away.

    Raises:
        InputError: if the survey has no positions in space.
        MissingExtraError: if matplotlib is not installed.
    """
    if found.region.cloud is None:
        raise InputError(
            "task", f"rows {', '.join(found.task.row_names)}", "the position in all three axes, for a cloud"
        )
    matplotlib_or_error(PURPOSE)
    joints: list[int | None] = [None, *by_cost(found, "cloud")[:WORST]]
    own = seen(found, "cloud")
    points = own.cells.points()
    with styled(PURPOSE):
        text = wrapped(f"{in_picture(found.arm.name)}: {finding(found, 'cloud', 'in space')}", 110)
        height = 9.75 + 0.2 * len(text)
        figure = new_figure(9.0, height)
        note = "The quarter x > 0, y < 0 around the first joint is left out, so that the inside shows."
        figure.text(0.02, 1.0 - 0.12 / height, "\n".join(text), va="top", fontsize=10.5)
        figure.text(0.02, 1.0 - (0.2 + 0.2 * len(text)) / height, note, va="top", color="#555555")
        shown = []
        for place, joint in enumerate(joints):
            left, low = 0.02 + 0.49 * (place % 2), (4.35 if place < 2 else 0.0) + 0.75
            axes: Any = figure.add_axes((left, low / height, 0.47, 4.1 / height), projection="3d")
            codes = levels(own, joint).reshape(-1)
            shown.append(codes[codes != OUTSIDE])
            _cloud(
                axes,
                points,
                codes,
                np.array(own.cells.centre),
                SIZES if joint is not None else dict.fromkeys(SIZES, 16),
            )
            axes.set_title(_title(found, joint, "cloud"), fontsize=9.0, loc="left")
        _legend(figure, [codes for codes in shown if len(codes)] or [np.zeros(0, np.int8)], 4, first_joint=False)
    return figure


SIZES = {UNTRIED: 6, ALWAYS: 8, OFTEN: 16, SELDOM: 26, LOST: 34}
"""Of dots [points^2]: what is lost stands out."""


def _cloud(axes: Any, points: np.ndarray, codes: Codes, centre: np.ndarray, sizes: dict[int, int]) -> None:
    """Cells as dots."""
    away = points - centre
    seen = (codes != OUTSIDE) & ~((away[:, 0] > 0.0) & (away[:, 1] < 0.0))
    for level, size in sizes.items():
        own = seen & (codes == level)
        if own.any():
            axes.scatter(
                *points[own].T, s=size, c=LEVELS[level][0], linewidths=0.3,
                edgecolors="white" if level != UNTRIED else "#888888", depthshade=False,
            )  # fmt: skip
    reached = points[codes != OUTSIDE]
    if len(reached):
        low, high = reached.min(axis=0), reached.max(axis=0)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
        axes.set_box_aspect(np.maximum(high - low, 1e-6), zoom=0.9)
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.view_init(elev=22.0, azim=-50.0)
    axes.tick_params(labelsize=7.5)
