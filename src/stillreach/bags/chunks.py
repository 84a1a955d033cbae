"""An MCAP file of whole chunks; what was written before a crash is still there (MCAP format specification, 2022)."""

from __future__ import annotations

import struct
import tempfile
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
RECORD = struct.Struct("<BQ")
"""What a record begins with: its kind and its length."""
MESSAGE = struct.Struct("<BQHIQQ")
"""What the record of a message begins with: kind, length, channel, sequence, times of log and publication [ns]."""
INDEX = np.dtype([("time", "<u8"), ("offset", "<u8")])
Index = Mapping[int, npt.NDArray[Any]]
"""(K,) of type INDEX by channel: time [ns] and place of each message in the chunk."""


class ChunkFile:
    """Writes an MCAP file. Each chunk is handed to the operating system at once."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.counts: dict[int, int] = {}
        self.first, self.last = 2**64 - 1, 0
        self._file = path.open("xb", buffering=0)
        self._at = 0
        self._summary = tempfile.TemporaryFile(dir=path.parent)  # noqa: SIM115 - of the chunks, which may be very many
        self._chunks = 0
        self._put(MAGIC)
        self._record(Header(profile="ros2", library="stillreach"))

    def add_schema(self, schema: Schema) -> None:
        """A type of messages; before its channels."""
        self.schemas[schema.id] = schema
        self._record(schema)

    def add_channel(self, channel: Channel) -> None:
        """A topic; before its messages."""
        self.channels[channel.id] = channel
        self.counts.setdefault(channel.id, 0)
        self._record(channel)

    def add_chunk(self, records: bytes, index: Index) -> None:
        """Records of messages, and where they are."""
        index = {channel: entries for channel, entries in index.items() if len(entries)}
        self.add_packed(records, len(records), zlib.crc32(records), "", index)

    def add_packed(self, data: bytes, size: int, crc: int, compression: str, index: Index) -> None:
        """A chunk as it is in a file: compressed data, and the size [bytes] and check sum of what is in it."""
        first = min((int(np.min(entries["time"])) for entries in index.values()), default=0)
        last = max((int(np.max(entries["time"])) for entries in index.values()), default=0)
        start = self._at
        word = compression.encode()
        head = struct.pack(f"<QQQII{len(word)}sQ", first, last, size, crc, len(word), word, len(data))
        self._put(RECORD.pack(Opcode.CHUNK, len(head) + len(data)), head, data)
        end = self._at
        offsets = {}
        for channel, entries in index.items():
            offsets[channel] = self._at
            body = np.ascontiguousarray(entries, INDEX).tobytes()
            self._put(RECORD.pack(Opcode.MESSAGE_INDEX, 6 + len(body)), struct.pack("<HI", channel, len(body)), body)
            self.counts[channel] = self.counts.get(channel, 0) + len(entries)
        if index:
            self.first, self.last = min(self.first, first), max(self.last, last)
        self._chunks += 1
        entry = ChunkIndex(
            chunk_length=end - start,
            chunk_start_offset=start,
            compression=compression,
            compressed_size=len(data),
            message_end_time=last,
            message_index_length=self._at - end,
            message_index_offsets=offsets,
            message_start_time=first,
            uncompressed_size=size,
        )
        self._summary.write(_bytes(entry))

    def finish(self) -> None:
        """Writes the summary, with which readers begin, and closes the file."""
        self._record(DataEnd(0))
        start = self._at
        total = sum(self.counts.values())
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(self.channels),
            channel_message_counts=dict(self.counts),
            chunk_count=self._chunks,
            message_count=total,
            message_end_time=self.last,
            message_start_time=self.first if total else 0,
            metadata_count=0,
            schema_count=len(self.schemas),
        )
        offsets = []

        def group(kind: Opcode, parts: Iterable[bytes]) -> None:
            begin = self._at
            for part in parts:
                self._put(part)
            if self._at > begin:
                offsets.append(SummaryOffset(kind, begin, self._at - begin))

        group(Opcode.SCHEMA, map(_bytes, self.schemas.values()))
        group(Opcode.CHANNEL, map(_bytes, self.channels.values()))
        group(Opcode.STATISTICS, [_bytes(statistics)])
        self._summary.seek(0)
        group(Opcode.CHUNK_INDEX, iter(lambda: self._summary.read(2**20), b""))
        summary_offsets = self._at
        for record in offsets:
            self._record(record)
        self._record(Footer(summary_start=start, summary_offset_start=summary_offsets, summary_crc=0))
        self._put(MAGIC)
        self.close()

    def close(self) -> None:
        """Closes the file without a summary."""
        self._file.close()
        self._summary.close()

    def _record(self, record: McapRecord) -> None:
        self._put(_bytes(record))

    def _put(self, *parts: bytes) -> None:
        left = memoryview(b"".join(parts))
        self._at += len(left)
        while left:
            left = left[self._file.write(left) :]


def _bytes(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
