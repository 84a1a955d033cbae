"""How messages write values and choices, and which choice was probably meant."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

SHOWN = 60
"""Letters of a value in a message."""
FEW = 6
"""Entries of a list that are shown one by one."""
LIKENESS = 0.65
"""Least share of letters in common (difflib's ratio): ``axis`` is not a misspelt ``radius``, which has 0.6."""
SHORTEST = 3
"""Letters of a choice that a word may begin with."""
LONGEST, COMPARED = 100, 1000
"""Letters of a word, and number of choices, that are compared."""


def nearest(word: Any, choices: Iterable[str]) -> str | None:
    """The choice nearest to the word, ignoring case, ``_``, ``-`` and spaces, or None.

    A choice that differs in digits alone is another thing, not a misspelling: ``joint9`` is not meant for ``joint7``.
    """
    if not isinstance(word, str) or len(word) > LONGEST:
        return None
    from difflib import get_close_matches

    form = _form(word)
    by_form = {_form(choice): choice for choice in list(choices)[:COMPARED] if len(choice) <= LONGEST}
    others = [key for key in by_form if key == form or _undigited(key) != _undigited(form)]
    near = get_close_matches(form, others, n=1, cutoff=LIKENESS)
    near = near or [key for key in others if len(key) >= SHORTEST and form.startswith(key)]  # degrees: deg
    return by_form[near[0]] if near else None


def hint(word: Any, choices: Iterable[str]) -> str:
    """``did you mean 'elbow'?`` where one of the choices is nearly the word, else nothing."""
    near = nearest(word, choices)
    return f"did you mean {near!r}?" if near else ""


def did_you_mean(word: Any, choices: Iterable[str]) -> str:
    """The hint in brackets, to stand behind a list of choices."""
    text = hint(word, choices)
    return f" ({text})" if text else ""


def one_of(choices: Iterable[str], word: Any = None) -> str:
    """``one of 'exact', 'closed-form'``, with a hint where one of them is nearly the word."""
    names = list(choices)
    return f"{'one of ' if len(names) > 1 else ''}{', '.join(map(repr, names))}{did_you_mean(word, names)}"


def listing(choices: Iterable[str]) -> str:
    """'j1 … j11' for names that only count up, else all of them."""
    names = tuple(choices)
    parts = [re.fullmatch(r"(.*?)(\d+)", name) for name in names]
    if len(names) > 3 and all(parts):
        first = parts[0]
        counted = [f"{first[1]}{int(first[2]) + k}" for k in range(len(names))] if first else []
        if counted == list(names):
            return f"{names[0]} … {names[-1]}"
    return ", ".join(names)


def listed(choices: Iterable[str], most: int = 40) -> str:
    """The choices in a row, each short; of many the first, and how many more."""
    names = list(choices)
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(map(short, names[:most])) + more


def written(place: tuple[str | int, ...]) -> str:
    """A place in a file as a reader writes it: ``faults[1].joint``."""
    text = ""
    for part in place:
        text += f"[{part}]" if isinstance(part, int) else f".{short(part)}" if text else short(part)
    return text


def shown(value: Any) -> str:
    """A value from a file, short, in the file's own words."""
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


def _undigited(form: str) -> str:
    return re.sub(r"\d", "0", form)


def _form(text: str) -> str:
    return re.sub(r"[_\s]", "-", text.lower())
