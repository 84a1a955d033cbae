"""`stillreach convert`: a run in another format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def convert(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run: run.nc or run.npz.")],
    to: Annotated[
        Path, typer.Argument(metavar="FILE", help="The new file: .csv, .parquet, .rosbag2 (a folder), .nc or .npz.")
    ],
) -> None:
    """Write a run in another format.

    CSV and Parquet have a column for each number, with its unit in the name. A .rosbag2 is a folder with an MCAP
    file, which ROS 2 Humble and newer play.
    """
    from stillreach.cli._terminal import console
    from stillreach.simulation import Run

    Run.load(run).save(to)
    console().print(f"wrote {to}", soft_wrap=True)
