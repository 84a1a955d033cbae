"""What a page says and draws of a survey: where an arm can still go after each loss."""

from __future__ import annotations

import math
from collections.abc import Sequence
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stillreach.show.positions import (
    ALWAYS,
    LEVELS,
    LOST,
    OFTEN,
    OUTSIDE,
    SELDOM,
    UNTRIED,
    Codes,
    by_cost,
    finding,
    kept,
    levels,
    plane_of,
    seen,
    used,
)
from stillreach.tolerance.account import percent

if TYPE_CHECKING:
    from stillreach.tolerance import Survey

WIDTH, LEFT, ROW = 880, 150, 22
"""Sizes of the charts: width, space for names, height of a row."""
PANELS, GAP = 4, 14
"""Panels of the plane beside each other, and the space between them."""
MOST_ROWS, MOST_PANELS = 16, 12
FILLS = {OUTSIDE: "card", UNTRIED: "line", LOST: "lost", SELDOM: "seldom", OFTEN: "often", ALWAYS: "always"}
"""Colours of the page, in light and dark."""
BAR = 110
"""Height of a bar of the histogram that holds all moments."""


class Bar(NamedTuple):
    """A bar with its text."""

    y: float
    width: float
    text: str


class Chart(NamedTuple):
    """One column of the ranking: bars of all joints for one measure."""

    title: str
    x: float
    width: float
    bars: list[Bar]


class Panel(NamedTuple):
    """The cells of the plane after one loss: for each level a colour and an outline."""

    title: str
    x: float
    y: float
    shapes: list[tuple[str, str]]
    xticks: list[tuple[float, str]]
    yticks: list[tuple[float, str]]
    joint: tuple[float, float]


class Slice(NamedTuple):
    """All panels of the plane."""

    text: str
    height: float
    across: float
    up: float
    scale: float
    axes: str
    panels: list[Panel]
    legend: list[tuple[str, str]]


class Column(NamedTuple):
    """A bar of the histogram of depth."""

    x: float
    y: float
    height: float
    share: str
    label: str


def left_html(found: Survey, faults: int) -> str:
    """The section of a page.

    Args:
        found: the survey along the task.
        faults: how many the scenario itself has.
    """
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    text = (resources.files("stillreach.show") / "left.html").read_text(encoding="utf-8")
    order = ranked(found)[:MOST_ROWS]
    return environment.from_string(text).render(
        intro=_intro(found, faults),
        ranking=_ranking_text(found, order),
        attitude=any(row >= 3 for row in found.task.indices),
        names=[(row * ROW + 0.5 * ROW, _short(found.arm.joint_names[joint])) for row, joint in enumerate(order)],
        charts=list(_charts(found, order)),
        height=ROW * len(order),
        more=len(found.singles) - len(order),
        plane=_slice(found) if "positions" in found.metrics else None,
        depth=depth_text(found),
        columns=_columns(found),
        bar=BAR,
        width=WIDTH,
        row=ROW,
    )


def ranked(found: Survey) -> list[int]:
    """The joints that fail alone, that whose loss costs most poses first."""
    left = _poses(found)
    return sorted(found.singles, key=lambda joint: (left[joint], found.remaining()[joint]))


def _poses(found: Survey) -> dict[int, float]:
    """The share of poses that is reached without each joint."""
    by_set = dict(zip(found.sets, found.reached.tolist(), strict=True))
    return {joint: float(by_set[(found.arm.joint_names[joint],)]) for joint in found.singles}


def _intro(found: Survey, faults: int) -> str:
    text = (
        f"At each of {found.configurations:,} moments of the task a joint locks where it stands. "
        "Counted is how much of its reach the arm keeps, on the task and elsewhere."
    )
    return f"{text} The faults of the task itself are left out here." if faults else text


def _ranking_text(found: Survey, order: Sequence[int]) -> str:
    """Which loss costs most and which least, in a sentence."""
    left, names = _poses(found), found.arm.joint_names
    if not order:
        return "No joint fails alone."
    worst, best = order[0], ranked(found)[-1]
    low, high = percent(left[worst]), percent(left[best])
    if low == high:
        return f"Without any one joint, {low} of the poses stay within reach."
    first = f"The loss of {names[worst]} costs most: {low} of the poses stay within reach"
    return f"{first}. Without {names[best]} it is {high}."


def _charts(found: Survey, order: Sequence[int]) -> Any:
    """The columns of the ranking."""
    poses = _poses(found)
    measures = [("poses still reached [%]", {joint: poses[joint] for joint in order})]
    if "positions" in found.metrics:
        measures.append(("positions still reached [%]", {joint: float(found.positions[joint]) for joint in order}))
    median = found.remaining()
    measures.append(("manipulability left, median [%]", {joint: float(median[joint]) for joint in order}))
    room = (WIDTH - LEFT) / 3
    for place, (title, values) in enumerate(measures):
        width = room - 66.0
        bars = [
            Bar(row * ROW, width * float(np.nan_to_num(values[joint])), percent(values[joint]) or "-")
            for row, joint in enumerate(order)
        ]
        yield Chart(title, LEFT + place * room, width, bars)


def _slice(found: Survey) -> Slice:
    """The plane with all joints, and after each loss."""
    own_cells = seen(found, "slice")
    cells, part = own_cells.cells, used(own_cells)
    joints: list[int | None] = [None, *by_cost(found, "slice")[: MOST_PANELS - 1]]
    rows, columns = part[0].stop - part[0].start, part[1].stop - part[1].start
    across = (WIDTH - 44.0 - GAP * (PANELS - 1)) / PANELS
    scale = across / columns
    up = scale * rows
    edges = [cells.edges(axis)[own.start : own.stop + 1] for axis, own in zip(reversed(cells.axes), part, strict=True)]
    each = up + 46.0
    panels, shown = [], set[int]()
    for place, joint in enumerate(joints):
        codes = levels(own_cells, joint)[part]
        shown |= set(np.unique(codes).tolist())
        shapes = [(_fill(level), outline(codes, level)) for level in range(len(LEVELS)) if np.any(codes == level)]
        title = (
            "all joints"
            if joint is None
            else f"{_short(found.arm.joint_names[joint])}: {percent(kept(found, 'slice', joint))}"
        )
        panels.append(
            Panel(
                title,
                44.0 + (place % PANELS) * (across + GAP),
                22.0 + (place // PANELS) * each,
                shapes,
                _ticks(edges[1], across),
                [(up - at, text) for at, text in _ticks(edges[0], up)] if place % PANELS == 0 else [],
                _inside(edges, (cells.centre[cells.axes[1]], cells.centre[cells.axes[0]]), across, up),
            )
        )
    names = plane_of(cells)
    text = f"{finding(found, 'slice', f'in the {names} plane')} Its attitude does not count here."
    legend = [(_fill(level), LEVELS[level][1]) for level in sorted(shown)]
    height = each * -(-len(joints) // PANELS) + 10.0
    return Slice(text, height, across, up, scale, names, panels, legend)


def _fill(level: int) -> str:
    """Colours of the page where they depend on light and dark."""
    return f"var(--{FILLS[level]})"


def outline(codes: Codes, level: int) -> str:
    """The cells of a level as a path, a rectangle a run, in units of a cell, y downwards from the last row."""
    parts = []
    for row, line in enumerate(codes[::-1] == level):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], line, [False]])))
        parts += [f"M{a} {row}H{b}V{row + 1}H{a}Z" for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return "".join(parts)


def _inside(edges: list[np.ndarray], point: tuple[float, float], across: float, up: float) -> tuple[float, float]:
    """A point (up, across) [m] in the pixels of a panel."""
    x = (point[1] - edges[1][0]) / (edges[1][-1] - edges[1][0]) * across
    y = (point[0] - edges[0][0]) / (edges[0][-1] - edges[0][0]) * up
    return float(x), float(up - y)


def _ticks(edges: np.ndarray, length: float) -> list[tuple[float, str]]:
    """Places [px] and texts [m] along an axis."""
    low, high = float(edges[0]), float(edges[-1])
    step = 10.0 ** math.floor(math.log10(max(high - low, 1e-9)))
    step = next(step * part for part in (0.1, 0.2, 0.5, 1.0, 2.0) if (high - low) / (step * part) <= 5.0)
    first, last = math.ceil(low / step), math.floor(high / step)
    return [((k * step - low) / (high - low) * length, f"{k * step:.6g}") for k in range(first, last + 1)]


def depth_text(found: Survey) -> str:
    """At how many moments any one joint can fail, in a sentence."""
    counts = found.total("depth")
    total = max(int(counts.sum()), 1)
    any_one = percent(float(counts[2:].sum()) / total)
    text = f"At {any_one} of the moments any one joint can lock, and the rest still moves the tool in every direction."
    if counts[0]:
        text += f" At {percent(float(counts[0]) / total)} it cannot even with all joints."
    return text


def _columns(found: Survey) -> list[Column]:
    """The histogram of depth."""
    counts = found.total("depth")
    parts = counts / max(int(counts.sum()), 1)
    return [
        Column(20.0 + 120.0 * place, BAR * (1.0 - part), BAR * part, percent(part), label)
        for place, (part, label) in enumerate(zip(parts.tolist(), depth_labels(found), strict=True))
    ]


def depth_labels(found: Survey) -> list[str]:
    """What the bars of the histogram of depth stand for."""
    most = len(found.total("depth")) - 2
    labels = ["already singular", *map(str, range(most + 1))]
    if most < found.arm.n - found.task.m:
        labels[-1] += " or more"
    return labels


def _short(name: str) -> str:
    return name if len(name) <= 22 else f"{name[:21]}…"
