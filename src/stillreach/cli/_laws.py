"""Laws by name: ``least-error``, or with settings ``singularity-robust:damping=closed-form:norm=2``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stillreach._messages import did_you_mean
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.laws import Law


def law_texts() -> tuple[list[str], list[str]]:
    """All laws by word, also with each word setting."""
    from stillreach.laws import LAWS

    settings = [(law, name, word) for law in LAWS for name, own in law.keys().items() for word in own.form.words]
    return [law.word for law in LAWS], [f"{law.word}:{name}={word}" for law, name, word in settings]


def parse_law(text: str, *, like: Law | None = None, argument: str = "--law") -> Law:
    """A law from its name and settings.

    Args:
        text: ``name`` or ``name:setting=value:...``; a value is a number, a word, or for a price
            ``rows=number+rows=number``.
        like: a law whose weights the new one takes; for the same kind also settings that are not given.
        argument: the argument's name in messages.

    Raises:
        InputError: if a name, setting or value is invalid.
    """
    from stillreach._kinds import by_word
    from stillreach._reading import Reading
    from stillreach.laws import LAWS

    laws = by_word(LAWS)
    name, *settings = text.strip().split(":")
    if name not in laws:
        raise InputError(argument, repr(name), f"one of {', '.join(laws)}{did_you_mean(name, laws)}")
    keys, reading, given = laws[name].keys(), Reading(), {}
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not equals or key not in keys:
            expected = f"{name} or {name}:setting=value with a setting of {', '.join(keys)}"
            raise InputError(argument, repr(text), expected)
        if key in given:
            raise InputError(argument, f"{key} twice in {text!r}", "each setting once")
        form = keys[key].form
        given[key] = form.read(form.spoken(value, f"{argument} {text}, {key}", reading), (key,), reading)
    reading.raise_first(f"{argument} {text}, ")
    taken = [] if like is None else ["weights", *keys] if isinstance(like, laws[name]) else ["weights"]
    try:
        return laws[name](**{key: getattr(like, key) for key in taken} | given)
    except InputError as error:
        raise InputError(f"{argument} {text}, {error.argument}", error.got, error.expected) from None


def parse_laws(text: str, *, like: Law | None = None) -> dict[str, Law]:
    """Laws separated by commas, keyed by their text.

    Raises:
        InputError: if a law is invalid or repeated.
    """
    names = [part.strip() for part in text.split(",")]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError("--laws", f"{twice[0]!r} twice", "each law once")
    return {name: parse_law(name, like=like, argument="--laws") for name in names}
