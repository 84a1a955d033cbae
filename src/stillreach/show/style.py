"""How lines look: told apart by dashes, as in print, or by colour and dashes."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any

import numpy as np

from stillreach.errors import MissingExtraError
from stillreach.faults import FAULTS

DASHES: tuple[Any, ...] = (
    "-",
    (0, (6, 2)),
    (0, (6, 1.8, 1.2, 1.8)),
    (0, (1.2, 1.6)),
    (0, (11, 2.5)),
    (0, (6, 1.6, 1.2, 1.6, 1.2, 1.6)),
)
"""Solid, dashed, dash-dot, dotted, long dashes, dash-dot-dot."""

COLOURS = ("#1b4f8a", "#c8501e", "#2f7d4f", "#8a3f8f", "#7a6a1f", "#3b3b3b")

FAULT_COLOURS = ("#b3261e", "#d98a1f", "#8a3f8f", "#8a6d3b", "#c2578a", "#5b4a9e", "#6b6b2b")
HEALTH_COLOURS = {kind.health: colour for kind, colour in zip(FAULTS, FAULT_COLOURS, strict=False)}
"""Of a failed joint, wherever it is drawn."""

RC = {
    "font.family": "sans-serif",
    "font.size": 9.0,
    "text.parse_math": False,  # names may hold $
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
    "savefig.dpi": 160.0,
}


@dataclass(frozen=True)
class Look:
    """How a figure is drawn.

    Args:
        ink: black lines only, told apart by their dashes, as in a printed paper.
        length: what one unit of length is [m].
        length_name: its name on the axes.
    """

    ink: bool = False
    length: float = 1.0
    length_name: str = "m"

    def compared(self, place: int) -> dict[str, Any]:
        """Style of the line of a run at a place among several: by shade, for lines that may flicker."""
        if self.ink:
            return {"color": ("black", "0.62", "0.35", "0.8")[place % 4], "linewidth": 1.1}
        return {"color": COLOURS[place % len(COLOURS)]}

    def component(self, place: int) -> dict[str, Any]:
        """Style of the line of x, y or z, or of pitch, yaw or roll: solid, dashed, dotted."""
        return {**self.line(place), "linestyle": ("-", "--", ":")[place]}

    def line(self, place: int) -> dict[str, Any]:
        """Style of the line at a place in its panel."""
        lap = place // len(DASHES)
        colour = ("black" if lap == 0 else "0.55") if self.ink else COLOURS[place % len(COLOURS)]
        return {"color": colour, "linestyle": DASHES[(place + (0 if self.ink else lap)) % len(DASHES)]}


SCREEN = Look()
PRINT = Look(ink=True, length=0.0254, length_name="in")
"""The paper's look: black dashes, inches."""


def matplotlib_or_error(purpose: str) -> Any:
    """The matplotlib module.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import matplotlib
    except ImportError as error:
        raise MissingExtraError("plot", purpose) from error
    return matplotlib


def styled(purpose: str) -> AbstractContextManager[None]:
    """A context in which figures are made with this package's settings, whatever the user's own are."""
    context: AbstractContextManager[None] = matplotlib_or_error(purpose).rc_context(RC)
    return context


def unwrapped_degrees(angles: np.ndarray) -> np.ndarray:
    """Angles over time (T, k) [rad] in degrees, without jumps by a full turn."""
    return np.rad2deg(np.unwrap(angles, axis=0)) if len(angles) else np.rad2deg(angles)
