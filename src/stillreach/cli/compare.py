"""`stillreach compare`: one scenario under several laws, side by side."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stillreach.cli._complete import complete_laws, complete_scenario

if TYPE_CHECKING:
    from stillreach.laws import Law
    from stillreach.simulation import Run, Scenario
    from stillreach.simulation.summary import Summary

    Result = tuple[Scenario, Run, Summary]

PICTURE, SUMMARY = "compare.png", "compare.json"


def compare(
    scenario: Annotated[
        str,
        typer.Argument(metavar="SCENARIO", help="A scenario file or a ready one.", autocompletion=complete_scenario),
    ],
    laws: Annotated[
        str | None,
        typer.Option(
            help="Laws separated by commas, with settings like singularity-robust:damping=closed-form.",
            autocompletion=complete_laws,
            show_default="all laws",
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for what is written; by default out/NAME.")] = None,
    fail: Annotated[
        list[str] | None, typer.Option(metavar="JOINT[@S][:KIND]", help="One more fault, as for run.")
    ] = None,
    healthy: Annotated[bool, typer.Option("--healthy", help="Leave out the scenario's own faults.")] = False,
    within: Annotated[
        str | None, typer.Option(metavar="LENGTH[,ANGLE]", help="How near to its goal the tool has arrived.")
    ] = None,
    plot: Annotated[
        bool | None, typer.Option("--plot/--no-plot", help="Draw compare.png; by default where matplotlib is there.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summaries as JSON and nothing else.")] = False,
) -> None:
    """Simulate a scenario under several laws: table and picture.

    Writes a record for each law, compare.png and compare.json in place of those of an earlier comparison. Exits with 0
    when all laws were run, whether or not the tool arrives under them. Ctrl-C keeps what was computed.
    """
    from stillreach._units import tolerances
    from stillreach.cli._exit import CTRL_C
    from stillreach.cli._faults import changed
    from stillreach.cli._laws import law_texts, parse_laws
    from stillreach.cli._records import folder_for, picture, remove_older, write_record, write_summary
    from stillreach.cli._terminal import console, print_json

    allowed = tolerances("--within", within)
    chosen = changed(scenario, fail=fail or [], healthy=healthy)
    folder = folder_for(out, scenario)
    results = _results(chosen, parse_laws(laws or ",".join(law_texts()[0]), like=chosen.law), allowed)
    found = _facts(chosen, results)
    remove_older(*_older(folder, set(results)))
    written = [write_record(run, folder, _stem(law)) for law, (_, run, _) in results.items()]
    written += [
        write_summary(found, folder, SUMMARY),
        *picture(plot, folder / PICTURE, lambda: _drawn(results)),
    ]
    if as_json:
        print_json({**found, "files": [str(path) for path in written]})
    else:
        _print(chosen, results)
        console().print(f"\nwrote {', '.join(map(str, written))}", soft_wrap=True)
    if any(summary.interrupted for _, _, summary in results.values()):
        raise typer.Exit(CTRL_C)


def _results(scenario: Scenario, laws: dict[str, Law], allowed: tuple[float | None, float | None]) -> dict[str, Result]:
    """Scenario, run and summary by law, up to Ctrl-C."""
    from stillreach.cli._terminal import note
    from stillreach.cli.run import simulated

    results: dict[str, Result] = {}
    for place, (name, law) in enumerate(laws.items(), start=1):
        variant = replace(scenario, law=law)
        if sys.stderr.isatty():
            note(f"{place} of {len(laws)}: {name}")
        try:
            run, summary = simulated(variant, allowed)
        except KeyboardInterrupt:  # not one tick of this one
            if not results:
                raise
            break
        results[name] = (variant, run, summary)
        if summary.interrupted:
            break
    return results


def _facts(scenario: Scenario, results: dict[str, Result]) -> dict[str, Any]:
    """What --json prints; docs/command-line.md explains the keys."""
    from stillreach.cli._summary import facts

    return {
        "scenario": scenario.name,
        "laws": {name: facts(variant, run, summary) for name, (variant, run, summary) in results.items()},
    }


def _print(scenario: Scenario, results: dict[str, Result]) -> None:
    from stillreach.cli._summary import apart, beyond_limits, fault_lines, is_late
    from stillreach.cli._terminal import console, print_table, table
    from stillreach.show.words import shown_length, tidy

    out = console()
    out.print(scenario.name, style="bold")
    ticks = f"{scenario.steps + 1} ticks of {1000 * scenario.period:g} ms"
    out.print(f"{scenario.arm.name}, {ticks}; faults: {'; '.join(fault_lines(scenario))}\n")
    made = table("law", "arrived", "ends off by", "farthest off", "peak rate", right=(2, 3, 4), wrap=(0,))
    for name, (_, _, found) in results.items():
        arrived = "broken off" if found.interrupted else "yes" if found.finished else "NO"
        made.add_row(
            name,
            arrived,
            apart(found, found.goal_distance, found.goal_angle),
            apart(found, found.distance.value, found.angle.value),
            "no limit" if found.rate is None else f"{tidy(100 * found.rate.value)} %",
            style=None if found.finished else "red",
        )
    print_table(made)
    out.print("\npeak rate: the largest, in per cent of its joint's limit")
    if any(beyond_limits(found) for *_, found in results.values()):
        out.print("           above 100 %: drives cannot follow")
    for name, (_, _, found) in results.items():
        if found.why is not None:
            out.print(f"{name}: {found.why.sentence}")
        if is_late(found):
            late, beside = shown_length(found.distance.value), shown_length(found.beside)
            out.print(f"{name} falls behind, by up to {late}, and is at most {beside} off its path")


def _older(folder: Path, laws: set[str]) -> list[Path]:
    """Picture and records of an earlier comparison in a folder, but for those that these laws replace."""
    from stillreach.cli._records import RECORDS

    try:
        earlier = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))["laws"]
        gone = {_stem(str(law)) for law in earlier} - {_stem(law) for law in laws}
    except (OSError, ValueError, KeyError, TypeError):
        gone = set()
    return [folder / PICTURE, *(folder / f"{stem}{suffix}" for stem in sorted(gone) for suffix in RECORDS)]


def _stem(law: str) -> str:
    return re.sub(r"[^\w.-]+", "-", law)


def _drawn(results: dict[str, Result]) -> Any:
    from stillreach.show.comparison import comparison

    return comparison(results)
