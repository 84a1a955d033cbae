"""Numbers with units as people read them, and names in as much room as a picture has."""

from __future__ import annotations

import math

from stillreach._text import printable

NAME_LETTERS, TITLE_LETTERS = 26, 90


def in_picture(text: str, letters: int = NAME_LETTERS) -> str:
    """A name or title for a picture: in one line, of a long one both ends."""
    text = printable(" ".join(text.split()))
    if len(text) > letters:
        text = f"{text[: letters // 2 - 1]}…{text[-(letters // 2) :]}"
    return f" {text}" if text.startswith("_") else text  # matplotlib leaves what begins so out of legends


def shown_angle(value: float) -> str:
    """An angle [rad] in degrees; 0 below a thousandth of one."""
    degrees = math.degrees(value)
    return f"{tidy(degrees) if abs(degrees) >= 1e-3 else '0'}°"


def shown_length(value: float) -> str:
    """A length [m] in metres from one on, else in millimetres; 0 below a thousandth of one."""
    if abs(value) < 1e-6:
        return "0 mm"
    return f"{tidy(value)} m" if abs(value) >= 1.0 else f"{tidy(1000 * value)} mm"


def shown(value: float, joint_unit: str, *, rate: bool = False) -> str:
    """A joint's value (or rate) in degrees or millimetres (per second), from rad or m."""
    number = math.degrees(value) if joint_unit == "rad" else 1000 * value
    return f"{tidy(number)} {'deg' if joint_unit == 'rad' else 'mm'}{'/s' if rate else ''}"


def tidy(number: float) -> str:
    """Three digits, more before the point where there are more: 12,345, 56.8, 0.123; 0 for rounding errors."""
    if abs(number) < 1e-6:
        return "0"
    return f"{number:,.0f}" if abs(number) >= 1000 else f"{number:.3g}"
