"""Recordings of ROS 2: JointState messages in rosbag2 folders, MCAP and SQLite files."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from stillreach._messages import listed, one_of
from stillreach.errors import InputError, MissingExtraError
from stillreach.recordings.samples import SI, Samples

if TYPE_CHECKING:
    from stillreach.bags.salvage import Salvage

JOINT_STATE = "sensor_msgs/msg/JointState"
POSE = "geometry_msgs/msg/PoseStamped"
TRANSFORM = "geometry_msgs/msg/TransformStamped"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
STATIC = "_static"
"""Ends the name of the topic of transforms that do not change: they belong to those of the topic without it."""
FILES = (".mcap", ".db3")
MAGIC = b"\x89MCAP0\r\n"


def read(file: Path, joints: Sequence[str], named: Mapping[str, str], topic: str | None) -> Samples:
    """Read the joint states of one topic. Messages without any of the joints are left out.

    Times are those of the messages' headers, or of the recorder where headers have none. Of an MCAP file that a crash
    left without its end, everything up to there is read.

    Raises:
        InputError: if it is no bag, has no such messages, or a message has only some of the joints.
        MissingExtraError: if rosbags is not installed.
    """
    stamps: list[int] = []
    rows: list[list[float]] = []

    def take(message: Any, received: int) -> None:
        row = _row(message, joints, named, len(rows))
        if row is not None:
            stamps.append(stamp_of(message.header) or received)
            rows.append(row)

    cut = each(file, topic, (JOINT_STATE,), take)
    if not rows:
        wanted = listed([named.get(joint, joint) for joint in joints])
        raise InputError("joints", f"no message with {wanted} in {file.name}", "messages with every joint of the arm")
    time = np.array([stamp - stamps[0] for stamp in stamps], dtype=np.float64) * 1e-9
    return Samples(time, np.array(rows, dtype=np.float64), (SI,) * len(joints), "message", cut=cut)


def stamp_of(header: Any) -> int:
    """The stamp [ns]; 0 if it was not set."""
    return int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)


def each(file: Path, topic: str | None, kinds: Sequence[str], take: Callable[[Any, int], None]) -> bool:
    """Gives ``take`` the messages of a topic, which are of one of some types, and when each was received [ns].

    Returns:
        Whether the file has no end.

    Raises:
        InputError: if it is no bag, or has not one such topic.
        MissingExtraError: if rosbags is not installed.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError("recordings", f"reading {file.name}") from error
    store = get_typestore(Stores.ROS2_HUMBLE)
    any_yet = False
    try:
        paths = _paths(file)
        try:
            with AnyReader(paths, default_typestore=store) as reader:
                for connection, received, data in reader.messages(_chosen(file, reader.connections, topic, kinds)):
                    take(reader.deserialize(data, connection.msgtype), received)
                    any_yet = True
        except Exception as error:
            if any_yet or isinstance(error, InputError) or not all(_begins(path) for path in _mcap_files(paths)):
                raise
            for received, data, kind in _left(file, paths, topic, kinds):
                take(store.deserialize_cdr(data, kind), received)
            return True
    except InputError:
        raise
    except Exception as error:  # rosbags and mcap have no common base of their errors
        known = type(error).__module__.partition(".")[0] in ("rosbags", "mcap", "apsw", "sqlite3", "struct")
        if not known and not isinstance(error, OSError | ValueError | KeyError | AssertionError):
            raise
        said = " ".join(str(error).split())[:160]
        raise InputError(
            "path", f"{file.name!r}: {said}", "a rosbag2 folder, or an MCAP or SQLite file of one"
        ) from None
    return False


def _mcap_files(paths: Sequence[Path]) -> list[Path]:
    """The MCAP files of a recording; the paths themselves where there are none, which then are no MCAP."""
    inside = [path for given in paths for path in (given.glob("*.mcap") if given.is_dir() else [given])]
    return sorted(inside) or list(paths)


def _begins(path: Path) -> bool:
    """Whether a file begins as MCAP does."""
    if not path.is_file():
        return False
    with path.open("rb") as opened:
        return opened.read(len(MAGIC)) == MAGIC


def _left(
    file: Path, paths: Sequence[Path], topic: str | None, kinds: Sequence[str]
) -> Iterator[tuple[int, bytes, str]]:
    """Times [ns], messages and types of MCAP files that a crash left without an end, in the order of the times."""
    found: list[tuple[int, bytes, str, str]] = []
    for path in _mcap_files(paths):
        with path.open("rb") as opened:
            salvage = _salvage(file, opened)
            for left in salvage:
                for number, time, data in left.messages():
                    channel = salvage.channels[number]
                    kind = salvage.schemas[channel.schema_id].name
                    if kind in kinds:
                        found.append((time, data, kind, channel.topic))
    topics = [SimpleNamespace(topic=name, msgtype=kind) for name, kind in sorted({one[3:1:-1] for one in found})]
    wanted = {connection.topic for connection in _chosen(file, topics, topic, kinds)}
    return iter(sorted((one[:3] for one in found if one[3] in wanted), key=lambda one: one[0]))


def _salvage(file: Path, opened: IO[bytes]) -> Salvage:
    try:
        from stillreach.bags.salvage import Salvage
    except ImportError as error:
        raise MissingExtraError("recordings", f"reading {file.name}, which has no end,") from error
    return Salvage(opened)


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


def _chosen(file: Path, connections: Sequence[Any], topic: str | None, kinds: Sequence[str]) -> list[Any]:
    """The connections of the topic."""
    fitting = [connection for connection in connections if connection.msgtype in kinds]
    topics = sorted({one.topic for one in fitting if one.msgtype != TRANSFORMS or not one.topic.endswith(STATIC)})
    wanted = "joint states" if JOINT_STATE in kinds else "poses of a tool"
    if not topics:
        have = listed(sorted({f"{connection.topic} ({connection.msgtype})" for connection in connections}), 10)
        raise InputError("topic", f"no {kinds[0]} in {file.name}, which has {have or 'no topics'}", wanted)
    if topic is None and len(topics) > 1:
        raise InputError("topic", f"none of {len(topics)} with {wanted}", one_of(topics))
    if topic is not None and topic not in topics:
        raise InputError("topic", repr(topic), one_of(topics, topic))
    chosen = topic or topics[0]
    return [connection for connection in fitting if connection.topic in (chosen, f"{chosen}{STATIC}")]


def topic_kinds(file: Path) -> dict[str, str]:
    """The type of each topic of a bag, also of one without an end; empty where that cannot be read."""
    try:
        from rosbags.highlevel import AnyReader
    except ImportError as error:
        raise MissingExtraError("recordings", f"reading {file.name}") from error
    with suppress(Exception), AnyReader(_paths(file)) as reader:
        return {connection.topic: connection.msgtype for connection in reader.connections}
    kinds: dict[str, str] = {}
    for path in _mcap_files([file]):
        if _begins(path):
            with path.open("rb") as opened:
                salvage = _salvage(file, opened)
                for _ in salvage:
                    kinds |= {one.topic: salvage.schemas[one.schema_id].name for one in salvage.channels.values()}
    return kinds


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
