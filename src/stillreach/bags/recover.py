"""A bag that a crash left without its end, whole again."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from stillreach.bags.bag import write_metadata
from stillreach.bags.chunks import ChunkFile, left_in
from stillreach.errors import InputError


class Recovered(NamedTuple):
    """What a broken bag still had.

    Attributes:
        messages: how many.
        seconds: [s] from the first to the last.
        lost: [bytes] at the end of the file that were not whole.
    """

    messages: int
    seconds: float
    lost: int


def recover(source: Path, target: Path, progress: Callable[[int, int], None]) -> Recovered:
    """Writes the whole chunks of a bag into a new one, which appears when it is complete.

    Args:
        source: an MCAP file, or the folder of one.
        target: the new folder.
        progress: called with the bytes that were read and that there are.

    Raises:
        InputError: if there is no such file, it holds no message, or ``target`` exists.
        OSError: if a file cannot be read or written.
    """
    file = _only_file(source)
    if target.exists():
        raise InputError("to", f"{target.name!r}, which exists", "a new folder")
    with tempfile.TemporaryDirectory(dir=target.absolute().parent, prefix=f".{target.name}-") as folder:
        part = Path(folder) / target.name
        part.mkdir()
        made = ChunkFile(part / f"{target.name}.mcap")
        with closing(made):
            try:
                read = _copied(file, made, progress)
            except ValueError:
                expected = "a bag that begins as MCAP does"
                raise InputError("path", f"{file.name!r}, which is no MCAP file", expected) from None
            messages = sum(made.counts.values())
            if not messages:
                raise InputError("path", f"{file.name!r}, without one whole chunk of messages", "a bag with messages")
            made.finish()
        write_metadata(part, made)
        part.rename(target)
    return Recovered(messages, 1e-9 * (made.last - made.first), file.stat().st_size - read)


def _only_file(source: Path) -> Path:
    if not source.exists():
        raise InputError("path", f"{source.name!r}, which does not exist", "an MCAP file, or the folder of one")
    if source.is_file():
        return source
    found = sorted(source.glob("*.mcap"))
    if len(found) != 1:
        raise InputError("path", f"{source.name!r}, a folder with {len(found)} MCAP files", "one; or name the file")
    return found[0]


def _copied(file: Path, made: ChunkFile, progress: Callable[[int, int], None]) -> int:
    """Copies what is whole; how many bytes of the file that were."""
    size = file.stat().st_size
    with file.open("rb") as opened:
        for left in left_in(opened):
            for schema in left.schemas:
                if schema.id not in made.schemas:
                    made.add_schema(schema)
            for channel in left.channels:
                if channel.id not in made.channels:
                    made.add_channel(channel)
            if left.places:
                made.add_packed(left.data, left.size, left.crc, left.compression, left.places)
            progress(opened.tell(), size)
        return opened.tell()
