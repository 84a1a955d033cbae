"""A TOML file on its way in: its text, its values, and the line on which each of them stands."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from stillreach._messages import hint
from stillreach._text import decoded
from stillreach.errors import Mistake, ScenarioFileError
from stillreach.simulation.scenario_file.lines import line_numbers

Place = tuple[str | int, ...]
"""Keys and indices that lead to a value: ``("faults", 1, "joint")``."""

MAX_BYTES = 64 * 1024
DEEPEST = 32
TOO_LONG = re.compile(rf"""(?<![\w"'-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){{{DEEPEST}}}""")
"""A dotted key of more parts than that: the parser of Python takes hours for one of some thousands."""
AT_LINE = re.compile(r"\(at line (\d+), column (\d+)\)")


@dataclass(frozen=True)
class Document:
    """A parsed file.

    Args:
        name: the file, as it was given.
        folder: that other files are relative to.
        content: its values.
        text: what they were read from.
    """

    name: str
    folder: Path
    content: dict[str, Any]
    text: str

    @cached_property
    def lines(self) -> dict[Place, int]:
        """Line of each key, table and list entry, from 1 on."""
        return line_numbers(self.text)

    def line(self, place: Place) -> int | None:
        """The line of a value, or of what it stands in; None for the file as a whole."""
        for length in range(len(place), 0, -1):
            if place[:length] in self.lines:
                return self.lines[place[:length]]
        return None


def read(path: Path, name: str) -> Document:
    """Read and parse a file.

    Args:
        path: where it is.
        name: what messages call it.

    Raises:
        ScenarioFileError: it cannot be read, or is not TOML.
    """
    return parse(_text(path, name), name, path.parent)


def parse(text: str, name: str, folder: Path) -> Document:
    """Parse the text of a file; ScenarioFileError if it is not TOML."""
    long_key = TOO_LONG.search(text)
    if long_key:
        line = text.count("\n", 0, long_key.start()) + 1
        raise ScenarioFileError(name, [Mistake("", "a key of too many parts", f"at most {DEEPEST}", line=line)])
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _syntax_error(text, name, str(error)) from None
    except ValueError:
        raise ScenarioFileError(name, [Mistake("", "an integer of too many digits", "a TOML file")]) from None
    except RecursionError:
        raise _too_deep(name) from None
    if _depth(content) > DEEPEST:
        raise _too_deep(name)
    return Document(name, folder, content, text)


def _too_deep(name: str) -> ScenarioFileError:
    return ScenarioFileError(name, [Mistake("", "tables or lists too deep in each other", f"at most {DEEPEST} levels")])


def _text(path: Path, name: str) -> str:
    """The file's text, with line feeds alone at the ends of lines."""
    expected = "a scenario file (TOML, UTF-8)"
    try:
        if not path.exists():
            raise _unreadable(name, "no such file", expected, hint(name, _files_beside(path)))
        if not path.is_file():
            raise OSError(0, "a folder" if path.is_dir() else "no regular file")
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except ScenarioFileError:
        raise
    except OSError as error:
        raise _unreadable(name, error.strerror or "a file that cannot be read", expected) from None
    except ValueError as error:
        raise _unreadable(name, str(error), expected) from None
    if len(data) > MAX_BYTES:
        raise _unreadable(name, f"more than {MAX_BYTES // 1024} KiB", f"{expected} of at most {MAX_BYTES // 1024} KiB")
    try:
        return decoded(data).replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        got = f"byte 0x{data[error.start]:02x}, which is not {error.encoding.upper()}"
        raise ScenarioFileError(name, [Mistake("", got, expected, line=line)]) from None


def _files_beside(path: Path) -> list[str]:
    """TOML files of the folder that one was looked for in."""
    try:
        return sorted(str(file) for file in path.parent.glob("*.toml") if file.is_file())
    except OSError:
        return []


def _unreadable(name: str, got: str, expected: str, hint: str = "") -> ScenarioFileError:
    return ScenarioFileError(name, [Mistake("", got, expected, hint)])


def _syntax_error(text: str, name: str, message: str) -> ScenarioFileError:
    """The one mistake that the parser stopped at, with its line."""
    found = AT_LINE.search(message)
    line = int(found[1]) if found else text.rstrip().count("\n") + 1
    rows = text.split("\n")
    row = rows[min(line, len(rows)) - 1].strip()
    reason = AT_LINE.sub("", message).replace("(at end of document)", "").strip()
    column = f" (column {found[2]})" if found else ""
    got = f"{row[:80]!r}{column}" if row else f"the end of the file{column}"
    return ScenarioFileError(name, [Mistake("", got, f"valid TOML ({reason})", line=line)])


def _depth(content: Any) -> int:
    """How deep tables and lists are in each other, without recursion."""
    depth, level = 0, [content]
    while level and depth <= DEEPEST:
        depth += 1
        inner: list[Any] = []
        for value in level:
            members = value.values() if isinstance(value, dict) else value
            inner += [member for member in members if isinstance(member, dict | list)]
        level = inner
    return depth
