"""The line of each key in a TOML text that Python's parser has accepted."""

from __future__ import annotations

import re
from bisect import bisect_left
from contextlib import suppress

# tokens of values: strings of four kinds, comments, brackets
TOKEN = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'|#[^\n]*|\n\s*|[\[\]{},=.]|[^\s"\'#\[\]{},=.]+',
    re.DOTALL,
)

Key = tuple[str | int, ...]


def line_numbers(text: str) -> dict[Key, int]:
    """The line, from 1 on, of every key, table and list entry, by keys and indices."""
    scanner = _Scanner(text)
    with suppress(IndexError):  # an invalid text after all: line numbers are best effort
        scanner.run()
    return scanner.lines


class _Scanner:
    """Goes through the tokens once."""

    def __init__(self, text: str) -> None:
        self.lines: dict[Key, int] = {}
        self._tables: dict[Key, int] = {}  # arrays of tables: number so far
        self._prefix: Key = ()
        self._tokens = [(match[0], match.start()) for match in TOKEN.finditer(text)]
        self._ends = [match.start() for match in re.finditer("\n", text)]
        self._at = 0

    def run(self) -> None:
        """All statements."""
        while self._at < len(self._tokens):
            before = self._at
            self._statement()
            self._at = max(self._at, before + 1)

    def _statement(self) -> None:
        """A header, a key with its value, or an empty line."""
        token = self._peek()
        if token[0] in "\n#":
            self._at += 1
        elif token == "[":
            self._header()
        else:
            line = self._line()
            self._value(self._noted((*self._prefix, *self._key("=")), line))

    def _header(self) -> None:
        line = self._line()
        self._at += 1
        array = self._peek() == "["
        self._at += array
        key = self._through_arrays(self._key("]"))
        self._at += array
        if array:
            place = self._tables[key] = self._tables.get(key, -1) + 1
            self._noted(key, line)
            key = (*key, place)
        self._prefix = self._noted(key, line)

    def _through_arrays(self, key: Key) -> Key:
        """[a.b] after [[a]] means b of the last a."""
        found: Key = ()
        for place, part in enumerate(key):
            found = (*found, part)
            if place < len(key) - 1 and found in self._tables:
                found = (*found, self._tables[found])
        return found

    def _key(self, end: str) -> Key:
        """A dotted key, including the character that ends it."""
        parts: list[str] = []
        while (token := self._next()) != end:
            if token != ".":
                parts.append(token[1:-1] if token[0] in "\"'" else token)
        return tuple(parts)

    def _value(self, place: Key) -> None:
        """A value, without the character after it."""
        if self._peek() == "[":
            self._list(place)
        elif self._peek() == "{":
            self._table(place)
        else:
            while self._at < len(self._tokens) and self._peek()[0] not in ",]}\n#":
                self._at += 1

    def _list(self, place: Key) -> None:
        self._at += 1
        entry = 0
        while (token := self._peek()) != "]":
            if token[0] in ",\n#}":
                self._at += 1
            else:
                entry_place = (*place, entry)
                self.lines[entry_place] = self._line()
                self._value(entry_place)
                entry += 1
        self._at += 1

    def _table(self, place: Key) -> None:
        self._at += 1
        while (token := self._peek()) != "}":
            if token[0] in ",\n#":
                self._at += 1
            else:
                line = self._line()
                self._value(self._noted((*place, *self._key("=")), line))
        self._at += 1

    def _noted(self, place: Key, line: int) -> Key:
        for length in range(1, len(place) + 1):
            self.lines.setdefault(place[:length], line)
        return place

    def _peek(self) -> str:
        return self._tokens[self._at][0]

    def _next(self) -> str:
        self._at += 1
        return self._tokens[self._at - 1][0]

    def _line(self) -> int:
        return bisect_left(self._ends, self._tokens[self._at][1]) + 1
