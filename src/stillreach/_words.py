"""Numbers with units as people read them, directions of a tool, and tables of text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stillreach._labels import TWIST

if TYPE_CHECKING:
    from stillreach._door import FloatArray

LEAST_PART = 0.05
"""Components of a direction below this are left out."""
NAMED = 4
"""Names in a sentence."""


def shown_angle(value: float) -> str:
    """An angle [rad] in degrees; 0 below a thousandth of one."""
    degrees = math.degrees(value)
    return f"{tidy(degrees) if abs(degrees) >= 1e-3 else '0'}°"


def shown_length(value: float) -> str:
    """A length [m] in metres from one on, else in millimetres; 0 below a thousandth of one."""
    if abs(value) < 1e-6:
        return "0 mm"
    return f"{tidy(value)} m" if abs(value) >= 1.0 else f"{tidy(1000 * value)} mm"


def shown_time(value: float) -> str:
    """A time [s] in seconds from one on, else in milliseconds."""
    return f"{tidy(value)} s" if value >= 1.0 else f"{tidy(1000 * value)} ms"


def shown(value: float, joint_unit: str, *, rate: bool = False) -> str:
    """A joint's value (or rate) in degrees or millimetres (per second), from rad or m."""
    number = math.degrees(value) if joint_unit == "rad" else 1000 * value
    return f"{tidy(number)} {'deg' if joint_unit == 'rad' else 'mm'}{'/s' if rate else ''}"


def tidy(number: float) -> str:
    """Three digits, more before the point where there are more: 12,345, 56.8, 0.123; 0 for rounding errors."""
    if abs(number) < 1e-6:
        return "0"
    return f"{number:,.0f}" if abs(number) >= 1000 else f"{number:.3g}"


def direction(twist: FloatArray, rows: Sequence[int], *, signed: bool = True) -> str:
    """A direction of the tool by its components that matter: ``-vz`` or ``0.32 vx + 0.94 wy``.

    Args:
        twist: (m,) of length 1.
        rows: (m,) which ones of [v; w] its components are.
        signed: whether the opposite direction is another one.
    """
    parts = [(float(value), TWIST.names[row]) for value, row in zip(twist, rows, strict=True)]
    parts = [part for part in parts if abs(part[0]) >= LEAST_PART]
    if not signed and parts[0][0] < 0.0:
        parts = [(-value, name) for value, name in parts]
    if len(parts) == 1:
        return f"{'-' if parts[0][0] < 0 else ''}{parts[0][1]}"
    text = " ".join(f"{'-' if value < 0 else '+'} {abs(value):.2f} {name}" for value, name in parts)
    return text.removeprefix("+ ").replace("- ", "-", 1) if parts[0][0] < 0 else text.removeprefix("+ ")


def share(part: float) -> str:
    """A part of a whole in per cent; what is more than nothing never reads 0 %."""
    return f"{100 * part:.0f} %" if part >= 0.01 else f"{100 * part:.1g} %"


def joined(names: Sequence[str], word: str) -> str:
    """Names in a sentence: ``j1, j2 and j4``; of many the first ones, and how many more."""
    if len(names) > NAMED:
        return f"{', '.join(names[:NAMED])} {word} {len(names) - NAMED} more"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {word} {names[-1]}"


def aligned(rows: Sequence[Sequence[str]]) -> str:
    """Rows of cells as lines, each column as wide as its widest cell."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    return "\n".join(line.rstrip() for line in lines)
