"""A run as a rosbag2."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stillreach._door import FloatArray
from stillreach._files import file_name
from stillreach.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from stillreach.simulation.run import Run

CHUNK = 1000
"""Ticks of a chunk."""


def write(run: Run, path: str | os.PathLike[str]) -> None:
    """Write a run; a folder of that name is replaced only when the new one is complete.

    Raises:
        MissingExtraError: if rosbags is not installed.
        InputError: if there is something else of that name.
        OSError: if the folder cannot be written.
    """
    try:
        from stillreach.bags.bag import Bag
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
        with Bag(part, run.scenario.arm, list(_numbers(run, slice(0), placed))) as bag:
            for first in range(0, len(run), CHUNK):
                ticks = slice(first, first + CHUNK)
                numbers = _numbers(run, ticks, placed)
                bag.add(stamps[ticks], numbers, run.health[ticks], run.known[ticks], run.status[ticks])
        if target.exists():
            shutil.rmtree(target)
        part.rename(target)


def _numbers(run: Run, ticks: slice, placed: Callable[[FloatArray, FloatArray], FloatArray]) -> dict[str, FloatArray]:
    """The numbers of each topic of some ticks."""
    pose, target = (placed(T[:, :3, :3], T[:, :3, 3]) for T in (run.pose[ticks], run.target[ticks]))
    return {
        "/joint_states": run.q[ticks],
        "/measured_joint_states": run.measured[ticks],
        "/joint_commands": run.rates[ticks],
        "/tool_pose": pose,
        "/target_pose": target,
        "/tool_command": run.command[ticks],
        "/tf": pose,
    }
