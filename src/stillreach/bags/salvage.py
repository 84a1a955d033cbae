"""What is whole in an MCAP file that a crash or a bad disk left."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from io import BytesIO
from typing import IO, Any, NamedTuple

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.stream_reader import get_chunk_data_stream

from stillreach.bags.chunks import INDEX, MAGIC, MESSAGE, RECORD, Index

LOOSE = 2**20
"""[bytes] of messages outside chunks that become one chunk."""


class Left(NamedTuple):
    """A chunk that is whole: as it is stored, and the records in it with the places of the messages."""

    data: bytes
    crc: int
    compression: str
    records: bytes
    places: Index

    def messages(self) -> Iterator[tuple[int, int, bytes]]:
        """Channel, time [ns] and data of each message."""
        for channel, entries in self.places.items():
            for time, at in entries.tolist():
                _, length, *_ = MESSAGE.unpack_from(self.records, at)
                yield channel, time, self.records[at + MESSAGE.size : at + RECORD.size + length]


class Salvage:
    """The whole chunks of a file, one after the other; messages outside chunks come as chunks of their own.

    What is not as it was written, by its check sum, is left out and counted.

    Args:
        file: opened at its beginning.

    Raises:
        ValueError: if the file does not begin as MCAP does.
    """

    def __init__(self, file: IO[bytes]) -> None:
        if file.read(len(MAGIC)) != MAGIC:
            raise ValueError("no MCAP file")
        self._file, self._end = file, os.fstat(file.fileno()).st_size
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.lost = 0
        """[bytes] that were not whole, so far."""

    def __iter__(self) -> Iterator[Left]:
        loose = bytearray()
        for kind, body in self._records():
            whole = RECORD.pack(kind, len(body)) + body
            if kind in (Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE):
                if self._walked(whole) is None:
                    self.lost += len(whole)
                else:
                    loose += whole
            if loose and (kind == Opcode.CHUNK or len(loose) > LOOSE):
                yield from self._of_loose(loose)
            if kind == Opcode.CHUNK:
                found = self._chunk(body)
                if found is None:
                    self.lost += len(whole)
                else:
                    yield found
        yield from self._of_loose(loose)

    def _of_loose(self, loose: bytearray) -> Iterator[Left]:
        records = bytes(loose)
        loose.clear()
        places = self._walked(records)
        if places:
            yield Left(records, zlib.crc32(records), "", records, places)

    def _records(self) -> Iterator[tuple[int, bytes]]:
        """Kind and content of the records that are there as a whole, up to the summary."""
        file = self._file
        while len(head := file.read(RECORD.size)) == RECORD.size:
            kind, length = RECORD.unpack(head)
            if kind == Opcode.DATA_END:  # a summary follows, and no message
                return
            if kind == 0 or length > self._end - file.tell():
                break
            yield kind, file.read(length)
        self.lost += self._end - file.tell() + len(head)

    def _chunk(self, body: bytes) -> Left | None:
        """A chunk, or None where its content is not what was written."""
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(body)))
            stream, size = get_chunk_data_stream(chunk, validate_crc=True)
            records = stream.read(size)
        except Exception:  # of the decompressors, which have no common base, and of the check sum
            return None
        places = self._walked(records)
        if places is None:
            return None
        return Left(chunk.data, chunk.uncompressed_crc, chunk.compression, records, places)

    def _walked(self, records: bytes) -> dict[int, Any] | None:
        """Where the messages are among records, by channel; None where these are not whole. Takes types and topics."""
        places: dict[int, list[tuple[int, int]]] = {}
        at = 0
        while at + RECORD.size <= len(records):
            kind, length = RECORD.unpack_from(records, at)
            end = at + RECORD.size + length
            if end > len(records):
                return None
            if kind == Opcode.MESSAGE:
                if length < MESSAGE.size - RECORD.size:
                    return None
                _, _, channel, _, time, _ = MESSAGE.unpack_from(records, at)
                if channel not in self.channels:
                    return None
                places.setdefault(channel, []).append((time, at))
            elif kind in (Opcode.SCHEMA, Opcode.CHANNEL) and not self._take(kind, records[at + RECORD.size : end]):
                return None
            at = end
        if at != len(records):
            return None
        return {channel: np.array(entries, dtype=INDEX) for channel, entries in places.items()}

    def _take(self, kind: int, body: bytes) -> bool:
        """Takes a type or a topic; whether it is whole."""
        stream = ReadDataStream(BytesIO(body))
        try:
            if kind == Opcode.SCHEMA:
                schema = Schema.read(stream)
                self.schemas.setdefault(schema.id, schema)
                return len(body) > 0
            channel = Channel.read(stream)
        except Exception:  # of mcap, which has no common base of its errors
            return False
        if channel.schema_id not in self.schemas:
            return False
        self.channels.setdefault(channel.id, channel)
        return True
