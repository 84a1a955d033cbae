"""Reading of robot files: name, bytes, and errors with line and element."""

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
"""First bytes of UTF-16 files, with and without a byte order mark."""
SHOWN = 30
"""Largest number of choices in a message."""


@dataclass(frozen=True)
class RobotFile:
    """The contents of a file and its name in messages.

    Attributes:
        name: the path as given, or a word such as ``"<text>"``.
        stem: the file's name without folder and suffix.
        data: its bytes.
        encoding: of the bytes; None: as the file declares.
        path: the regular file, to which other paths may be relative; or None.
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
        """The value, if it is one of the choices; otherwise raises RobotFileError with the named ones."""
        if isinstance(value, str) and value in choices:
            return value
        raise self.unknown(value, what, filter(None, choices), argument=argument)

    def only(self, ends: tuple[str, ...], what: str) -> str:
        """The only end of a tree, for a tip of None; raises RobotFileError with all ends if there are several."""
        if len(ends) == 1:
            return ends[0]
        expected = f"{what}, because the tree has {len(ends)} ends: {listing(ends)}"
        raise self.error("None", expected, argument="tip", choices=ends)


def read(source: Any, kind: str, *, also: str = "") -> RobotFile:
    """Read a file, from a path, a text or a file object.

    Args:
        source: the path of the file; its text, recognised by its first character, ``<``; or an object with ``read``.
        kind: expected contents, for messages: ``"a URDF file"``.
        also: other sources that the caller accepts, for messages.

    Raises:
        RobotFileError: if the file is missing, cannot be read, or is larger than 16 MiB.
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
        if path.exists() and not path.is_file():  # a folder, or a pipe that may never end
            raise RobotFileError("path", "a path that is not a regular file", kind, name)
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except RobotFileError:
        raise
    except OSError as error:
        raise RobotFileError("path", f"no readable file ({error.strerror})", kind, name) from None
    except ValueError:
        raise RobotFileError("path", f"{_door.describe(name)}, which is not a path", kind, "path") from None
    return _checked(RobotFile(name, path.stem or "arm", data, path=path))


def _stream(stream: Any, kind: str) -> RobotFile:
    """The rest of a file object, bytes or text."""
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
    """The names; of many, the first and the number of others."""
    return listed(names, SHOWN) or "none exist"


def shown(value: Any) -> str:
    """A value from a file or an argument, short enough for a message."""
    return short(repr(value)) if isinstance(value, str) else _door.describe(value)
