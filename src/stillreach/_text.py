"""Text that came from files, for terminals."""

from __future__ import annotations

import unicodedata


def printable(text: str) -> str:
    """The text with control characters and lone surrogates written out; lines and tabs stay."""
    if text.isprintable():
        return text
    return "".join(ascii(letter)[1:-1] if _is_control(letter) else letter for letter in text)


def _is_control(letter: str) -> bool:
    return letter not in "\n\t" and unicodedata.category(letter) in ("Cc", "Cs")
