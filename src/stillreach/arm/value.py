"""Immutable values: the base of joints and arms."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, Self

import numpy as np


class Value:
    """Base of a frozen dataclass whose fields are its constructor's keywords: equal by content, picklable."""

    def _fields(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]

    def _content(self) -> tuple[Any, ...]:
        values = self._fields().values()
        return tuple(tuple(value.ravel().tolist()) if isinstance(value, np.ndarray) else value for value in values)

    def __eq__(self, other: object) -> bool:
        return self._content() == other._content() if isinstance(other, type(self)) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._content())

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (type(self), self._fields())


def _rebuild(kind: type[Value], values: dict[str, Any]) -> Value:
    """Unpickle through the constructor, because unpickled arrays are writable."""
    return kind(**values)
