"""Values that come with labels (mappings, pandas, xarray) are read by label, never by their order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from stillreach._messages import listing
from stillreach.errors import InputError


class Labels(NamedTuple):
    """What the entries of a vector are called.

    Args:
        kind: the word for one of them in messages, e.g. ``"joint"``.
        names: in the order of the vector.
        others: names that may come beside them and are not read, such as joints that follow others.
    """

    kind: str
    names: tuple[str, ...]
    others: tuple[str, ...] = ()


TWIST = Labels("row", ("vx", "vy", "vz", "wx", "wy", "wz"))
POINT = Labels("coordinate", ("x", "y", "z"))


def in_order(name: str, value: Any, labels: Labels | None) -> Any:
    """The value without labels, its entries in the order of ``labels``.

    Args:
        name: the argument's name, for the message.
        value: a mapping, an object like a pandas Series or DataFrame or an xarray DataArray, whose labels are names or
            0-based indices; other values are returned unchanged.
        labels: what the entries are called; None: they have no names.

    Returns:
        A list or an array. The last axis is the one with labels, also of a mapping from names to columns.

    Raises:
        InputError: if a label is missing, unknown or duplicated, or the argument takes no labels.
    """
    own = _own_labels(value)
    if own is None:
        return value
    if labels is None:
        if own == list(range(len(own))) and not isinstance(value, Mapping):
            return np.asarray(value)
        raise InputError(name, f"numbers with the labels {_shown(own)}", "numbers without labels")
    places = _places(name, own, labels)
    if isinstance(value, Mapping):
        return _stacked(name, [value[own[place]] for place in places])
    return np.take(np.asarray(value), places, axis=-1)


def _own_labels(value: Any) -> list[Any] | None:
    """The labels of a value's last axis; None where it has none."""
    if isinstance(value, np.ndarray | list | tuple | str | bytes | int | float):
        return None
    if isinstance(value, Mapping):
        return list(value)
    if hasattr(value, "dims") and hasattr(value, "indexes"):  # xarray
        index = value.indexes.get(value.dims[-1]) if value.dims else None
    else:
        index = getattr(value, "columns", getattr(value, "index", None))  # pandas, polars
    return None if index is None or callable(index) else list(index)


def _stacked(name: str, entries: list[Any]) -> Any:
    """One number for each label, or columns (N,) as an array (N, labels)."""
    try:
        return entries if all(np.ndim(entry) == 0 for entry in entries) else np.stack(entries, axis=-1)
    except ValueError:
        raise InputError(name, "columns of different lengths", "columns of one length") from None


def _places(name: str, own: Sequence[Any], labels: Labels) -> list[int]:
    """Where each of the names is among a value's own labels."""
    found: dict[int, int] = {}
    for place, label in enumerate(own):
        if isinstance(label, str) and label in labels.others:
            continue
        index = _index(label, labels.names)
        if index is None or index in found:
            got = f"the {labels.kind} {label!r}{'' if index is None else ' twice'}"
            raise InputError(name, got, f"a number for each {labels.kind}: {listing(labels.names)}")
        found[index] = place
    for index, label in enumerate(labels.names):
        if index not in found:
            got = f"no number for the {labels.kind} {label!r}, only {_shown(own)}"
            raise InputError(name, got, f"a number for each {labels.kind}: {listing(labels.names)}")
    return [found[index] for index in range(len(labels.names))]


def _index(label: Any, names: tuple[str, ...]) -> int | None:
    """The index that a name or a 0-based index means."""
    if isinstance(label, str):
        return names.index(label) if label in names else None
    if isinstance(label, int | np.integer) and not isinstance(label, bool) and 0 <= label < len(names):
        return int(label)
    return None


def _shown(own: Sequence[Any]) -> str:
    text = ", ".join(map(repr, own[:8]))
    return f"{text}, …" if len(own) > 8 else text or "(none)"
