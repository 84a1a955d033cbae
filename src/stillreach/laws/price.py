"""The price of a task error: one number, one for each part of the task, or a preset by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach import _door
from stillreach._forms import Either, Number, Word
from stillreach._lists import Named
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.task import Weights

ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")
GROUPS = {"position": ROWS[:3], "orientation": ROWS[3:]}
MOST_PARTS = 3
EXPECTED = (
    "a number above 0, a pair (position, orientation), prices by rows such as "
    "{'position': 100, 'wx wy': 8, 'wz': 1}, 'position-first', or None"
)
POSITION_FIRST = {"position": 110.0, "orientation": 7.0}
"""The preset: keeps the position and lets the orientation give way, by at most CEILING times the typical rate."""
CEILING, BEYOND = 0.3, 80.0
"""Of the preset: the orientation error rate at its own price, and the price of the rest."""

_NAMES = "position|orientation|[vw][xyz]"
_PRICE = Number(above=0.0)
FORM = Either(
    _PRICE,
    Word("none", "position-first", none="none"),
    Named(_PRICE, f"^({_NAMES})( +({_NAMES}))*$", MOST_PARTS, "prices by rows such as position = 100, orientation = 8"),
)
"""The form of a price in files and on the command line."""


class Prices(Mapping[str, float]):
    """Prices by rows: a mapping that cannot change, so that a law has a hash."""

    __slots__ = ("_prices",)

    def __init__(self, prices: Mapping[str, float]) -> None:
        self._prices = dict(prices)

    def __getitem__(self, rows: str) -> float:
        return self._prices[rows]

    def __iter__(self) -> Iterator[str]:
        return iter(self._prices)

    def __len__(self) -> int:
        return len(self._prices)

    def __hash__(self) -> int:
        return hash(frozenset(self._prices.items()))

    def __repr__(self) -> str:
        return repr(self._prices)


Price = float | str | tuple[float, float] | Mapping[str, float] | None


def checked(price: Any) -> Price:
    """The price as a number, a word, a mapping by rows, or None.

    Raises:
        InputError: if the price is invalid.
    """
    if price is None or (isinstance(price, str) and price == "position-first"):
        return price
    if isinstance(price, Mapping):
        return _by_rows(price)
    if isinstance(price, tuple | list):
        if len(price) != 2:
            raise InputError("price", _door.describe(price), EXPECTED)
        return _by_rows(dict(zip(GROUPS, price, strict=True)))
    if isinstance(price, str):
        raise InputError("price", repr(price), EXPECTED)
    return _door.positive("price", price)


def parts(price: Price, rows: Sequence[str], reach: float | None, weights: Weights) -> dict[str, Any]:
    """The parts of a task and their prices, as arguments of the core's Law.

    Args:
        price: as ``checked`` returns it.
        rows: name of each task row, ``vx`` to ``wz``, or ``v`` and ``w`` if only the kind is known.
        reach: [m] a length typical of the arm; a part of v rows alone costs price / reach.
        weights: units and weights of the task.

    Raises:
        InputError: if a row has no price, a part of v rows has no reach, or weights couple parts.
    """
    if price is None:
        return {}
    if isinstance(price, float):
        return {"part": [0] * len(rows), "price": [price]}
    by_rows: Mapping[str, float] = POSITION_FIRST if isinstance(price, str) else price  # type: ignore[assignment]
    numbers = [_part_of(row, by_rows) for row in rows]
    used = sorted(set(numbers))
    keys = list(by_rows)
    prices = []
    for number in used:
        own = [row for row, of in zip(rows, numbers, strict=True) if of == number]
        value = float(by_rows[keys[number]])
        prices.append(value * _per_reach(reach, weights) if all(row[0] == "v" for row in own) else value)
    _check_coupling(weights, rows, numbers)
    settings: dict[str, Any] = {"part": [used.index(number) for number in numbers], "price": prices}
    if isinstance(price, str) and keys.index("orientation") in used and len(used) > 1:
        settings |= {"capped": used.index(keys.index("orientation")), "ceiling": CEILING, "beyond": BEYOND}
    return settings


def _by_rows(price: Mapping[Any, Any]) -> Prices:
    """Prices by groups of rows, each row once."""
    seen: list[str] = []
    result: dict[str, float] = {}
    for key, value in price.items():
        names = _rows_of(key)
        if names is None or set(names) & set(seen):
            expected = f"position, orientation or names of rows ({' '.join(ROWS)}), each row once"
            raise InputError("price", f"the rows {key!r}", expected)
        seen += names
        result[" ".join(str(key).split())] = _door.positive(f"price[{key!r}]", value)
    if not 1 <= len(result) <= MOST_PARTS:
        raise InputError("price", f"{len(result)} parts", f"1 to {MOST_PARTS} parts")
    return Prices(result)


def _rows_of(key: Any) -> tuple[str, ...] | None:
    if not isinstance(key, str):
        return None
    names = tuple(row for word in key.split() for row in GROUPS.get(word, (word,)))
    return names if names and len(set(names)) == len(names) and set(names) <= set(ROWS) else None


def _part_of(row: str, by_rows: Mapping[str, float]) -> int:
    """The index of the part of a row."""
    for number, key in enumerate(by_rows):
        names = _rows_of(key) or ()
        if row in names or (row in ("v", "w") and {name[0] for name in names} == {row} and len(names) == 3):
            return number
    expected = f"a price for each row of the task; it has prices for {', '.join(by_rows)}"
    raise InputError("price", f"no price for the row {row}", expected)


def _per_reach(reach: float | None, weights: Weights) -> float:
    """Factor from a price per reach to one in the units of the weights."""
    if reach is None:
        expected = "a length typical of the arm [m], because the price has a part of v rows alone"
        raise InputError("length", "None", expected)
    length = reach if np.isfinite(reach) and reach > 0.0 else 1.0
    return weights.length / (length * weights.angle)


def _check_coupling(weights: Weights, rows: Sequence[str], numbers: Sequence[int]) -> None:
    """Raises InputError for weights between rows of different parts, which have no separate errors."""
    full = weights.task
    if full is None or full.ndim == 1:
        return
    if set(rows) <= set(ROWS) and len(full) == len(ROWS):
        kept = [ROWS.index(row) for row in rows]
        full = full[np.ix_(kept, kept)]
    if len(full) != len(rows):  # refused where it is used
        return
    apart = np.not_equal.outer(np.asarray(numbers), np.asarray(numbers))
    if np.any(full[apart] != 0.0):
        expected = "no weight between rows that have different prices"
        raise InputError("weights.task", "a weight between rows of different parts", expected)
