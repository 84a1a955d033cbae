"""Recordings that stillreach made itself: runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stillreach.recordings.samples import Samples, places
from stillreach.simulation.run import Run


def read(file: Path, joints: Sequence[str], named: Mapping[str, str], option: Any) -> Samples:
    """Read a run's true positions.

    Raises:
        InputError: if it is not a run, or a joint is missing.
    """
    run = Run.load(file)
    found = places(file.name, joints, list(run.joint_names), named)
    return Samples(run.time, run.q[:, found], tuple(run.joint_units[k] for k in found), "tick", 0)
