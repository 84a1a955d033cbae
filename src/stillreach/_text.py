"""Text of files, for terminals and as bytes: UTF-8 or, as PowerShell's ``>`` writes it, UTF-16 with its mark."""

from __future__ import annotations

import codecs
import unicodedata

UTF_16_MARKS = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def decoded(data: bytes) -> str:
    """The text of a file, without its byte order mark.

    Raises:
        UnicodeDecodeError: the bytes are neither UTF-8 nor, after a byte order mark, UTF-16.
    """
    return data.decode("utf-16" if data.startswith(UTF_16_MARKS) else "utf-8-sig")


def printable(text: str) -> str:
    """The text with control characters and lone surrogates written out; lines and tabs stay."""
    if text.isprintable():
        return text
    return "".join(ascii(letter)[1:-1] if _is_control(letter) else letter for letter in text)


def _is_control(letter: str) -> bool:
    return letter not in "\n\t" and unicodedata.category(letter) in ("Cc", "Cs")
