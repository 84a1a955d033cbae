"""`stillreach run`: one scenario, from file to record, picture and summary."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stillreach.cli._chain import BaseOption, TipOption
from stillreach.cli._complete import complete_law, complete_scenario
from stillreach.cli._recordings import (
    AngleOption,
    EpisodeOption,
    PeriodOption,
    RecordingOption,
    RobotOption,
    TopicOption,
)

if TYPE_CHECKING:
    from stillreach.simulation import Run, Scenario

PICTURE = "run.png"


def run(
    scenario: Annotated[
        str | None,
        typer.Argument(metavar="SCENARIO", help="A scenario file or a ready one.", autocompletion=complete_scenario),
    ] = None,
    recording: RecordingOption = None,
    robot: RobotOption = None,
    tip: TipOption = None,
    base: BaseOption = None,
    angle: AngleOption = None,
    topic: TopicOption = None,
    episode: EpisodeOption = None,
    period: PeriodOption = None,
    out: Annotated[Path | None, typer.Option(help="Output folder; by default out/NAME.")] = None,
    law: Annotated[
        str | None,
        typer.Option(
            help="Law instead of the scenario's, e.g. keep-direction or least-error:price=position-first.",
            autocompletion=complete_law,
        ),
    ] = None,
    fail: Annotated[
        list[str] | None,
        typer.Option(
            metavar="JOINT[@S][:KIND]",
            help="One more fault: j4@2 locks j4 after 2 s, j4@2:derated=0.3 leaves it 30 % of its speed.",
        ),
    ] = None,
    healthy: Annotated[bool, typer.Option("--healthy", help="Leave out the scenario's own faults.")] = False,
    known_after: Annotated[
        str | None,
        typer.Option(
            metavar="TIME", help="The controller learns of every fault this much later, e.g. 40ms; never: not at all."
        ),
    ] = None,
    within: Annotated[
        str | None,
        typer.Option(
            metavar="LENGTH[,ANGLE]",
            help="Distance from the goal that counts as arrived, e.g. 5mm,1deg; by default 1 % of the path.",
        ),
    ] = None,
    plot: Annotated[
        bool | None, typer.Option("--plot/--no-plot", help="Draw run.png; by default if matplotlib is installed.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print only the summary, as JSON.")] = False,
) -> None:
    """Simulate a scenario or a recording: summary, record and picture.

    Writes run.nc (run.npz without the extra netcdf), run.png and summary.json, and replaces those of an earlier run.
    Exits with 0 if the tool ends at its goal, with 1 if not. Ctrl-C keeps the computed ticks.
    """
    from stillreach._units import tolerances
    from stillreach.cli._exit import CTRL_C, NOT_FINISHED
    from stillreach.cli._faults import changed
    from stillreach.cli._recordings import scenario_or_recording
    from stillreach.cli._records import folder_for, picture, remove_older, write_record, write_summary
    from stillreach.cli._summary import facts, print_summary
    from stillreach.cli._terminal import console, print_json

    allowed = tolerances("--within", within)
    options = {"angle": angle, "topic": topic, "episode": episode, "period": period}
    given, name = scenario_or_recording(scenario, recording, robot, tip, base, **options)
    chosen = changed(given, law=law, fail=fail or [], healthy=healthy, known_after=known_after)
    folder = folder_for(out, name)
    record = _simulated(chosen)
    found = record.summary(allowed_distance=allowed[0], allowed_angle=allowed[1])
    remove_older(folder / PICTURE)
    written = [write_record(record, folder), write_summary(facts(found), folder)]
    written += picture(plot, folder / PICTURE, lambda: record.plot(found))
    if as_json:
        print_json({**facts(found), "files": [str(path) for path in written]})
    else:
        print_summary(found)
        console().print(f"\nwrote {', '.join(map(str, written))}", soft_wrap=True)
    if record.interrupted:
        raise typer.Exit(CTRL_C)
    if not found.finished:
        raise typer.Exit(NOT_FINISHED)


def _simulated(scenario: Scenario) -> Run:
    """The run, whole or up to Ctrl-C.

    Raises:
        SimulationInterrupted: after Ctrl-C before the first tick.
    """
    from stillreach.cli._terminal import note
    from stillreach.errors import SimulationInterrupted
    from stillreach.simulation import simulate

    try:
        return simulate(scenario)
    except SimulationInterrupted as interrupt:
        record: Run = interrupt.run
        if not len(record):
            raise
        note(f"interrupted at {record.time[-1]:g} of {scenario.duration:g} s; the computed ticks are kept")
        return record
