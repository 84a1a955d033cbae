"""Arrays in a page: one JSON document, and one compressed block of bytes that it points into."""

from __future__ import annotations

import base64
import gzip
import json
from typing import Any

import numpy as np

CODES = {"float64": np.uint64, "float32": np.uint32, "int32": np.uint32}
"""Types whose columns are stored as differences, and the type of these."""


def pack(document: Any) -> tuple[str, str]:
    """A document with arrays as two texts.

    A number in a smooth column is close to the line through the two before it, also as a pattern of bits: what is
    stored of floats and integers are second differences of these patterns along the first axis, their bytes apart by
    significance, which compress well and lose nothing.

    Args:
        document: dictionaries, lists, text, finite numbers and arrays of float64, float32, int32 or int8.

    Returns:
        JSON, in which an array is ``{"array": [type, shape, offset]}``, safe inside a script element; and the bytes,
        compressed by gzip, in base64.
    """
    block = bytearray()

    def stored(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            offset = len(block)
            block.extend(_bytes(np.ascontiguousarray(value)))
            return {"array": [value.dtype.name, list(value.shape), offset]}
        if isinstance(value, dict):
            return {name: stored(part) for name, part in value.items()}
        if isinstance(value, list | tuple):
            return [stored(part) for part in value]
        return value.item() if isinstance(value, np.generic) else value

    text = json.dumps(stored(document), allow_nan=False, ensure_ascii=False)
    safe = text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    return safe, compressed(bytes(block))


def compressed(data: bytes | str) -> str:
    """Bytes, or text in UTF-8, compressed by gzip, in base64."""
    raw = data.encode() if isinstance(data, str) else data
    return base64.b64encode(gzip.compress(raw, 9, mtime=0)).decode()


def _bytes(array: np.ndarray) -> bytes:
    code = CODES.get(array.dtype.name)
    if code is None:
        return array.astype(np.int8, casting="equiv").tobytes()
    columns = array.reshape(len(array), -1).view(code)
    first = np.diff(columns, axis=0, prepend=columns[:1])  # 0, then the steps
    columns = np.concatenate([columns[:1], np.diff(first, axis=0)])
    signed = columns.view(np.dtype(f"i{columns.itemsize}"))
    folded = (signed << 1) ^ (signed >> (8 * columns.itemsize - 1))  # small to either side becomes small
    planes = np.ascontiguousarray(folded.T).view(np.uint8).reshape(-1, columns.itemsize).T
    return np.ascontiguousarray(planes).tobytes()
