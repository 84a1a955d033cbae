"""A run as a rosbag2: a folder with an MCAP file and metadata.yaml, which ROS 2 Humble and newer play."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stillreach._files import file_name
from stillreach._rotations import to_quaternions
from stillreach.errors import InputError, MissingExtraError
from stillreach.simulation.record import HEALTHS
from stillreach.status import Health, Status

if TYPE_CHECKING:
    from stillreach.simulation.run import Run

VERSION: Literal[8] = 8
"""Of the metadata: 9 writes the quality of service in words, which Humble refuses."""
BASE, TOOL = "base", "tool"
"""Frames of the poses."""
TOPICS = {
    "/joint_states": ("sensor_msgs/msg/JointState", "true joint positions"),
    "/measured_joint_states": ("sensor_msgs/msg/JointState", "what the encoders said"),
    "/joint_commands": ("sensor_msgs/msg/JointState", "commanded rates"),
    "/tool_pose": ("geometry_msgs/msg/PoseStamped", "true pose of the task's point"),
    "/target_pose": ("geometry_msgs/msg/PoseStamped", "commanded pose of the task's point"),
    "/tool_command": ("geometry_msgs/msg/TwistStamped", "twist given to the law, with feedback"),
    "/tf": ("tf2_msgs/msg/TFMessage", "base to tool"),
    "/diagnostics": ("diagnostic_msgs/msg/DiagnosticArray", "health of the joints and status, when they change"),
    "/robot_description": ("std_msgs/msg/String", "URDF, once"),
}
"""Type and meaning of each topic."""


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a run; a folder of that name is replaced only when the new one is complete.

    Raises:
        MissingExtraError: if rosbags is not installed.
        InputError: if there is something else of that name.
        OSError: if the folder cannot be written.
    """
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError("recordings", "run.save() to a rosbag2") from error
    target = Path(file_name("path", path))
    if target.exists() and not (target / "metadata.yaml").is_file():
        raise InputError(
            "path", f"{target.name!r}, which exists and is no rosbag2", "a new folder, or a rosbag2 to replace"
        )
    store = get_typestore(Stores.ROS2_HUMBLE)
    with tempfile.TemporaryDirectory(dir=target.absolute().parent, prefix=f".{target.name}-") as folder:
        part = Path(folder) / target.name
        with Writer(part, version=VERSION, storage_plugin=StoragePlugin.MCAP) as writer:
            channels = {
                topic: writer.add_connection(topic, kind, typestore=store, offered_qos_profiles=[_quality(topic)])
                for topic, (kind, _) in TOPICS.items()
            }
            for topic, stamp, message in _messages(run, store.types):
                writer.write(channels[topic], stamp, store.serialize_cdr(message, TOPICS[topic][0]))
        if target.exists():
            shutil.rmtree(target)
        part.rename(target)


def _quality(topic: str) -> Any:
    """Reliable; the description is kept for who comes later."""
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    late = topic == "/robot_description"
    durability = QosDurability.TRANSIENT_LOCAL if late else QosDurability.VOLATILE
    endless = QosTime(2147483647, 4294967295)
    return Qos(
        QosHistory.KEEP_LAST,
        1 if late else 10,
        QosReliability.RELIABLE,
        durability,
        endless,
        endless,
        QosLiveliness.AUTOMATIC,
        endless,
        False,
    )


def _messages(run: Run, kinds: Any) -> Iterator[tuple[str, int, Any]]:
    """Topic, time [ns] and message, in the order of time."""
    new = _Maker(kinds)
    names, none = list(run.joint_names), np.zeros(0)
    pose, target = run.pose, run.target
    turns, wanted = to_quaternions(pose[:, :3, :3]), to_quaternions(target[:, :3, :3])
    yield "/robot_description", 0, new("std_msgs/msg/String", run.scenario.arm.to_urdf())
    for tick, time in enumerate(run.time):
        stamp = round(float(time) * 1e9)
        base = new.header(stamp, BASE)
        state = "sensor_msgs/msg/JointState"
        yield "/joint_states", stamp, new(state, base, names, run.q[tick], none, none)
        yield "/measured_joint_states", stamp, new(state, base, names, run.measured[tick], none, none)
        yield "/joint_commands", stamp, new(state, base, names, none, run.rates[tick], none)
        here = new.pose(pose[tick, :3, 3], turns[tick])
        yield "/tool_pose", stamp, new("geometry_msgs/msg/PoseStamped", base, here)
        there = new.pose(target[tick, :3, 3], wanted[tick])
        yield "/target_pose", stamp, new("geometry_msgs/msg/PoseStamped", base, there)
        twist = new("geometry_msgs/msg/Twist", new.vector(run.command[tick, :3]), new.vector(run.command[tick, 3:]))
        yield "/tool_command", stamp, new("geometry_msgs/msg/TwistStamped", base, twist)
        frame = new("geometry_msgs/msg/Transform", new.vector(pose[tick, :3, 3]), new.turn(turns[tick]))
        moved = new("geometry_msgs/msg/TransformStamped", base, TOOL, frame)
        yield "/tf", stamp, new("tf2_msgs/msg/TFMessage", [moved])
        if not tick or _changed(run, tick):
            yield "/diagnostics", stamp, new("diagnostic_msgs/msg/DiagnosticArray", base, _states(run, tick, new))


def _changed(run: Run, tick: int) -> bool:
    """Whether a joint's health, or what the controller knows of it, or the status is another than a tick before."""
    return any(not np.array_equal(a[tick], a[tick - 1]) for a in (run.health, run.known, run.status))


def _states(run: Run, tick: int, new: _Maker) -> list[Any]:
    """The diagnostic status of each joint and of the controller."""
    kind = "diagnostic_msgs/msg/DiagnosticStatus"
    ok, warn, error = 0, 1, 2
    states = []
    for joint, name in enumerate(run.joint_names):
        health, known = int(run.health[tick, joint]), int(run.known[tick, joint])
        level = ok if health == Health.HEALTHY else error
        values = [new("diagnostic_msgs/msg/KeyValue", "known", HEALTHS[known])]
        states.append(new(kind, level, f"joint {name}", HEALTHS[health], name, values))
    flags = Status(int(run.status[tick]))
    text = ", ".join(str(flag.name) for flag in Status if flag and flag in flags) or "OK"
    states.append(new(kind, warn if flags else ok, "stillreach", text, run.scenario.arm.name, []))
    return states


class _Maker:
    """Makes messages by the names of their types."""

    def __init__(self, kinds: Any) -> None:
        self._kinds = kinds

    def __call__(self, kind: str, *values: Any) -> Any:
        return self._kinds[kind](*values)

    def header(self, stamp: int, frame: str) -> Any:
        """Stamp [ns] and frame."""
        time = self("builtin_interfaces/msg/Time", *divmod(stamp, 10**9))
        return self("std_msgs/msg/Header", time, frame)

    def vector(self, values: Any) -> Any:
        """Three numbers."""
        return self("geometry_msgs/msg/Vector3", *map(float, values))

    def turn(self, wxyz: Any) -> Any:
        """A quaternion (w, x, y, z), which messages have as x, y, z, w."""
        w, x, y, z = map(float, wxyz)
        return self("geometry_msgs/msg/Quaternion", x, y, z, w)

    def pose(self, place: Any, wxyz: Any) -> Any:
        """Place [m] and attitude."""
        return self("geometry_msgs/msg/Pose", self("geometry_msgs/msg/Point", *map(float, place)), self.turn(wxyz))
