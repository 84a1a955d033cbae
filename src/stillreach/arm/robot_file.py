"""A robot file on its way in: what it is called, its bytes, and errors that name the place."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stillreach import _door
from stillreach._messages import did_you_mean, listed, short
from stillreach._text import UTF_16_MARKS
from stillreach.errors import RobotFileError

MAX_BYTES = 16 * 2**20
UTF_16 = dict.fromkeys(UTF_16_MARKS, "utf-16") | {b"<\0": "utf-16-le", b"\0<": "utf-16-be"}
"""How files begin that are in UTF-16, with and without a byte order mark."""
SHOWN = 30
"""How many choices a message lists."""


@dataclass(frozen=True)
class RobotFile:
    """The contents of a file, and its name for messages.

    Attributes:
        name: the path as it came, or ``"<text>"`` and its like.
        stem: the file's name without folder and suffix.
        data: its bytes.
        encoding: how the bytes encode text; None leaves that to the file.
        path: a regular file that other files can be relative to, or None.
    """

    name: str
    stem: str
    data: bytes
    encoding: str | None = None
    path: Path | None = None

    def error(self, got: str, expected: str, *, argument: str = "path", **place: Any) -> RobotFileError:
        """An error of this file; ``place`` is its line, element and choices."""
        return RobotFileError(argument, got, expected, self.name, **place)

    def unknown(self, value: Any, what: str, choices: Iterable[str], **place: Any) -> RobotFileError:
        """An error that lists the choices, e.g. ``what="a link"``."""
        names = tuple(choices)
        expected = f"{what}: {listing(names)}{did_you_mean(value, names)}"
        return self.error(shown(value), expected, choices=names, **place)

    def chosen(self, argument: str, value: Any, what: str, choices: Iterable[str]) -> str:
        """The value if it is one of the choices; else RobotFileError lists those that have a name."""
        if isinstance(value, str) and value in choices:
            return value
        raise self.unknown(value, what, filter(None, choices), argument=argument)

    def only(self, ends: tuple[str, ...], what: str) -> str:
        """The one end of a tree, for a tip of None; else RobotFileError lists them."""
        if len(ends) == 1:
            return ends[0]
        expected = f"{what}, because the tree has {len(ends)} ends: {listing(ends)}"
        raise self.error("None", expected, argument="tip", choices=ends)


def read(source: Any, kind: str, *, also: str = "") -> RobotFile:
    """Read a file, or take text that is one.

    Args:
        source: the path of the file; its text, recognised by its first character, ``<``; or an object with ``read``.
        kind: what it should be, for messages: ``"a URDF file"``.
        also: what the caller takes beside files, for messages.

    Raises:
        RobotFileError: there is no such file, it cannot be read, or it is larger than 16 MiB.
    """
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        return _checked(RobotFile("<text>", "arm", source.encode("utf-8", "surrogatepass"), "utf-8"))
    if callable(getattr(source, "read", None)):
        return _checked(_stream(source, kind))
    if not isinstance(source, str | os.PathLike) or not isinstance(os.fspath(source), str):
        raise RobotFileError(
            "path", _door.describe(source), f"the path of {kind}, its text{also} or a file object", "path"
        )
    name = os.fspath(source)
    try:
        path = Path(name)
        if path.exists() and not path.is_file():  # a folder, or a pipe that would never end
            raise RobotFileError("path", "no regular file", kind, name)
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except RobotFileError:
        raise
    except OSError as error:
        raise RobotFileError("path", f"no readable file ({error.strerror})", kind, name) from None
    except ValueError:
        raise RobotFileError("path", f"{_door.describe(name)}, which is no path", kind, "path") from None
    return _checked(RobotFile(name, path.stem or "arm", data, path=path))


def _stream(stream: Any, kind: str) -> RobotFile:
    """All that a file object still holds, bytes or text."""
    named = getattr(stream, "name", None)
    name = named if isinstance(named, str) and named else "<stream>"
    data, encoding = bytearray(), None
    try:
        while len(data) <= MAX_BYTES and (part := stream.read(MAX_BYTES + 1 - len(data))):
            if isinstance(part, str):
                part, encoding = part.encode("utf-8", "surrogatepass"), "utf-8"
            elif not isinstance(part, bytes):
                raise RobotFileError("path", f"{_door.describe(part)} from its read()", f"{kind}: bytes or text", name)
            data += part
    except RobotFileError:
        raise
    except UnicodeDecodeError as error:
        got = f"text that is not {error.encoding}"
        raise RobotFileError("path", got, f"{kind}; open it in binary mode ('rb')", name) from None
    except (OSError, ValueError) as error:
        raise RobotFileError("path", f"no readable stream ({error})", kind, name) from None
    return RobotFile(name, "arm" if name.startswith("<") else Path(name).stem or "arm", bytes(data), encoding)


def _checked(file: RobotFile) -> RobotFile:
    """The file if it is not too large; UTF-16 becomes UTF-8, whatever encoding the text declares."""
    if len(file.data) > MAX_BYTES:
        raise file.error(f"more than {MAX_BYTES // 2**20} MiB", f"a file of at most {MAX_BYTES // 2**20} MiB")
    encoding = next((name for start, name in UTF_16.items() if file.data.startswith(start)), None)
    if file.encoding or encoding is None:
        return file
    try:
        return replace(file, data=file.data.decode(encoding).encode(), encoding="utf-8")
    except UnicodeDecodeError:
        raise file.error("the beginning of UTF-16, and bytes that are not UTF-16", "UTF-8 or UTF-16") from None


def listing(names: tuple[str, ...]) -> str:
    """The names; of many, the first and how many more."""
    return listed(names, SHOWN) or "there is none"


def shown(value: Any) -> str:
    """A value from a file or an argument, short enough for a message."""
    return short(repr(value)) if isinstance(value, str) else _door.describe(value)
