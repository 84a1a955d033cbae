"""Bytes of text files: UTF-8 or, as PowerShell's ``>`` writes it, UTF-16 with a byte order mark."""

from __future__ import annotations

import codecs

UTF_16_MARKS = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def decoded(data: bytes) -> str:
    """The text of a file, without its byte order mark.

    Raises:
        UnicodeDecodeError: the bytes are neither UTF-8 nor, after a byte order mark, UTF-16.
    """
    return data.decode("utf-16" if data.startswith(UTF_16_MARKS) else "utf-8-sig")
