"""A run as a rosbag2."""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stillreach._files import file_name
from stillreach.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from stillreach.simulation.run import Run

CHUNK = 1000
"""Ticks of a chunk."""
TOPICS = {
    "/joint_states": "true joint positions",
    "/measured_joint_states": "what the encoders said",
    "/joint_commands": "commanded rates",
    "/tool_pose": "true pose of the task's point",
    "/target_pose": "commanded pose of the task's point",
    "/tool_command": "twist given to the law, with feedback",
    "/tf": "base to tool",
}
"""Meaning of each topic that has numbers."""


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a run; a folder of that name is replaced only when the new one is complete.

    Raises:
        MissingExtraError: if rosbags is not installed.
        InputError: if there is something else of that name.
        OSError: if the folder cannot be written.
    """
    try:
        from stillreach.bags.bag import TARGET, Bag
        from stillreach.bags.messages import placed
    except ImportError as error:
        raise MissingExtraError("recordings", "run.save() to a rosbag2") from error
    target = Path(file_name("path", path))
    if target.exists() and not (target / "metadata.yaml").is_file():
        raise InputError(
            "path", f"{target.name!r}, which exists and is no rosbag2", "a new folder, or a rosbag2 to replace"
        )
    stamps = np.rint(run.time * 1e9).astype(np.int64)
    with tempfile.TemporaryDirectory(dir=target.absolute().parent, prefix=f".{target.name}-") as folder:
        part = Path(folder) / target.name
        with Bag(part, run.scenario.arm, list(TOPICS)) as bag:
            for first in range(0, len(run), CHUNK):
                ticks = slice(first, first + CHUNK)
                pose, target_pose = (placed(T[:, :3, :3], T[:, :3, 3]) for T in (run.pose[ticks], run.target[ticks]))
                rows = (run.q, run.measured, run.rates, None, None, run.command, None)
                numbers = {topic: pose if row is None else row[ticks] for topic, row in zip(TOPICS, rows, strict=True)}
                numbers[TARGET] = target_pose
                bag.add(stamps[ticks], numbers, run.health[ticks], run.known[ticks], run.status[ticks])
        if target.exists():
            shutil.rmtree(target)
        part.rename(target)
