"""How messages write places, values and choices."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from stillreach.errors import nearest

SHOWN = 60
"""Letters of a value in a message."""
FEW = 6
"""Entries of a list that are shown one by one."""


def written(place: tuple[str | int, ...]) -> str:
    """A place as a reader writes it: ``faults[1].joint``."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{short(part)}" if text else short(part)
    return text


def shown(value: Any) -> str:
    """What came, short."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a table" if value else "an empty table"
    if isinstance(value, list):
        plain = len(value) <= FEW and not any(isinstance(entry, list | dict | str) for entry in value)
        return f"[{', '.join(map(shown, value))}]" if plain else f"a list of {len(value)}"
    if isinstance(value, int) and abs(value) >= 10**20:
        return "a huge integer"
    return short(repr(value) if isinstance(value, str | int | float) else str(value))


def short(text: str) -> str:
    """A text of at most SHOWN letters, those that cannot be shown escaped."""
    text = text if len(text) <= SHOWN else f"{text[:SHOWN]}…"
    return text if text.isprintable() else repr(text)[1:-1]


def listed(choices: Iterable[str], most: int = 40) -> str:
    """The choices in a row."""
    names = list(choices)
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(map(short, names[:most])) + more


def did_you_mean(value: Any, choices: Iterable[str]) -> str:
    """A hint where one of the choices is nearly what came, else nothing."""
    near = nearest(value, choices)
    return f"did you mean {near!r}?" if near else ""
