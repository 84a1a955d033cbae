"""A robot file on its way in: what it is called, its bytes, and errors that name the place."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stillreach import _door
from stillreach.errors import RobotFileError, did_you_mean

MAX_BYTES = 16 * 2**20
SHOWN = 30
"""How many choices a message lists."""


@dataclass(frozen=True)
class RobotFile:
    """The contents of a file, and its name for messages.

    Attributes:
        name: the path as it came, or ``"<text>"``.
        stem: the file's name without folder and suffix.
        data: what is in it.
        encoding: how the bytes encode text; None leaves that to the file.
    """

    name: str
    stem: str
    data: bytes
    encoding: str | None = None

    def error(
        self, got: str, expected: str, *, line: int | None = None, element: str | None = None, argument: str = "path"
    ) -> RobotFileError:
        """An error of this file."""
        return RobotFileError(argument, got, expected, self.name, line, element)

    def unknown(
        self,
        value: Any,
        what: str,
        choices: Iterable[str],
        *,
        line: int | None = None,
        element: str | None = None,
        argument: str = "path",
    ) -> RobotFileError:
        """An error that lists what could have been meant, e.g. ``what="a link"``."""
        names = tuple(choices)
        expected = f"{what}: {listing(names)}{did_you_mean(value, names)}"
        return RobotFileError(argument, shown(value), expected, self.name, line, element, names)


def read(path: Any, kind: str) -> RobotFile:
    """Read a file, or take text that is one.

    Args:
        path: where the file is; or its text, recognised by its first character, ``<``.
        kind: what it should be, for messages: ``"a URDF file"``.

    Raises:
        RobotFileError: there is no such file, it cannot be read, or it is larger than 16 MiB.
    """
    if isinstance(path, str) and path.lstrip("\ufeff \t\r\n").startswith("<"):
        return _checked(RobotFile("<text>", "arm", path.encode("utf-8", "surrogatepass"), "utf-8"))
    if not isinstance(path, str | os.PathLike) or not isinstance(os.fspath(path), str):
        raise RobotFileError("path", _door.describe(path), f"the path of {kind}, or its text", "path")
    name = os.fspath(path)
    try:
        if Path(name).exists() and not Path(name).is_file():  # a folder, or a pipe that would never end
            raise RobotFileError("path", "no regular file", kind, name)
        with Path(name).open("rb") as file:
            return _checked(RobotFile(name, Path(name).stem or "arm", file.read(MAX_BYTES + 1)))
    except RobotFileError:
        raise
    except OSError as error:
        raise RobotFileError("path", f"no readable file ({error.strerror})", kind, name) from None
    except ValueError:
        raise RobotFileError("path", f"{_door.describe(name)}, which is no path", kind, "path") from None


def _checked(file: RobotFile) -> RobotFile:
    if len(file.data) > MAX_BYTES:
        raise file.error(f"more than {MAX_BYTES // 2**20} MiB", f"a file of at most {MAX_BYTES // 2**20} MiB")
    return file


def listing(names: tuple[str, ...]) -> str:
    """The names; of many, the first and how many more."""
    if not names:
        return "there is none"
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(_short(name) for name in names[:SHOWN]) + more


def shown(value: Any) -> str:
    """A value from a file, short enough for a message."""
    return repr(_short(value)) if isinstance(value, str) else _door.describe(value)


def _short(text: str) -> str:
    return text if len(text) <= 80 else f"{text[:77]}..."
