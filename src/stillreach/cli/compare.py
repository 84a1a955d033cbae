"""`stillreach compare`: one scenario under several laws, side by side."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stillreach.cli import _options as option
from stillreach.cli._complete import complete_laws

if TYPE_CHECKING:
    from stillreach.laws import Law
    from stillreach.simulation import Comparison, Scenario

PICTURE, SUMMARY = "compare.png", "compare.json"


def compare(
    scenario: Annotated[str, option.SCENARIO],
    laws: Annotated[
        str | None,
        typer.Option(
            help="Laws separated by commas, with settings like singularity-robust:damping=closed-form.",
            autocompletion=complete_laws,
            show_default="all laws",
        ),
    ] = None,
    out: option.Out = None,
    fail: option.Fail = None,
    healthy: option.Healthy = False,
    known_after: option.KnownAfter = None,
    within: Annotated[str | None, option.allowed("Distance from the goal that counts as arrived.")] = None,
    plot: Annotated[bool | None, option.drawn("compare.png")] = None,
    as_json: option.Json = False,
) -> None:
    """Simulate a scenario under several laws: table and picture.

    Writes a record for each law, compare.png and compare.json, and replaces earlier ones. Exits with 0 if all laws were
    run, whether or not the tool arrives. Ctrl-C keeps the computed ticks.
    """
    from stillreach._units import tolerances
    from stillreach.cli._exit import CTRL_C
    from stillreach.cli._faults import changed
    from stillreach.cli._laws import law_texts, parse_laws
    from stillreach.cli._records import folder_for, picture, remove_older, write_record, write_summary
    from stillreach.cli._summary import facts
    from stillreach.cli._terminal import tell

    off = tolerances("--within", within)
    chosen = changed(scenario, fail=fail or [], healthy=healthy, known_after=known_after)
    folder = folder_for(out, scenario)
    results = _results(chosen, parse_laws(laws or ",".join(law_texts()[0]), like=chosen.law), off)
    found = {"scenario": chosen.name, "laws": {name: facts(of) for name, of in results.summaries.items()}}
    remove_older(*_older(folder, set(results)))
    written = [write_record(run, folder, _stem(law)) for law, run in results.items()]
    written += [write_summary(found, folder, SUMMARY), *picture(plot, folder / PICTURE, results.plot)]
    tell(found, written, as_json, lambda: _print(results))
    if results.interrupted:
        raise typer.Exit(CTRL_C)


def _results(scenario: Scenario, laws: dict[str, Law], allowed: tuple[float | None, float | None]) -> Comparison:
    """The runs, up to Ctrl-C.

    Raises:
        SimulationInterrupted: after Ctrl-C before the first tick.
    """
    from stillreach.cli._terminal import note
    from stillreach.errors import SimulationInterrupted
    from stillreach.simulation import compare

    try:
        return compare(scenario, laws, allowed_distance=allowed[0], allowed_angle=allowed[1])
    except SimulationInterrupted as interrupt:
        results: Comparison = interrupt.run
        if not results:
            raise
        note(f"interrupted under {list(results)[-1]}; the computed ticks are kept")
        return results


def _print(results: Comparison) -> None:
    from stillreach.cli._terminal import console, print_table, table
    from stillreach.simulation.account import fault_lines
    from stillreach.simulation.comparison import HEAD

    out, scenario = console(), results.scenario
    out.print(scenario.title, style="bold")
    ticks = f"{scenario.steps + 1} ticks of {1000 * scenario.period:g} ms"
    out.print(f"{scenario.arm.name}, {ticks}; faults: {'; '.join(fault_lines(scenario))}\n")
    made = table(*HEAD, right=(2, 3, 4), wrap=(0,))
    for row, found in zip(results.rows(), results.summaries.values(), strict=True):
        made.add_row(*row, style=None if found.finished else "red")
    print_table(made)
    out.print()
    for line in results.notes():
        out.print(line)


def _older(folder: Path, laws: set[str]) -> list[Path]:
    """Figure and records of an earlier comparison in a folder, except those that these laws replace."""
    from stillreach.cli._records import RECORDS

    try:
        earlier = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))["laws"]
        gone = {_stem(str(law)) for law in earlier} - {_stem(law) for law in laws}
    except (OSError, ValueError, KeyError, TypeError):
        gone = set()
    return [folder / PICTURE, *(folder / f"{stem}{suffix}" for stem in sorted(gone) for suffix in RECORDS)]


def _stem(law: str) -> str:
    return re.sub(r"[^\w.-]+", "-", law)
