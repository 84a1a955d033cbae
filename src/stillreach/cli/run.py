"""`stillreach run`: one scenario, from file to record, picture and summary."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from stillreach.cli import _options as option

if TYPE_CHECKING:
    from stillreach.simulation import Run, Scenario

PICTURE = "run.png"


@option.of_recording
def run(
    scenario: Annotated[str | None, option.SCENARIO] = None,
    recording: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Instead of a scenario, the tool's motion in a rosbag2, an MCAP, CSV or Parquet file, or a run.",
        ),
    ] = None,
    robot: option.RecordedRobot = None,
    *,
    options: option.Recording,
    out: option.Out = None,
    law: option.Law = None,
    fail: option.Fail = None,
    healthy: option.Healthy = False,
    known_after: option.KnownAfter = None,
    within: Annotated[
        str | None,
        option.allowed("Distance from the goal that counts as arrived, e.g. 5mm,1deg; by default 1 % of the path."),
    ] = None,
    plot: Annotated[bool | None, option.drawn("run.png")] = None,
    as_json: option.Json = False,
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
    from stillreach.cli._terminal import tell

    distance, angle = tolerances("--within", within)
    given, name = scenario_or_recording(scenario, recording, robot, options)
    chosen = changed(given, law=law, fail=fail or [], healthy=healthy, known_after=known_after)
    folder = folder_for(out, name)
    record = _simulated(chosen)
    found = record.summary(allowed_distance=distance, allowed_angle=angle)
    remove_older(folder / PICTURE)
    written = [write_record(record, folder), write_summary(facts(found), folder)]
    written += picture(plot, folder / PICTURE, lambda: record.plot(found))
    tell(facts(found), written, as_json, lambda: print_summary(found))
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
