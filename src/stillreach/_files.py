"""Files that are written whole or not at all."""

from __future__ import annotations

import errno
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from stillreach import _door
from stillreach.errors import InputError

KINDS = {stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device", stat.S_IFBLK: "a device"}


def file_name(argument: str, value: Any) -> str:
    """The name of a file as text; InputError where the value is not a path."""
    if isinstance(value, str | bytes | os.PathLike):
        name = os.fsdecode(value)
        if "\0" not in name:
            return name
    raise InputError(argument, _door.describe(value), "the name of a file")


@contextmanager
def new_file(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A binary file to write and read, which appears at ``path`` once the block ends without an error.

    A file of that name is replaced and its permissions are kept; a link stays, and the file it points to is replaced.
    Until then the new file has no name, where the file system can do that, so that a killed process leaves nothing.

    Raises:
        InputError: ``path`` is not a path, or a pipe, socket or device.
        OSError: the file cannot be written; ``filename`` is ``path``.
    """
    name = file_name("path", path)
    target = Path(os.path.realpath(name))  # of a link that leads nowhere, too
    part = None
    try:
        permissions = _permissions(name)
        handle, part = _opened(target.parent)
        with os.fdopen(handle, "w+b") as file:
            yield file
            file.flush()
            os.fsync(handle)
            if permissions is not None:
                os.fchmod(handle, permissions)
            part = part or _named(handle, target.parent)
            part.replace(target)
    except BaseException as error:
        if part:
            part.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno:
            raise OSError(error.errno, os.strerror(error.errno), name) from error
        raise


def _permissions(name: str) -> int | None:
    """Permission bits of the existing file, or None."""
    try:
        mode = Path(name).stat().st_mode
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), name)
    if not stat.S_ISREG(mode):
        kind = KINDS.get(stat.S_IFMT(mode), "no file")
        raise InputError("path", f"{name!r}, which is {kind}", "a regular file or a new name")
    return stat.S_IMODE(mode)


def _opened(folder: Path) -> tuple[int, Path | None]:
    """Descriptor of an empty file in the folder, and its name; None where it has none yet."""
    if hasattr(os, "O_TMPFILE") and Path("/proc/self/fd").is_dir():
        with suppress(OSError):  # a file system that cannot do it, or an error that comes again below
            return os.open(folder, os.O_TMPFILE | os.O_RDWR, 0o666), None
    part = _free_name(folder)
    return os.open(part, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o666), part


def _named(handle: int, folder: Path) -> Path:
    """A name in the folder for a file without one."""
    part = _free_name(folder)
    os.link(f"/proc/self/fd/{handle}", part, src_dir_fd=handle)  # with a descriptor, Python follows the link
    return part


def _free_name(folder: Path) -> Path:
    return folder / f".stillreach-{secrets.token_hex(8)}.part"
