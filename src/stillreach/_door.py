"""The public door: each argument is checked once, here, before anything is computed with it.

Every function takes the argument's name and its value, and returns the value in the one form that the rest
of the package works with (float64, C order, a read-only copy), or raises InputError with what came and
what was expected. Settings may come as lists, integers or float32; text, booleans, complex numbers, ragged
lists and NaN are never numbers here.
"""

from __future__ import annotations

import math
import operator
import reprlib
from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from stillreach._core import RIGID_TOLERANCE, rigid
from stillreach._labels import POINT as POINT
from stillreach._labels import TWIST as TWIST
from stillreach._labels import Labels, in_order
from stillreach._messages import one_of
from stillreach.errors import InputError

FloatArray = npt.NDArray[np.float64]
Member = TypeVar("Member")


def vector(
    name: str,
    value: Any,
    n: int | None,
    *,
    allow_inf: bool = False,
    minimum: float | None = None,
    default: Any = None,
    one_for_all: bool = True,
    labels: Labels | None = None,
) -> FloatArray:
    """A vector of n numbers; a single number stands for n equal ones, where that is legal.

    Args:
        name: the argument's name, for the message.
        value: what came; None stands for ``default`` where there is one.
        n: how many numbers; None takes a vector of any length (and then no single number).
        allow_inf: whether infinite entries are legal.
        minimum: least legal entry.
        default: what None stands for.
        one_for_all: whether a single number is legal.
        labels: names of the entries; a value with labels of its own is read by them.

    Returns:
        (n,) read-only copy.

    Raises:
        InputError: if the value is invalid.
    """
    if value is None:
        value = default
    kind = "numbers" if allow_inf else "finite numbers"
    at_least = "" if minimum is None else f", each at least {minimum:g}"
    one_for_all = one_for_all and n is not None
    size = "a vector of" if n is None else str(n)
    expected = f"{size} {kind}{' (or one for all)' if one_for_all else ''}{at_least}"
    numbers = _numbers(name, value, expected, labels)
    if numbers.ndim == 0 and one_for_all:
        _refuse_values(name, numbers, expected, allow_inf, minimum)
        numbers = np.full(n or 0, numbers)
    if numbers.ndim != 1 or (n is not None and len(numbers) != n):
        raise InputError(name, describe(value), expected)
    _refuse_values(name, numbers, expected, allow_inf, minimum)
    return frozen(numbers)


def codes(name: str, value: Any, n: int, meaning: str) -> FloatArray:
    """A vector of n integers of at most three digits, as numbers; InputError otherwise."""
    expected = f"{n} integers, {meaning}"
    numbers = _numbers(name, value, expected)
    if numbers.shape != (n,) or not np.all((np.abs(numbers) < 1000) & (numbers == np.rint(numbers))):
        raise InputError(name, describe(value), expected)
    return frozen(numbers)


def matrix(name: str, value: Any, shape: tuple[int | None, int | None], *, allow_inf: bool = False) -> FloatArray:
    """A matrix of the given shape (None: any length there), as a read-only copy; InputError otherwise."""
    kind = "numbers" if allow_inf else "finite numbers"
    sides = ", ".join("any" if side is None else str(side) for side in shape)
    expected = f"a matrix ({sides}) of {kind}"
    numbers = _numbers(name, value, expected)
    fits = numbers.ndim == 2 and all(want in (None, have) for want, have in zip(shape, numbers.shape, strict=True))
    if not fits:
        raise InputError(name, describe(value), expected)
    _refuse_values(name, numbers, expected, allow_inf, None)
    return frozen(numbers)


def configurations(name: str, value: Any, labels: Labels) -> FloatArray:
    """One or many vectors of finite numbers, (..., n), in C order; not copied where that is what came.

    The last axis has a number for each label; a value with labels of its own is read by them.
    """
    n = len(labels.names)
    expected = f"finite numbers in an array (..., {n})"
    numbers = _numbers(name, value, expected, labels)
    if numbers.ndim == 0 or numbers.shape[-1] != n:
        raise InputError(name, describe(value), expected)
    _refuse_values(name, numbers, expected, False, None)
    return _in_place(numbers)


def scalar(name: str, value: Any, *, allow_inf: bool = False) -> float:
    """One number; InputError otherwise."""
    return _scalar(name, value, "a number" if allow_inf else "a finite number", allow_inf)


def positive(name: str, value: Any, *, or_zero: bool = False, allow_inf: bool = False) -> float:
    """One number above zero (``or_zero``: or zero itself); InputError otherwise."""
    if type(value) is float and 0.0 < value < math.inf:
        return value
    expected = "a number of at least 0" if or_zero else "a number above 0"
    if not allow_inf:
        expected = expected.replace("a number", "a finite number")
    number = _scalar(name, value, expected, allow_inf)
    if number < 0 or (number == 0 and not or_zero):
        raise InputError(name, describe(value), expected)
    return number


def count(name: str, value: Any, *, minimum: int = 1) -> int:
    """An integer of at least ``minimum``; InputError otherwise (3.0 and True are not integers)."""
    expected = f"an integer of at least {minimum}"
    try:
        number = operator.index(value)
    except TypeError:
        raise InputError(name, describe(value), expected) from None
    if isinstance(value, (bool, np.bool_)) or number < minimum:
        raise InputError(name, describe(value), expected)
    return number


def members(name: str, values: Any, kind: type[Member], expected: str, *, least: int = 1) -> list[Member]:
    """The values of a list, all of one class; InputError otherwise."""
    try:
        found = list(values)
    except TypeError:
        raise InputError(name, describe(values), expected) from None
    if len(found) < least:
        raise InputError(name, "none", expected)
    for place, value in enumerate(found):
        if not isinstance(value, kind):
            raise InputError(name, f"{describe(value)} at place {place}", expected)
    return found


def choice(name: str, value: Any, choices: Sequence[str]) -> str:
    """One of the given words; InputError otherwise, with the nearest word as a suggestion."""
    if isinstance(value, str) and value in choices:
        return str(value)
    raise InputError(name, describe(value), one_of(choices, value))


def text(name: str, value: Any) -> str:
    """A text that files can hold; InputError for other types, a zero character or half a character of UTF-16."""
    if isinstance(value, str) and not any(letter == "\0" or "\ud800" <= letter <= "\udfff" for letter in value):
        return str(value)
    raise InputError(name, describe(value), "a text without zero characters and lone surrogates")


def unit_vector(name: str, value: Any, n: int = 3) -> FloatArray:
    """A direction: n finite numbers, not all zero, scaled to length 1; InputError otherwise."""
    expected = f"{n} finite numbers, not all zero"
    numbers = _numbers(name, value, expected)
    if numbers.shape != (n,) or not np.any(numbers):
        raise InputError(name, describe(value), expected)
    _refuse_values(name, numbers, expected, False, None)
    with np.errstate(over="ignore", under="ignore"):
        length = np.linalg.norm(numbers)
    if abs(length - 1.0) <= 4 * np.finfo(float).eps:
        return frozen(numbers)  # a unit vector stays what it is, bit for bit
    numbers = numbers / np.max(np.abs(numbers))  # no overflow or underflow in the length
    return frozen(numbers / np.linalg.norm(numbers))


def pose(name: str, value: Any) -> FloatArray:
    """The rigid transform (4 x 4) nearest to the value, which is one to RIGID_TOLERANCE; InputError otherwise."""
    T = matrix(name, value, (4, 4))
    nearest = rigid(T)
    if nearest is not None:
        return frozen(nearest)
    expected = "a rigid transform (4 x 4)"
    if np.max(np.abs(T[3] - (0, 0, 0, 1))) > RIGID_TOLERANCE:
        raise InputError(name, f"the last row {T[3].tolist()}", f"{expected} with the last row [0, 0, 0, 1]")
    R = T[:3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        off = float(np.max(np.abs(R @ R.T - np.eye(3))))
    if off <= RIGID_TOLERANCE:
        raise InputError(name, "a reflection (determinant -1)", f"{expected} with determinant +1")
    raise InputError(
        name, f"a rotation part that is off by {off:.2g}", f"{expected}, orthonormal to {RIGID_TOLERANCE:g}"
    )


def array(name: str, value: Any, expected: str, labels: Labels | None = None) -> FloatArray:
    """Numbers of any shape and value as a float64 array in C order: the same memory where it is that already."""
    numbers = _numbers(name, value, expected, labels)
    return _in_place(numbers)


def describe(value: Any) -> str:
    """What came, in words: short values as they are, arrays by type and shape."""
    if isinstance(value, np.ndarray) and value.ndim > 0:
        return f"a {value.dtype} array of shape {value.shape}"
    if isinstance(value, np.generic | np.ndarray):
        return f"{value.item()!r} ({value.dtype})"
    if isinstance(getattr(value, "shape", None), tuple):
        return f"a {type(value).__name__} of shape {tuple(value.shape)}"
    text = reprlib.repr(value)
    if not isinstance(value, list | tuple):
        return text
    try:
        return f"{text} of shape {np.shape(value)}"
    except ValueError:
        return f"{text}, a ragged {type(value).__name__}"


def frozen(array: npt.ArrayLike) -> FloatArray:
    """A read-only float64 copy in C order."""
    copy = np.array(array, dtype=np.float64, order="C")
    copy.flags.writeable = False
    return copy


def _numbers(name: str, value: Any, expected: str, labels: Labels | None = None) -> FloatArray:
    """The value as a float64 array of any shape, copied only where its type differs."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        return _native(value)
    value = in_order(name, value, labels)
    if is_masked(value):
        if np.any(value.mask):
            raise InputError(name, f"{describe(value)} with masked entries", expected)
        value = np.asarray(value.data)
    try:
        array = np.asarray(value)
    except (ValueError, TypeError, OverflowError):
        raise InputError(name, describe(value), expected) from None
    if array.dtype.kind not in "fiu" or _holds_bool(value):
        raise InputError(name, describe(value), expected)
    with np.errstate(over="ignore"):
        return _native(array.astype(np.float64, copy=False))


def _native(numbers: FloatArray) -> FloatArray:
    """Files give arrays that name the machine's own byte order, which the core does not read."""
    return numbers if numbers.dtype.byteorder == "=" else numbers.view(np.float64)


def is_masked(value: Any) -> bool:
    """Whether the value is an array of ``numpy.ma``: ``numpy.asarray`` shows what lies under its mask."""
    return isinstance(value, np.ma.MaskedArray)


def _in_place(numbers: FloatArray) -> FloatArray:
    """The same memory where the core can read it: in C order and aligned."""
    flags = numbers.flags
    return numbers if flags.c_contiguous and flags.aligned else np.array(numbers, order="C")


def _holds_bool(value: Any) -> bool:
    """Whether a truth value hides among the numbers of a list: NumPy turns [True, 0.5] into [1.0, 0.5]."""
    if isinstance(value, list | tuple):
        return any(_holds_bool(item) for item in value)
    return isinstance(value, bool | np.bool_) or (isinstance(value, np.ndarray) and value.dtype.kind == "b")


def _refuse_values(name: str, numbers: FloatArray, expected: str, allow_inf: bool, minimum: float | None) -> None:
    """Raise InputError naming the first entry that is NaN, infinite or below the minimum."""
    legal = ~np.isnan(numbers) if allow_inf else np.isfinite(numbers)
    if minimum is not None:
        legal &= ~(numbers < minimum)
    if not legal.all():
        index = tuple(int(k) for k in np.argwhere(~legal)[0])
        place = f" at index {index[0] if len(index) == 1 else index}" if index else ""
        raise InputError(name, f"{float(numbers[index])!r}{place}", expected)


def _scalar(name: str, value: Any, expected: str, allow_inf: bool) -> float:
    numbers = _numbers(name, value, expected)
    if numbers.ndim != 0:
        raise InputError(name, describe(value), expected)
    _refuse_values(name, numbers, expected, allow_inf, None)
    return float(numbers)
