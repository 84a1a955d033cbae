"""Messages of ROS 2 whose sizes do not change: all those of many ticks as one structured array."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from mcap.opcode import Opcode
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from stillreach._door import FloatArray
from stillreach._rotations import to_quaternions
from stillreach.bags.chunks import INDEX, MESSAGE, RECORD

JOINT_STATE = "sensor_msgs/msg/JointState"
POSE = "geometry_msgs/msg/PoseStamped"
TWIST = "geometry_msgs/msg/TwistStamped"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
TEXT = "std_msgs/msg/String"
SECONDS, NANOSECONDS = 0x1A2B3C4D, 0x5E6F7A8B
"""A stamp whose place in a message can be found again."""
SECOND = 10**9


def types() -> Typestore:
    """The message types of ROS 2 Humble."""
    return get_typestore(Stores.ROS2_HUMBLE)


class Maker:
    """Makes messages by the names of their types."""

    def __init__(self, store: Typestore) -> None:
        self._kinds: Mapping[str, Any] = store.types

    def __call__(self, kind: str, *values: Any) -> Any:
        """The message of a type."""
        return self._kinds[kind](*values)

    def header(self, frame: str) -> Any:
        """A header with the stamp that can be found again."""
        return self("std_msgs/msg/Header", self("builtin_interfaces/msg/Time", SECONDS, NANOSECONDS), frame)

    def vector(self, values: Sequence[float]) -> Any:
        """Three numbers."""
        return self("geometry_msgs/msg/Vector3", *values)

    def turn(self, values: Sequence[float]) -> Any:
        """A quaternion, x y z w."""
        return self("geometry_msgs/msg/Quaternion", *values)

    def joints(self, names: Sequence[str], positions: FloatArray, rates: FloatArray, frame: str) -> Any:
        """Names with positions, rates or both."""
        return self(JOINT_STATE, self.header(frame), list(names), positions, rates, np.zeros(0))

    def pose(self, values: Sequence[float], frame: str) -> Any:
        """Place, then quaternion x y z w."""
        place = self("geometry_msgs/msg/Point", *values[:3])
        return self(POSE, self.header(frame), self("geometry_msgs/msg/Pose", place, self.turn(values[3:])))

    def twist(self, values: Sequence[float], frame: str) -> Any:
        """Velocity, then angular velocity."""
        twist = self("geometry_msgs/msg/Twist", self.vector(values[:3]), self.vector(values[3:]))
        return self(TWIST, self.header(frame), twist)

    def transform(self, values: Sequence[float], frame: str, child: str) -> Any:
        """Place, then quaternion x y z w, of a child in a frame."""
        moved = self("geometry_msgs/msg/Transform", self.vector(values[:3]), self.turn(values[3:]))
        return self(TRANSFORMS, [self("geometry_msgs/msg/TransformStamped", self.header(frame), child, moved)])


def placed(rotations: FloatArray, places: FloatArray) -> FloatArray:
    """(K, 7) place [m] and quaternion x y z w of rotations (K, 3, 3) and places (K, 3)."""
    turns = to_quaternions(rotations)
    return np.concatenate([places, turns[:, 1:], turns[:, :1]], axis=1)


def marks(count: int) -> FloatArray:
    """Numbers whose places in a message can be found again."""
    return 1.25e-300 * np.arange(1.0, count + 1.0)


class Template:
    """A message whose stamp and one row of numbers change."""

    def __init__(self, data: bytes, numbers: FloatArray) -> None:
        stamp = np.array([SECONDS, NANOSECONDS], dtype="<u4").tobytes()
        self.data = data
        self.stamp = data.index(stamp)
        self.count = len(numbers)
        self.place = data.index(numbers.astype("<f8").tobytes()) if self.count else 0

    def stamped(self, stamp: int) -> bytes:
        """The message at a time [ns], its numbers as they are."""
        head = np.array(divmod(stamp, SECOND), dtype="<u4").tobytes()
        return self.data[: self.stamp] + head + self.data[self.stamp + len(head) :]


class Layout:
    """The records of the messages of a tick, one of each channel."""

    def __init__(self, templates: Mapping[int, Template]) -> None:
        names, formats, offsets, made = list[str](), list[Any](), list[int](), bytearray()

        def field(name: str, form: Any, offset: int) -> None:
            names.append(name)
            formats.append(form)
            offsets.append(offset)

        self.channels = dict[int, int]()
        for channel, template in templates.items():
            self.channels[channel] = start = len(made)
            made += record(channel, 0, 0, template.data, 0)[0]
            field(f"{channel}.sequence", "<u4", start + 11)
            field(f"{channel}.times", ("<u8", (2,)), start + 15)
            begin = start + MESSAGE.size
            field(f"{channel}.stamp", ("<u4", (2,)), begin + template.stamp)
            if template.count:
                field(f"{channel}.numbers", ("<f8", (template.count,)), begin + template.place)
        self.size = len(made)
        self._made = np.frombuffer(bytes(made), dtype=np.uint8)
        self._type = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": self.size})

    def records(
        self, stamps: npt.NDArray[np.int64], sequence: int, numbers: Mapping[int, FloatArray], at: int
    ) -> tuple[bytes, dict[int, npt.NDArray[Any]]]:
        """The records of ticks, and where their messages are.

        Args:
            stamps: (K,) [ns] times of the ticks.
            sequence: of the first tick's messages.
            numbers: (K, count) of each channel that has some.
            at: place of the first record in its chunk.
        """
        raw = np.empty((len(stamps), self.size), dtype=np.uint8)
        raw[:] = self._made
        rows = raw.view(self._type)[:, 0]
        split = np.stack(np.divmod(stamps, SECOND), axis=1)
        index = {}
        for channel, start in self.channels.items():
            rows[f"{channel}.sequence"] = np.arange(sequence, sequence + len(stamps))
            rows[f"{channel}.times"] = stamps[:, None]
            rows[f"{channel}.stamp"] = split
            index[channel] = np.empty(len(stamps), dtype=INDEX)
            index[channel]["time"] = stamps
            index[channel]["offset"] = at + start + self.size * np.arange(len(stamps))
        for channel, values in numbers.items():
            rows[f"{channel}.numbers"] = values
        return raw.tobytes(), index


def record(channel: int, sequence: int, stamp: int, data: bytes, at: int) -> tuple[bytes, dict[int, npt.NDArray[Any]]]:
    """The record of one message at a time [ns], and where it is; ``at`` is its place in its chunk."""
    head = MESSAGE.pack(Opcode.MESSAGE, MESSAGE.size - RECORD.size + len(data), channel, sequence, stamp, stamp)
    return head + data, {channel: np.array([(stamp, at)], dtype=INDEX)}


def stretches(same: npt.NDArray[np.bool_]) -> Iterator[slice]:
    """The longest slices of rows (K, m) that are equal."""
    edges = [0, *(np.flatnonzero(np.any(same[1:] != same[:-1], axis=1)) + 1).tolist(), len(same)]
    return (slice(begin, end) for begin, end in pairwise(edges))
