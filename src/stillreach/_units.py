"""Units of files and of the command line, and numbers with units."""

from __future__ import annotations

import math
import re

from stillreach.errors import InputError

ANGLES = {"rad": 1.0, "deg": math.pi / 180.0}
"""[rad]"""
LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
"""[m]"""
NUMBER = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z°]*)")


def quantity(argument: str, text: str, units: dict[str, float], *, bare: bool = True) -> float:
    """A number with one of the units, or without: then it is in the first, SI.

    Args:
        argument: what the number is for, for the message.
        text: e.g. ``"-45deg"``, ``"0.1"``.
        units: size of each legal unit.
        bare: whether a number other than 0 may come without a unit.

    Returns:
        The number in SI units.

    Raises:
        InputError: if the text is not such a number.
    """
    match = NUMBER.fullmatch(text.strip())
    unit = (match[2] if match else "").replace("°", "deg")
    if match is None or (unit and unit not in units) or not (unit or bare or float(match[1]) == 0.0):
        raise InputError(argument, repr(text), _expected(units, bare))
    return float(match[1]) * (units[unit] if unit else 1.0)


def _expected(units: dict[str, float], bare: bool) -> str:
    first, named = next(iter(units)), [unit for unit in units if unit.isalpha()]
    if not named:
        return "a number"
    if not bare:
        return f"a number with a unit: {', '.join(named)}"
    return f"a number, bare{f' ({first})' if first else ''} or with {' or '.join(named)}"


def tolerances(argument: str, text: str | None, *, per_second: bool = False) -> tuple[float | None, float | None]:
    """A length [m] and an angle [rad] from ``5mm,1deg`` or ``5mm``; None for what is not given.

    Args:
        argument: option, for the message.
        text: what came.
        per_second: whether ``/s`` may stand behind each.

    Raises:
        InputError: if the text is invalid, without a unit, or negative.
    """
    if text is None:
        return None, None
    parts = [part.strip().removesuffix("/s") if per_second else part for part in text.split(",")]
    if len(parts) > 2:
        raise InputError(argument, repr(text), "a length, or a length and an angle, e.g. 5mm,1deg")
    length = quantity(argument, parts[0], LENGTHS, bare=False)
    angle = quantity(argument, parts[1], ANGLES, bare=False) if len(parts) == 2 else None
    if length < 0.0 or (angle or 0.0) < 0.0:
        raise InputError(argument, repr(text), "numbers of at least 0")
    return length, angle
