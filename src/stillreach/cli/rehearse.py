"""`stillreach rehearse`: every failure of every joint on a task, at many moments."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stillreach.cli import _options as option
from stillreach.cli._complete import complete_laws

if TYPE_CHECKING:
    from stillreach.arm import Arm
    from stillreach.faults import FaultKind
    from stillreach.simulation import Scenario
    from stillreach.tolerance import Rehearsal

PAGE, PICTURE, RECORD, SUMMARY = "rehearsal.html", "rehearsal.png", "rehearsal.nc", "rehearsal.json"
SURVEY = "rehearsal.zarr"


@option.of_recording
def rehearse(
    task: Annotated[
        str,
        typer.Argument(metavar="SCENARIO|ROBOT", help="A scenario, or the robot of the recording that follows."),
    ],
    recording: Annotated[
        str | None,
        typer.Argument(metavar="[RECORDING]", help="A rosbag2, an MCAP, CSV or Parquet file, or a run."),
    ] = None,
    *,
    options: option.Recording,
    kind: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KIND",
            help="How joints fail: locked (default), derated, confined, one-way+, one-way-, runaway+, runaway-, or as "
            "for run --fail, e.g. derated=0.1. It can be repeated.",
        ),
    ] = None,
    joint: Annotated[
        list[str] | None, typer.Option(metavar="JOINT", help="Only this joint fails. It can be repeated.")
    ] = None,
    together: Annotated[int, typer.Option("--together", "-k", min=1, help="How many joints fail at once.")] = 1,
    onsets: Annotated[int, typer.Option(min=1, help="At how many moments.")] = 100,
    known_after: option.KnownAfter = None,
    within: Annotated[
        str | None,
        option.allowed("How far the tool may be off its target, e.g. 5mm,1deg; by default 1 % of the path."),
    ] = None,
    law: option.Law = None,
    laws: Annotated[
        str | None,
        typer.Option(
            help="Also the share that survives under other laws, separated by commas.", autocompletion=complete_laws
        ),
    ] = None,
    healthy: option.Healthy = False,
    postures: Annotated[
        int, typer.Option(min=0, metavar="N", help="Also look for a better start among so many postures, e.g. 32.")
    ] = 0,
    shift: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="Also look for a better place so far along each axis, e.g. 10cm."),
    ] = None,
    survey: Annotated[
        int,
        typer.Option(min=0, metavar="N", help="Also where the arm can still go if a joint locks, at so many moments."),
    ] = 0,
    threads: option.Threads = None,
    require: Annotated[
        float | None, typer.Option(min=0.0, max=1.0, help="Exit with 1 if a smaller share survives, e.g. 0.9.")
    ] = None,
    out: option.Out = None,
    page: Annotated[
        bool | None, typer.Option("--page/--no-page", help="Write rehearsal.html; by default if Jinja is installed.")
    ] = None,
    plot: Annotated[bool | None, option.drawn("rehearsal.png")] = None,
    as_json: option.Json = False,
) -> None:
    """Rehearse a task: which joints can fail, and when.

    Every failure of every joint at every moment is simulated to the end. It is survived if the tool stays within the
    allowed distance of its target. Writes rehearsal.html (a page to pass on), .png, .nc and .json. Exits with 0, or
    with 1 if fewer survive than --require says. Ctrl-C keeps what is done.
    """
    from stillreach._units import LENGTHS, quantity, tolerances
    from stillreach.cli._exit import CTRL_C, NOT_FINISHED
    from stillreach.cli._faults import delay
    from stillreach.cli._laws import parse_laws
    from stillreach.cli._records import folder_for
    from stillreach.tolerance import better_place, better_start
    from stillreach.tolerance import rehearse as rehearsed

    distance, angle = tolerances("--within", within)
    far = 0.0 if shift is None else quantity("--shift", shift, LENGTHS, bare=False)
    chosen, source = _chosen(task, recording, options, law=law, healthy=healthy)
    others = parse_laws(laws, like=chosen.law) if laws else {}
    wanted: dict[str, Any] = {
        "kinds": [_kind(chosen.arm, text) for text in kind or ["locked"]],
        "joints": joint or None,
        "k": together,
        "onsets": onsets,
        "known_after": 0.0 if known_after is None else delay(known_after),
        "allowed_distance": distance,
        "allowed_angle": angle,
        "threads": threads,
    }
    found = rehearsed(chosen, **wanted)
    shares: dict[str, float] = {}
    folder = folder_for(out, recording or task)
    if not found.interrupted:
        shares = {name: rehearsed(chosen, **wanted, law=other).share for name, other in others.items()}
        if postures:
            better_start(found, count=postures, threads=threads)
        if far:
            better_place(found, [[sign * far * (axis == k) for k in range(3)] for sign in (1, -1) for axis in range(3)])
        if survey:
            _survey(found, folder / SURVEY, {"count": survey, "k": together, "threads": threads})
    _output(found, folder, source, shares if laws else None, page=page, plot=plot, as_json=as_json)
    if found.interrupted:
        raise typer.Exit(CTRL_C)
    if require is not None and not found.share >= require:
        raise typer.Exit(NOT_FINISHED)


def _chosen(
    task: str, recording: str | None, options: option.Recording, *, law: str | None, healthy: bool
) -> tuple[Scenario, str]:
    """The scenario to rehearse, and how a command line names it.

    Raises:
        InputError: for a recording behind a scenario, and for options of a recording without one.
    """
    import shlex

    from stillreach.cli._complete import scenario_names
    from stillreach.cli._faults import changed
    from stillreach.cli._recordings import recorded, refuse
    from stillreach.errors import InputError

    given: str | Scenario = task
    words = [task]
    if recording is None:
        refuse(options.given(), "a recording behind the robot; a scenario names its own robot")
    elif task in scenario_names() or task.endswith(".toml"):
        raise InputError("RECORDING", recording, f"none: {task} is a scenario, which has its own motion")
    else:
        given = recorded(recording, task, options)
        words = ["--recording", recording, "--robot", task]
        for name, value in options.given().items():
            words += [f"--{name}", str(value)]
    words += (["--law", law] if law else []) + ["--healthy"] * healthy
    return changed(given, law=law, fail=[], healthy=healthy), shlex.join(words)


def _output(
    found: Rehearsal,
    folder: Path,
    source: str,
    shares: dict[str, float] | None,
    *,
    page: bool | None,
    plot: bool | None,
    as_json: bool,
) -> None:
    """Writes the files, and prints what became of the failures."""
    from stillreach.cli._records import picture, remove_older, write_page, write_summary
    from stillreach.cli._terminal import tell

    remove_older(folder / PAGE, folder / PICTURE, folder / RECORD)
    facts = {**found.facts(), **({} if shares is None else {"laws": shares})}
    written = [write_summary(facts, folder, SUMMARY), *_record(found, folder / RECORD)]
    written += write_page(page, folder / PAGE, lambda: found.html(source))
    written += picture(plot, folder / PICTURE, found.plot)
    written += [found.survey.path] if found.survey is not None else []
    tell(facts, written, as_json, lambda: _print(found, shares or {}))


def _kind(arm: Arm, text: str) -> str | FaultKind:
    from stillreach.cli._faults import fault_kind_of
    from stillreach.errors import InputError
    from stillreach.tolerance.failures import KINDS

    if text in KINDS:
        return text
    if "=" not in text:
        from stillreach._messages import did_you_mean

        raise InputError("--kind", repr(text), f"one of {', '.join(KINDS)}{did_you_mean(text, KINDS)}")
    return fault_kind_of(arm, 0, text, option="--kind")


def _survey(found: Rehearsal, folder: Path, settings: dict[str, Any]) -> None:
    """The survey along the task; the folder of an earlier one, of another task, is replaced."""
    import shutil

    from stillreach.errors import InputError
    from stillreach.tolerance import Survey, survey_along

    try:
        survey_along(found, folder, **settings)
    except InputError as error:
        if error.argument != "out":
            raise
        Survey.load(folder)  # raises unless it is a survey
        shutil.rmtree(folder)
        survey_along(found, folder, **settings)


def _record(found: Rehearsal, path: Path) -> list[Path]:
    """The arrays as netCDF, or a note if the extra is missing."""
    from stillreach.cli._terminal import note
    from stillreach.errors import MissingExtraError

    try:
        found.save(path)
    except MissingExtraError as missing:
        note(f"stillreach: {missing} (for {path.name})")
        return []
    return [path]


def _print(found: Rehearsal, shares: dict[str, float]) -> None:
    from stillreach.cli._terminal import console, print_table, table
    from stillreach.tolerance.account import HEAD

    out = console()
    out.print(found.scenario.title, style="bold")
    out.print(f"{found.described}\n")
    made = table(*HEAD, right=(1, 2), wrap=(0, 3, 4, 5))
    for row in found.table():
        made.add_row(*row)
    print_table(made)
    out.print(f"\n{found.verdict}")
    for name, share in shares.items():
        out.print(f"under {name}: {100 * share:.3g} %")
    if found.advice:
        out.print(f"\n{found.advice}")
    if found.survey is not None:
        out.print(f"\nWhere it can still go: {found.survey.verdict}")
    if found.interrupted:
        out.print("Interrupted: the failures that were done are counted.", style="red")
