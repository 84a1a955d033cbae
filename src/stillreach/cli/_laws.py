"""Laws by name: ``least-error``, or with settings ``singularity-robust:damping=closed-form:norm=2``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from stillreach.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from stillreach.laws import Law

LAWS = {
    "least-error": "LeastError",
    "keep-direction": "KeepDirection",
    "singularity-robust": "SingularityRobust",
    "pseudoinverse": "Pseudoinverse",
}
"""Name on the command line and class in ``stillreach``."""

VARIANTS = ("least-error:price=position-first", "least-error:price=none")
"""Laws with settings that completion offers."""

EXAMPLE = "singularity-robust:damping=closed-form:norm=2"
PRICES = "a number above 0, none, position-first, or prices by rows such as position=100+orientation=8"


def parse_law(text: str, *, like: Law | None = None, argument: str = "--law") -> Law:
    """A law from its name and settings.

    Args:
        text: ``name`` or ``name:setting=value:...``; a value is a number, ``none``, a word, or for a price
            ``rows=number+rows=number``.
        like: a law whose weights the new one takes over; of the same kind also its settings, where none is given.
        argument: what the text was given for, for messages.

    Raises:
        InputError: another name, setting or value.
    """
    from dataclasses import fields

    import stillreach as sr

    name, *settings = text.strip().split(":")
    if name not in LAWS:
        raise InputError(argument, repr(name), f"one of {', '.join(LAWS)}{did_you_mean(name, LAWS)}")
    kind: type[Law] = getattr(sr, LAWS[name])
    known = [field.name for field in fields(kind) if field.name != "weights"]
    values: dict[str, str] = {}
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not equals or key not in known:
            expected = f"{name} or {name}:setting=value with a setting of {', '.join(known)}"
            raise InputError(argument, repr(text), expected)
        if key in values:
            raise InputError(argument, f"{key} twice in {text!r}", "each setting once")
        values[key] = value
    taken = [] if like is None else ["weights", *known] if isinstance(like, kind) else ["weights"]
    try:
        given = {key: READ.get(key, _value)(value) for key, value in values.items()}
        return kind(**{key: getattr(like, key) for key in taken} | given)
    except InputError as error:
        raise InputError(f"{argument} {text}, {error.argument}", error.got, error.expected) from None


def parse_laws(text: str, *, like: Law | None = None) -> dict[str, Law]:
    """Several laws separated by commas, by the text that names each.

    Raises:
        InputError: one of them is no law, or comes twice.
    """
    names = [part.strip() for part in text.split(",")]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError("--laws", f"{twice[0]!r} twice", "each law once")
    return {name: parse_law(name, like=like, argument="--laws") for name in names}


def _value(text: str) -> float | str | None:
    if text.lower() == "none":
        return None
    try:
        return float(text)
    except ValueError:
        return text


def _price(text: str) -> Any:
    """A price: as ``_value``, or a mapping where it names rows."""
    import re

    value = _value(text)
    if not isinstance(value, str) or value == "position-first":
        return value
    by_rows: dict[str, Any] = {}
    for part in re.split(r"\+(?=[a-z])", text):
        rows, equals, price = part.partition("=")
        if not equals or rows in by_rows:
            raise InputError("price", repr(text), PRICES if not equals else "each row once")
        by_rows[rows] = _value(price)
    return by_rows


READ: dict[str, Callable[[str], Any]] = {"norm": str, "price": _price}
"""How the settings are read that are not a number, none or a word: the norm "2" is a word."""
