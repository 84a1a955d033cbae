"""Heat maps of a rehearsal: the largest error by joint and moment of the failure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stillreach.show.style import in_picture, matplotlib_or_error, new_figure, styled, wrapped
from stillreach.tolerance.failures import KINDS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stillreach.tolerance import Rehearsal

COLUMNS = 120
"""The most columns of a heat map: each shows the worst of its moments."""
GOOD = ((0.0, "#e3eef9"), (0.1, "#c0d9f0"), (0.3, "#8fbce6"), (1.0, "#4a8fd0"))
BAD = ((1.0, "#f9c784"), (3.0, "#f0963c"), (10.0, "#d9641a"), (100.0, "#a33b0b"))
"""Colours by the error as a multiple of what is allowed: blue and orange, which every eye tells apart."""
NOT_DONE = "#bbbbbb"


class Column(NamedTuple):
    """A column of a heat map.

    Args:
        places: (S,) the moment, by index, that is the worst for each set of joints.
        excess: (S,) its error as a multiple of what is allowed; NaN where none is done.
        lost: (S,) whether it is not survived.
    """

    places: np.ndarray
    excess: np.ndarray
    lost: np.ndarray


def columns(found: Rehearsal, kind: int) -> list[Column]:
    """The columns of the heat map of a kind of failures."""
    excess, made = found.excess[kind], []
    rows = np.arange(excess.shape[0])
    for own in np.array_split(np.arange(excess.shape[1]), min(COLUMNS, excess.shape[1])):
        worst = own[np.argmax(np.nan_to_num(excess[:, own], nan=-1.0), axis=1)]
        lost = found.done[kind, rows, worst] & ~found.survives[kind, rows, worst]
        made.append(Column(worst, excess[rows, worst], lost))
    return made


def colour(excess: float) -> str:
    """The colour of an error, between those of GOOD or BAD."""
    if math.isnan(excess):
        return NOT_DONE
    scale = GOOD if excess <= 1.0 else BAD
    low = max((k for k, (value, _) in enumerate(scale) if value <= excess), default=0)
    if low == len(scale) - 1:
        return scale[-1][1]
    (first, one), (last, other) = scale[low], scale[low + 1]
    share = (excess - first) / (last - first)
    parts = [round((1.0 - share) * int(one[k : k + 2], 16) + share * int(other[k : k + 2], 16)) for k in (1, 3, 5)]
    return "#" + "".join(f"{part:02x}" for part in parts)


def legend() -> list[tuple[str, str, bool]]:
    """Colours, what they mean, and whether the failure is not survived."""
    good = [(shade, f"{100 * value:g} %", False) for value, shade in GOOD]
    return [*good, *((shade, f"{value:g} x", True) for value, shade in BAD)]


def heading(found: Rehearsal, kind: int) -> tuple[str, str]:
    """The kind and its meaning, and the share of it that is survived."""
    name = found.kinds[kind]
    done = max(int(np.sum(found.done[kind])), 1)
    text = f"{name} ({KINDS[name][1]})" if name in KINDS else name
    return text, f"{100 * int(np.sum(found.survives[kind])) / done:.3g} % survived"


def heat_maps(found: Rehearsal) -> Figure:
    """A figure with the verdict and a heat map for each kind of failures.

    Raises:
        MissingExtraError: if matplotlib is not installed.
    """
    matplotlib_or_error("a picture of a rehearsal")
    from matplotlib.patches import Patch, Rectangle

    order, kinds = found.ranking, len(found.kinds)
    with styled("a picture of a rehearsal"):
        verdict = wrapped(found.verdict, 100)
        top, each = 0.55 + 0.2 * len(verdict), 0.75 + 0.2 * len(order)
        height = top + each * kinds + 0.45
        figure = new_figure(9.0, height)
        figure.text(0.02, 1.0 - 0.12 / height, "\n".join(verdict), va="top", fontsize=10.5)
        span = float(found.onset[-1]) * len(found.onset) / max(len(found.onset) - 1, 1) or found.scenario.period
        for kind in range(kinds):
            low = 1.0 - (top + each * (kind + 1) - 0.5) / height
            axes = figure.add_axes((0.17, low, 0.8, 0.2 * len(order) / height))
            made = columns(found, kind)
            width = span / len(made)
            for place, column in enumerate(made):
                for row, which in enumerate(order):
                    face = colour(float(column.excess[which]))
                    hatch = "////" if column.lost[which] else None
                    axes.add_patch(
                        Rectangle((place * width, row + 0.04), 1.04 * width, 0.92, facecolor=face, linewidth=0.0,
                                  edgecolor="#00000055", antialiased=False, hatch=hatch)
                    )  # fmt: skip
            axes.set(xlim=(0.0, span), ylim=(len(order), 0.0))
            axes.set_yticks(np.arange(len(order)) + 0.5, [in_picture(found.joints[which]) for which in order])
            axes.tick_params(axis="y", length=0)
            axes.grid(visible=False)
            axes.set_title(": ".join(heading(found, kind)))
        axes.set_xlabel("moment of the failure [s]")
        patches = [
            Patch(facecolor=shade, hatch="////" if lost else None, edgecolor="#00000055", label=text)
            for shade, text, lost in legend()
        ]
        figure.legend(handles=patches, loc="lower left", bbox_to_anchor=(0.01, 0.0), ncols=len(patches), fontsize=8,
                      handlelength=1.4, columnspacing=1.0)  # fmt: skip
    return figure
