"""The motion of a tool from messages of ROS 2 with poses or transforms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach._messages import listed, one_of
from stillreach._rotations import from_quaternions
from stillreach.errors import InputError
from stillreach.recordings.rosbag import POSE, TRANSFORM, TRANSFORMS, each, stamp_of

KINDS = (POSE, TRANSFORM, TRANSFORMS)
"""Types of messages with poses."""


def read(file: Path, topic: str | None, frame: str | None, child: str | None) -> tuple[FloatArray, FloatArray]:
    """Times (K,) [s] and poses (K, 4, 4) [m] of a topic.

    Args:
        file: a bag.
        topic: of PoseStamped, TransformStamped or TFMessage; None: the only one.
        frame: in which the poses are; None: that of the messages, or the root of the transforms.
        child: whose pose transforms tell; None: the only end of their tree.

    Raises:
        InputError: if it is no bag, has not one such topic, or not these frames.
        MissingExtraError: if rosbags is not installed.
    """
    stamps, rows, frames = list[int](), list[FloatArray](), set[str]()
    transforms = list[tuple[int, str, str, FloatArray]]()

    def take(message: Any, received: int) -> None:
        if hasattr(message, "pose"):
            stamps.append(stamp_of(message.header) or received)
            rows.append(_numbers(message.pose.position, message.pose.orientation))
            frames.add(message.header.frame_id)
        for part in getattr(message, "transforms", [message] if hasattr(message, "transform") else []):
            moved, stamp = part.transform, stamp_of(part.header) or received
            transforms.append(
                (stamp, part.header.frame_id, part.child_frame_id, _numbers(moved.translation, moved.rotation))
            )

    each(file, topic, KINDS, take)
    if transforms:
        return _composed(transforms, frame, child)
    if not rows:
        raise InputError("topic", f"no pose in the messages of {file.name}", "poses of a tool")
    if child is not None:
        raise InputError("child", repr(child), f"none for {POSE}, which tells of one")
    if frame is not None and frames != {frame}:
        raise InputError("frame", repr(frame), one_of(sorted(frames)))
    if len(frames) > 1:
        raise InputError("topic", f"poses in {listed(sorted(frames))}", "poses in one frame")
    return _times(np.array(stamps)), _matrices(np.array(rows))


def _composed(
    transforms: list[tuple[int, str, str, FloatArray]], frame: str | None, child: str | None
) -> tuple[FloatArray, FloatArray]:
    """Poses of a frame in another, whenever a transform between them was told; the others as they were told last."""
    parents: dict[str, str] = {}
    for _, parent, name, _ in transforms:
        if parents.setdefault(name, parent) != parent:
            raise InputError(
                "child", f"{name!r} in {parents[name]!r} and later in {parent!r}", "frames that stay where they are"
            )
    if child is None:
        ends = sorted(set(parents) - set(parents.values()))
        if len(ends) != 1:
            raise InputError("child", f"none of {len(ends)} ends of the tree", one_of(ends or sorted(parents)))
        (child,) = ends
    if child not in parents:
        raise InputError("child", repr(child), one_of(sorted(parents), child))
    way, at = [child], parents[child]
    while at != frame and at in parents:
        if at in way:
            raise InputError("child", f"{child!r}, above which {at!r} is its own parent", "a tree of transforms")
        way.append(at)
        at = parents[at]
    if frame is not None and at != frame:
        raise InputError("frame", repr(frame), one_of([*(parents[name] for name in way)], frame))
    used = [one for one in transforms if one[2] in way]
    matrices = _matrices(np.array([numbers for *_, numbers in used]))
    last = {name: T for (_, _, name, _), T in reversed(list(zip(used, matrices, strict=True)))}
    moving = {name for name in way if np.ptp([one[3] for one in used if one[2] == name], axis=0).any()} or set(way)
    found: dict[int, FloatArray] = {}
    for (stamp, _, name, _), T in zip(used, matrices, strict=True):
        last[name] = T
        if name in moving:
            whole = np.eye(4)
            for link in reversed(way):
                whole = whole @ last[link]
            found[stamp] = whole
    return _times(np.array(list(found))), np.array(list(found.values()))


def _numbers(place: Any, turn: Any) -> FloatArray:
    """Place [m], then quaternion w x y z."""
    return np.array([place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z])


def _matrices(numbers: FloatArray) -> FloatArray:
    bad = ~np.isfinite(numbers).all(axis=1)
    if bad.any():
        raise InputError("path", f"numbers that are not finite in pose {int(np.argmax(bad))}", "finite poses")
    T = np.zeros((len(numbers), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = from_quaternions("path", numbers[:, 3:]), numbers[:, :3], 1.0
    return T


def _times(stamps: Any) -> FloatArray:
    times: FloatArray = 1e-9 * (stamps - stamps[0])
    return times
