"""`stillreach convert`: a run in another format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def convert(
    run: Annotated[
        Path,
        typer.Argument(metavar="RUN", help="A run: run.nc or run.npz; with --recover a rosbag2 or an MCAP file."),
    ],
    to: Annotated[
        Path, typer.Argument(metavar="FILE", help="The new file: .csv, .parquet, .rosbag2 (a folder), .nc or .npz.")
    ],
    recover: Annotated[
        bool, typer.Option("--recover", help="Make a whole rosbag2 of one that a crash left without its end.")
    ] = False,
) -> None:
    """Write a run in another format, or recover a broken rosbag2.

    CSV and Parquet have a column for each number, with its unit in the name. A .rosbag2 is a folder with an MCAP
    file, which ROS 2 Humble and newer play.
    """
    from stillreach.cli._terminal import console

    if recover:
        from stillreach.recordings import Recorder

        found = Recorder.recover(run, to)
        lost = f"; {found.lost:,} bytes were not whole" if found.lost else ""
        text = f"wrote {to}: {found.messages:,} messages in {found.seconds:.3f} s{lost}"
    else:
        from stillreach.simulation import Run

        Run.load(run).save(to)
        text = f"wrote {to}"
    console().print(text, soft_wrap=True)
