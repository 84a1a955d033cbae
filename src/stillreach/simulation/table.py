"""Tables of numbers from CSV files with column names."""

from __future__ import annotations

import csv
import io
from array import array
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from stillreach._door import FloatArray
from stillreach._text import decoded
from stillreach.errors import InputError

LARGEST_FILE = 64 * 2**20
LARGEST_NUMBER = 1e12
LONGEST_LINE = 10_000
SEPARATORS = ",;\t|"
"""Column separators, besides spaces; the first one in the line of names is used."""
COMMA_AND_POINT = str.maketrans(",.", ".,")
"""Converts a decimal comma to a point; a decimal point becomes invalid."""


def read_table(
    path: Path,
    wanted: Callable[[list[str]], set[str]],
    columns: str,
    *,
    others: bool = False,
    lines: list[int] | None = None,
) -> tuple[list[str], FloatArray]:
    """Names of the columns and the numbers below them, (rows, columns).

    Args:
        path: the file.
        wanted: returns the required names, given the names in the file.
        columns: the required names in words.
        others: whether there may be further columns, which are not read.
        lines: gets the number of each row's line.

    Raises:
        InputError: if the file is missing or not such a table; the message names the line.
    """
    name = str(path)
    text = _text(path)
    separator = _separator(_lines(name, text))
    decimal = "," if separator != "," and "," in text else "."
    numbers, names, places = array("d"), list[str](), list[int]()
    count = 0
    try:
        for count, (line, row) in enumerate(_rows(_lines(name, text), separator)):
            if count:
                if lines is not None:
                    lines.append(line)
                numbers.extend(_numbers(f"{name}:{line}", row, names, places, decimal))
                continue
            names = [entry.strip() for entry in row]
            must = wanted(names)
            places = [place for place, entry in enumerate(names) if entry in must]
            if len(places) != len(must) or (len(names) > len(must) and not others):
                raise InputError(name, f"the columns {', '.join(names[:20])[:200]}", columns)
    except csv.Error as error:
        raise InputError(name, str(error), "a CSV file") from None
    if not count:
        raise InputError(
            name, f"{int(bool(names))} lines", f"a line with the columns ({columns}) and a line for each pose"
        )
    return [names[place] for place in places], np.array(numbers).reshape(count, len(places))


def _text(path: Path) -> str:
    name, expected = str(path), f"a CSV file of at most {LARGEST_FILE // 2**20} MiB"
    try:
        if not path.is_file():
            raise OSError(0, "a folder or a device" if path.exists() else "no such file")
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
        if len(data) > LARGEST_FILE:
            raise OSError(0, f"more than {LARGEST_FILE // 2**20} MiB")
        return decoded(data)
    except UnicodeDecodeError as error:
        got = f"bytes that are not {error.encoding.upper()}"
        raise InputError(name, got, "a CSV file in UTF-8, or in UTF-16 with a byte order mark") from None
    except OSError as error:
        raise InputError(name, error.strerror or "a file that cannot be read", expected) from None
    except ValueError as error:
        raise InputError(name, str(error), "the path of a CSV file") from None


def _lines(name: str, text: str) -> Iterator[str]:
    """The lines of a text with any line ends; raises InputError for one that is too long."""
    for number, line in enumerate(io.StringIO(text, newline=None), 1):
        length = len(line.rstrip("\n"))
        if length > LONGEST_LINE:
            raise InputError(f"{name}:{number}", f"a line of {length} characters", f"at most {LONGEST_LINE}")
        yield line


def _separator(lines: Iterator[str]) -> str:
    """The column separator of a table; a space means any white space."""
    names = next((line for line in lines if line.strip()), "")
    return next((separator for separator in SEPARATORS if separator in names), " ")


def _rows(lines: Iterator[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """The non-empty lines, split into entries, with their numbers from 1 on."""
    if separator == " ":
        yield from ((number, line.split()) for number, line in enumerate(lines, 1) if line.strip())
        return
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    yield from ((reader.line_num, row) for row in reader if any(entry.strip() for entry in row))


def _numbers(line: str, row: list[str], names: list[str], places: list[int], decimal: str) -> list[float]:
    """The numbers of a line in some of its columns; with a decimal comma, points are an error."""
    kind = " with decimal commas" if decimal == "," else ""
    if len(row) != len(names):
        raise InputError(line, ", ".join(row[:20])[:80], f"{len(names)} numbers{kind}")
    numbers = []
    for place in places:
        entry = row[place].translate(COMMA_AND_POINT) if decimal == "," else row[place]
        got = f"{row[place][:80]!r} in column {names[place][:80]}"
        try:
            number = float(entry)
        except ValueError:
            raise InputError(line, got, f"a number{kind}") from None
        if not abs(number) < LARGEST_NUMBER:
            raise InputError(line, got, f"a finite number below {LARGEST_NUMBER:g}")
        numbers.append(number)
    return numbers
