"""A bag that a crash left without its end, whole again."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from stillreach._messages import listed
from stillreach.bags.bag import write_metadata
from stillreach.bags.chunks import ChunkFile
from stillreach.bags.salvage import Salvage
from stillreach.errors import InputError


class Recovered(NamedTuple):
    """What a broken bag still had.

    Attributes:
        messages: how many.
        seconds: [s] from the first to the last.
        lost: [bytes] of the file that were not whole.
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
    if not target.absolute().parent.is_dir():
        raise InputError("to", repr(str(target)), "a new folder in a folder that exists")
    with tempfile.TemporaryDirectory(dir=target.absolute().parent, prefix=f".{target.name}-") as folder:
        part = Path(folder) / target.name
        part.mkdir()
        made = ChunkFile(part / f"{target.name}.mcap")
        with closing(made):
            lost = _copied(file, made, progress)
            messages = sum(made.counts.values())
            if not messages:
                raise InputError("path", f"{file.name!r}, without one whole chunk of messages", "a bag with messages")
            made.finish()
        write_metadata(part, made)
        part.rename(target)
    return Recovered(messages, 1e-9 * (made.last - made.first), lost)


def _only_file(source: Path) -> Path:
    if not source.exists():
        raise InputError("path", f"{source.name!r}, which does not exist", "an MCAP file, or the folder of one")
    if source.is_file():
        return source
    metadata = source / "metadata.yaml"
    if metadata.is_file() and "compression_mode: message" in metadata.read_text(encoding="utf-8").lower():
        raise InputError(
            "path", f"{source.name!r}, whose messages are compressed one by one", "plain or compressed chunks"
        )
    found = sorted(source.glob("*.mcap"))
    if len(found) != 1:
        others = listed(sorted(path.name for path in source.iterdir() if path.suffix in (".db3", ".zstd")))
        got = f"{source.name!r}, a folder with {len(found)} MCAP files{f' and {others}' if others else ''}"
        raise InputError("path", got, "a folder with one MCAP file, or the name of one")
    return found[0]


def _copied(file: Path, made: ChunkFile, progress: Callable[[int, int], None]) -> int:
    """Copies what is whole; how many bytes of the file were not."""
    size = file.stat().st_size
    with file.open("rb") as opened:
        try:
            salvage = Salvage(opened)
        except ValueError:
            expected = "a bag that begins as MCAP does"
            raise InputError("path", f"{file.name!r}, which is no MCAP file", expected) from None
        for left in salvage:
            for number, schema in salvage.schemas.items():
                if number not in made.schemas:
                    made.add_schema(schema)
            for number, channel in salvage.channels.items():
                if number not in made.channels:
                    made.add_channel(channel)
            if left.places:
                made.add_packed(left.data, len(left.records), left.crc, left.compression, left.places)
            progress(opened.tell(), size)
    return salvage.lost
