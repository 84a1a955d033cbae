"""Recordings of ROS 2: JointState messages in rosbag2 folders, MCAP and SQLite files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stillreach._messages import listed, one_of
from stillreach.errors import InputError, MissingExtraError
from stillreach.recordings.samples import Samples

JOINT_STATE = "sensor_msgs/msg/JointState"
FILES = (".mcap", ".db3")


def read(file: Path, joints: Sequence[str], named: Mapping[str, str], topic: str | None) -> Samples:
    """Read the joint states of one topic. Messages without any of the joints are left out.

    Times are those of the messages' headers, or of the recorder where headers have none.

    Raises:
        InputError: if it is no bag, has no such messages, or a message has only some of the joints.
        MissingExtraError: if rosbags is not installed.
    """
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError("recordings", f"reading {file.name}") from error
    expected = "a rosbag2 folder, or a whole MCAP or SQLite file of one (`mcap recover` mends a file without an end)"
    stamps: list[int] = []
    rows: list[list[float]] = []
    try:
        with AnyReader(_paths(file), default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            chosen = _chosen(file, reader.connections, topic)
            for connection, received, data in reader.messages(chosen):
                message: Any = reader.deserialize(data, connection.msgtype)
                row = _row(message, joints, named, len(rows))
                if row is not None:
                    stamp = message.header.stamp
                    stamps.append(stamp.sec * 10**9 + stamp.nanosec or received)
                    rows.append(row)
    except InputError:
        raise
    except (AnyReaderError, OSError, ValueError, KeyError, AssertionError) as error:
        raise InputError("path", f"{file.name!r}: {' '.join(str(error).split())[:160]}", expected) from None
    except Exception as error:  # rosbags has no common base of its errors
        if type(error).__module__.partition(".")[0] not in ("rosbags", "sqlite3", "struct"):
            raise
        raise InputError("path", f"{file.name!r}: {' '.join(str(error).split())[:160]}", expected) from None
    if not rows:
        wanted = listed([named.get(joint, joint) for joint in joints])
        raise InputError("joints", f"no message with {wanted} in {file.name}", "messages with every joint of the arm")
    time = np.array([stamp - stamps[0] for stamp in stamps], dtype=np.float64) * 1e-9
    return Samples(time, np.array(rows, dtype=np.float64), ("rad",) * len(joints), "message")


def _paths(file: Path) -> list[Path]:
    """The folder or file; the files of a folder that a crash left without metadata."""
    if file.is_file() or (file / "metadata.yaml").is_file():
        return [file]
    found = sorted(path for path in file.iterdir() if path.suffix in FILES)
    if not found:
        raise InputError(
            "path", f"{file.name!r}, a folder with neither metadata.yaml nor MCAP or SQLite files", "a rosbag2"
        )
    return found


def _chosen(file: Path, connections: Sequence[Any], topic: str | None) -> list[Any]:
    """The connections of the topic."""
    states = [connection for connection in connections if connection.msgtype == JOINT_STATE]
    topics = sorted({connection.topic for connection in states})
    if not topics:
        have = listed(sorted({f"{connection.topic} ({connection.msgtype})" for connection in connections}), 10)
        raise InputError("topic", f"no {JOINT_STATE} in {file.name}, which has {have or 'no topics'}", "joint states")
    if topic is None and len(topics) > 1:
        raise InputError("topic", f"none of {len(topics)} with joint states", one_of(topics))
    if topic is not None and topic not in topics:
        raise InputError("topic", repr(topic), one_of(topics, topic))
    return [connection for connection in states if connection.topic == (topic or topics[0])]


def _row(message: Any, joints: Sequence[str], named: Mapping[str, str], number: int) -> list[float] | None:
    """The joints' positions of a message, or None if it has none of them."""
    place = {name: k for k, name in enumerate(message.name)}
    wanted = [named.get(joint, joint) for joint in joints]
    missing = [name for name in wanted if name not in place]
    if len(missing) == len(wanted):
        return None
    if missing:
        raise InputError(
            "joints",
            f"a message (after {number} whole ones) without {listed(missing)}; it has {listed(message.name)}",
            "every joint in each message; joints={'arm joint': 'name in the file'} says what another name means",
        )
    if len(message.position) != len(message.name):
        raise InputError(
            "path", f"a message with {len(message.position)} positions", f"one for each of {len(message.name)} names"
        )
    return [float(message.position[place[name]]) for name in wanted]
