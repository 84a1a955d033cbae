"""A rosbag2 of what an arm did: a folder with an MCAP file and metadata.yaml, which ROS 2 Humble and newer play."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, Self

import numpy as np
import numpy.typing as npt
from mcap.records import Channel, Schema
from rosbags.typesys.store import Typestore
from ruamel.yaml import YAML

from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.bags.chunks import ChunkFile, Index
from stillreach.bags.messages import (
    DIAGNOSTICS,
    JOINT_STATE,
    POSE,
    TEXT,
    TRANSFORMS,
    TWIST,
    Layout,
    Maker,
    Template,
    marks,
    record,
    stretches,
    types,
)
from stillreach.status import Health, Status

VERSION: Literal[8] = 8
"""Of the metadata: 9 writes the quality of service in words, which Humble refuses."""
BASE, TOOL = "base", "tool"
"""Frames of the poses."""
TARGET, DIAGNOSIS, DESCRIPTION = "/target_pose", "/diagnostics", "/robot_description"
ENDLESS = "{nsec: 4294967295, sec: 2147483647}"
QUALITY = (
    "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n"
    f"  deadline: {ENDLESS}\n  lifespan: {ENDLESS}\n  liveliness: 1\n  liveliness_lease_duration: {ENDLESS}\n"
    "  avoid_ros_namespace_conventions: false"
)
"""Reliable; the description is kept for late subscribers."""


Make = Callable[[Maker, Sequence[str], FloatArray], Any]


class Topic(NamedTuple):
    """A topic: the type of its messages; what makes one of numbers, and how many (None: one a joint)."""

    kind: str
    make: Make | None = None
    numbers: int | None = None


def _positions(new: Maker, names: Sequence[str], numbers: FloatArray) -> Any:
    return new.joints(names, numbers, np.zeros(0), BASE)


def _rates(new: Maker, names: Sequence[str], numbers: FloatArray) -> Any:
    return new.joints(names, np.zeros(0), numbers, BASE)


def _pose(new: Maker, names: Sequence[str], numbers: FloatArray) -> Any:
    return new.pose(numbers.tolist(), BASE)


def _twist(new: Maker, names: Sequence[str], numbers: FloatArray) -> Any:
    return new.twist(numbers.tolist(), BASE)


def _frame(new: Maker, names: Sequence[str], numbers: FloatArray) -> Any:
    return new.transform(numbers.tolist(), BASE, TOOL)


TOPICS = {
    "/joint_states": Topic(JOINT_STATE, _positions),
    "/measured_joint_states": Topic(JOINT_STATE, _positions),
    "/joint_commands": Topic(JOINT_STATE, _rates),
    "/tool_pose": Topic(POSE, _pose, 7),
    TARGET: Topic(POSE, _pose, 7),
    "/tool_command": Topic(TWIST, _twist, 6),
    "/tf": Topic(TRANSFORMS, _frame, 7),
    DIAGNOSIS: Topic(DIAGNOSTICS),
    DESCRIPTION: Topic(TEXT),
}


class Bag:
    """A rosbag2 that is being written, chunk by chunk.

    Args:
        folder: its folder, which must not exist.
        arm: whose joints it is about.
        topics: of TOPICS, those that have numbers.
    """

    def __init__(self, folder: Path, arm: Arm, topics: Sequence[str]) -> None:
        self._arm, self._store = arm, types()
        self._new = Maker(self._store)
        folder.mkdir()
        try:
            self._folder, self._file = folder, ChunkFile(folder / f"{folder.name}.mcap")
        except OSError:  # its name is too long
            folder.rmdir()
            raise
        self._channels = {topic: channel for channel, topic in enumerate([*topics, DIAGNOSIS, DESCRIPTION], 1)}
        self._templates = {topic: self._template(topic) for topic in topics}
        self._layouts = dict[frozenset[str], Layout]()
        self._diagnoses = dict[bytes, Template]()
        self._last = b""
        self._ticks = 0
        self._describe()
        # made now rather than while a loop runs
        self._text = self._data(self._new(TEXT, arm.to_urdf()), TEXT)
        self._layout(frozenset(topics))
        self._diagnosis([int(Health.HEALTHY)] * arm.n, [int(Health.HEALTHY)] * arm.n, 0)

    def _template(self, topic: str) -> Template:
        kind, make, size = TOPICS[topic]
        assert make is not None
        numbers = marks(self._arm.n if size is None else size)
        return Template(self._data(make(self._new, self._arm.joint_names, numbers), kind), numbers)

    def _data(self, message: Any, kind: str) -> bytes:
        return bytes(self._store.serialize_cdr(message, kind))

    def _describe(self) -> None:
        """Types and topics, at the beginning of the file."""
        kinds = list(dict.fromkeys(TOPICS[topic].kind for topic in self._channels))
        for number, kind in enumerate(kinds, 1):
            text = self._store.generate_msgdef(kind, ros_version=2)[0]
            self._file.add_schema(Schema(data=text.encode(), encoding="ros2msg", id=number, name=kind))
        for topic, channel in self._channels.items():
            late = topic == DESCRIPTION
            quality = QUALITY.replace("{depth}", "1" if late else "10").replace("{durability}", "1" if late else "2")
            self._file.add_channel(
                Channel(
                    id=channel,
                    message_encoding="cdr",
                    metadata={"offered_qos_profiles": quality},
                    schema_id=1 + kinds.index(TOPICS[topic].kind),
                    topic=topic,
                )
            )

    @property
    def tick_bytes(self) -> int:
        """[bytes] of a tick in the file, with its index."""
        return self._layout(frozenset(self._templates)).size + 16 * len(self._templates)

    def _layout(self, topics: frozenset[str]) -> Layout:
        """The layout of ticks with messages of these topics."""
        if topics not in self._layouts:
            made = {self._channels[topic]: self._templates[topic] for topic in self._templates if topic in topics}
            self._layouts[topics] = Layout(made)
        return self._layouts[topics]

    def add(
        self,
        stamps: npt.NDArray[np.int64],
        numbers: Mapping[str, FloatArray],
        health: npt.NDArray[Any],
        known: npt.NDArray[Any],
        status: npt.NDArray[Any],
    ) -> None:
        """A chunk of ticks.

        Args:
            stamps: (K,) [ns] their times, at least 0.
            numbers: (K, count) of each topic; a tick whose numbers are all NaN has no message of that topic, but
                always one of the first.
            health: (K, n) of the joints.
            known: (K, n) what the controller takes them for.
            status: (K,) of the controller.
        """
        parts, index, at = list[bytes](), dict[int, list[npt.NDArray[Any]]](), 0

        def put(records: bytes, places: Index) -> None:
            nonlocal at
            parts.append(records)
            at += len(records)
            for channel, entries in places.items():
                index.setdefault(channel, []).append(entries)

        if not self._ticks:
            put(*record(self._channels[DESCRIPTION], 0, int(stamps[0]), self._text, at))
        there = np.stack([~np.isnan(rows).all(axis=1) for rows in numbers.values()], axis=1)
        there[:, 0] = True
        for part in stretches(there):
            values = {
                topic: rows[part] for (topic, rows), has in zip(numbers.items(), there[part.start], strict=True) if has
            }
            layout = self._layout(frozenset(values))
            by_channel = {self._channels[topic]: rows for topic, rows in values.items()}
            put(*layout.records(stamps[part], self._ticks + part.start, by_channel, at))
        for tick, diagnosis in self._changes(health, known, status):
            stamp = int(stamps[tick])
            put(*record(self._channels[DIAGNOSIS], self._ticks + tick, stamp, diagnosis.stamped(stamp), at))
        self._ticks += len(stamps)
        self._file.add_chunk(b"".join(parts), {channel: np.concatenate(entries) for channel, entries in index.items()})

    def _changes(
        self, health: npt.NDArray[Any], known: npt.NDArray[Any], status: npt.NDArray[Any]
    ) -> Iterator[tuple[int, Template]]:
        """Ticks at which a joint's health, or what is known of it, or the status changes, with the message."""
        codes = [
            health.astype(np.int8),
            known.astype(np.int8),
            np.ascontiguousarray(status, "<i4")[:, None].view(np.int8),
        ]
        keys = np.concatenate(codes, axis=1)
        for tick in [0, *(np.flatnonzero(np.any(keys[1:] != keys[:-1], axis=1)) + 1).tolist()]:
            key = keys[tick].tobytes()
            if key == self._last:
                continue
            self._last = key
            if key not in self._diagnoses:
                self._diagnoses[key] = self._diagnosis(health[tick].tolist(), known[tick].tolist(), int(status[tick]))
            yield tick, self._diagnoses[key]

    def _diagnosis(self, health: Sequence[int], known: Sequence[int], status: int) -> Template:
        """The state of each joint and of the controller."""
        new, kind = self._new, "diagnostic_msgs/msg/DiagnosticStatus"
        ok, warn, error = 0, 1, 2
        states = []
        for name, now, taken in zip(self._arm.joint_names, health, known, strict=True):
            values = [new("diagnostic_msgs/msg/KeyValue", "known", _word(taken))]
            level = ok if now == Health.HEALTHY else error
            states.append(new(kind, level, f"joint {name}", _word(now), name, values))
        flags = Status(status)
        text = ", ".join(str(flag.name) for flag in Status if flag and flag in flags) or "OK"
        states.append(new(kind, warn if flags else ok, "stillreach", text, self._arm.name, []))
        return Template(self._data(new(DIAGNOSTICS, new.header(BASE), states), DIAGNOSTICS), marks(0))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        """Completes the file and the folder; after an error the file stays without its end."""
        if error is not None:
            self._file.close()
            return
        self._file.finish()
        write_metadata(self._folder, self._file)


def _word(health: int) -> str:
    return Health(health).name.lower()


def _digest(store: Typestore, kind: str, channel: Channel) -> str:
    """The hash of a type of messages, where it is known."""
    known = channel.metadata.get("topic_type_hash", "")
    return known or (store.hash_rihs01(kind) if kind in store.types else "")


def write_metadata(folder: Path, file: ChunkFile) -> None:
    """Writes the metadata.yaml of a folder with one finished file."""
    store = types()
    total = sum(file.counts.values())
    spans = {
        "duration": {"nanoseconds": file.last - file.first if total else 0},
        "starting_time": {"nanoseconds_since_epoch": file.first if total else 0},
        "message_count": total,
    }
    topics = [
        {
            "topic_metadata": {
                "name": channel.topic,
                "type": file.schemas[channel.schema_id].name,
                "serialization_format": channel.message_encoding,
                "offered_qos_profiles": channel.metadata.get("offered_qos_profiles", ""),
                "type_description_hash": _digest(store, file.schemas[channel.schema_id].name, channel),
            },
            "message_count": file.counts[channel.id],
        }
        for channel in file.channels.values()
    ]
    information = {
        "version": VERSION,
        "storage_identifier": "mcap",
        "relative_file_paths": [file.path.name],
        **spans,
        "topics_with_message_count": topics,
        "compression_format": "",
        "compression_mode": "",
        "files": [{"path": file.path.name, **copy.deepcopy(spans)}],
        "custom_data": None,
        "ros_distro": "humble",
    }
    yaml = YAML(typ="safe")
    yaml.default_flow_style = False
    part = folder / ".metadata.yaml"
    with part.open("w", encoding="utf-8") as opened:
        yaml.dump({"rosbag2_bagfile_information": information}, opened)
    part.replace(folder / "metadata.yaml")
