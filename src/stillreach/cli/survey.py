"""`stillreach survey`: what an arm can afford to lose, over many configurations."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stillreach.cli import _options as option
from stillreach.cli._poses import AngleOption, LengthOption, RowsOption, given_poses, ranges, rows_for

if TYPE_CHECKING:
    from stillreach.tolerance import Survey

FOLDER, PICTURE, SUMMARY = "survey.zarr", "survey.png", "survey.json"
SLICE, CLOUD = "survey-slice.png", "survey-cloud.png"


def survey(
    robot: option.Robot,
    tip: option.Tip = None,
    base: option.Base = None,
    fixed: option.Fixed = None,
    samples: Annotated[
        int | None, typer.Option(min=1, help="Number of random configurations within the limits; 100,000 by default.")
    ] = None,
    grid: Annotated[
        str | None, typer.Option(metavar="N[,N...]", help="Steps over the range of each joint, or of all, instead.")
    ] = None,
    poses: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="The configurations that inverse kinematics finds for the poses of this CSV file, instead: columns x, "
            "y, z and perhaps an attitude, as for reach.",
        ),
    ] = None,
    together: Annotated[
        int | None, typer.Option("--together", "-k", min=1, help="Joints that fail, at most; 2.")
    ] = None,
    lose: Annotated[
        list[str] | None,
        typer.Option(metavar="JOINT[,JOINT...]", help="Only this set of joints fails. It can be repeated."),
    ] = None,
    metric: Annotated[
        list[str] | None,
        typer.Option(
            metavar="METRIC",
            help="relative (manipulability without joints), speed, depth (how many can fail), reach (poses still "
            "reached), positions (where the tool still goes, as a slice and a cloud). It can be repeated; by default "
            "the first three.",
        ),
    ] = None,
    rows: RowsOption = None,
    frame: option.Frame = "base",
    length: LengthOption = None,
    angle: AngleOption = None,
    starts: Annotated[int, typer.Option(min=1, help="The most searches for a pose.")] = 30,
    seed: Annotated[int, typer.Option(min=0, help="Of all random numbers.")] = 1994,
    chunk: Annotated[int | None, typer.Option(min=1, help="Configurations computed and stored together.")] = None,
    keep: Annotated[
        str, typer.Option(help="reduced (histograms, worst cases, maps), or all: every value of every configuration.")
    ] = "reduced",
    scheduler: Annotated[
        str | None, typer.Option(metavar="tcp://HOST:PORT", help="Compute on the Dask cluster of this scheduler.")
    ] = None,
    baseline: Annotated[bool, typer.Option("--baseline", help="Use no AVX: the same bits on every processor.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume/--no-resume", help="Go on with a survey that was begun in this folder.")
    ] = True,
    threads: option.Threads = None,
    out: option.Out = None,
    plot: Annotated[bool | None, option.drawn("survey.png")] = None,
    as_json: option.Json = False,
) -> None:
    """Survey what an arm can afford to lose, over many configurations.

    Writes survey.zarr (labelled arrays, which xarray reads), .png and .json; with positions also survey-slice.png and
    survey-cloud.png. The same command goes on where it was interrupted. Without reach and positions a core does 30,000
    to 1,000,000 configurations a second.
    """
    from stillreach.cli._joints import assignments
    from stillreach.cli._records import folder_for, picture, remove_older, write_summary
    from stillreach.cli._robots import load_arm
    from stillreach.cli._task import task_of
    from stillreach.cli._terminal import note, tell
    from stillreach.tolerance import survey as surveyed

    given = given_poses(poses, length=length, angle=angle)
    arm = load_arm(robot, tip=tip, base=base, fixed=assignments("--fixed", fixed or []))
    folder = folder_for(out, robot)
    wanted: dict[str, Any] = {
        "samples": samples,
        "grid": None if grid is None else _steps(grid),
        "poses": given.poses if given else None,
        "k": together,
        "failures": [text.split(",") for text in lose] if lose else None,
        "task": task_of(rows_for(rows, given), frame),
        "starts": starts,
        "seed": seed,
        "chunk": chunk,
        "keep": keep,
        "baseline": baseline,
        "resume": resume,
        "threads": threads,
    }
    if metric:
        wanted["metrics"] = metric
    try:
        with _client(scheduler) as client:
            found = surveyed(arm, folder / FOLDER, client=client, **wanted)
    except KeyboardInterrupt:
        note(f"stillreach: interrupted; the same command goes on with {folder / FOLDER}")
        raise
    lost = [given.lines[place] for place in found.unreached] if given else []
    facts = {"robot": robot, **found.facts(), **({"unreached_lines": lost} if given else {})}
    remove_older(*(folder / name for name in (PICTURE, SLICE, CLOUD)))
    written = [found.path, write_summary(facts, folder, SUMMARY), *picture(plot, folder / PICTURE, found.plot)]
    if written[2:] and "positions" in found.metrics:
        written += picture(plot, folder / SLICE, lambda: found.plot("slice"))
        written += picture(plot, folder / CLOUD, lambda: found.plot("cloud")) if found.region.cloud else []
    tell(facts, written, as_json, lambda: _print(found, lost))


def _steps(text: str) -> int | list[int]:
    from stillreach.errors import InputError

    parts = text.split(",")
    if not all(part.strip().isdecimal() for part in parts):
        raise InputError("--grid", repr(text), "numbers of steps separated by commas, e.g. 8 or 8,8,4")
    return int(text) if len(parts) == 1 else [int(part) for part in parts]


@contextmanager
def _client(scheduler: str | None) -> Iterator[Any]:
    """A client of a Dask cluster; None without one."""
    from stillreach.errors import InputError, MissingExtraError

    if scheduler is None:
        yield None
        return
    try:
        import distributed
    except ImportError as error:
        raise MissingExtraError("survey", "--scheduler") from error
    try:
        opened: Any = distributed.Client
        client = opened(scheduler, timeout=10)
    except (OSError, ValueError) as error:
        raise InputError("--scheduler", repr(scheduler), f"the address of a Dask scheduler ({error})") from None
    with client:
        yield client


def _print(found: Survey, lost: list[int]) -> None:
    from stillreach.cli._terminal import console, print_table, table
    from stillreach.tolerance.surveys.account import counted

    out = console()
    out.print(f"{counted(found)} of {found.arm.name}:\n")
    made = table(*found.head, right=tuple(range(1, len(found.head))), wrap=(0,))
    for row in found.table():
        made.add_row(*row)
    print_table(made)
    out.print(f"\n{found.verdict}")
    if lost:
        out.print(f"\nnot reached: line {ranges(lost)}")
