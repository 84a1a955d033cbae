"""Style of figures: colours, matplotlib settings, and shortened names."""

from __future__ import annotations

import textwrap
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any

from stillreach._text import printable
from stillreach.errors import MissingExtraError
from stillreach.faults import FAULTS

COLOURS = ("#1b4f8a", "#c8501e", "#2f7d4f", "#8a3f8f", "#7a6a1f", "#3b3b3b")

FAULT_COLOURS = ("#b3261e", "#d98a1f", "#8a3f8f", "#8a6d3b", "#c2578a", "#5b4a9e", "#6b6b2b")
HEALTH_COLOURS = {kind.health: colour for kind, colour in zip(FAULTS, FAULT_COLOURS, strict=False)}
"""Colour of failed joints."""

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NAME_LETTERS, TITLE_LETTERS = 26, 90

RC = {
    "font.family": "sans-serif",
    "font.size": 9.0,
    "text.parse_math": False,  # names may contain $
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#d9d9d9",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "legend.handlelength": 3.4,
    "legend.fontsize": 8.5,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "figure.dpi": 100.0,
    "figure.max_open_warning": 0,
    "savefig.dpi": 160.0,
}


def matplotlib_or_error(purpose: str) -> Any:
    """The matplotlib module.

    Raises:
        MissingExtraError: if it is not installed.
    """
    try:
        import matplotlib
    except ImportError as error:
        raise MissingExtraError("plot", purpose) from error
    return matplotlib


def styled(purpose: str) -> AbstractContextManager[None]:
    """A context in which figures are made with this package's settings, independent of the user's."""
    context: AbstractContextManager[None] = matplotlib_or_error(purpose).rc_context(RC)
    return context


def new_figure(width: float, height: float) -> Figure:
    """A pyplot figure of a size [in], for notebooks and ``pyplot.show()``."""
    from matplotlib import pyplot

    return pyplot.figure(figsize=(width, height))


def wrapped(text: str, width: int) -> list[str]:
    """The lines of a text; a number stays beside its %."""
    return textwrap.wrap(text.replace(" %", "\N{NO-BREAK SPACE}%"), width)


def in_picture(text: str, letters: int = NAME_LETTERS) -> str:
    """A name or title for a figure: one line; long ones are shortened in the middle."""
    text = printable(" ".join(text.split()))
    if len(text) > letters:
        text = f"{text[: letters // 2 - 1]}…{text[-(letters // 2) :]}"
    return f" {text}" if text.startswith("_") else text  # matplotlib omits these from legends
