"""What bench.batch measured, as Markdown and as JSON."""

import os
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from bench.batch import QUIET_CLOCK, TWO_THREADS, WORKING, Figure, Result
from bench.report import processor
from bench.rows import PART_OVER


def table(head: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    """Markdown; numbers to the right of the first column."""
    rows = ["| " + " | ".join(cells) + " |" for cells in (head, *lines)]
    return "\n".join([rows[0], "|---" + "|---:" * (len(head) - 1) + "|", *rows[1:]])


def laws(result: Result, figures: list[Figure]) -> str:
    """Rate, time and cycles of a row, also of the kernel alone; the counted operations as a share of the peak."""
    head = ["one thread, from Python", "million rows/s", "median", "ns a row", "cycles", "operations", "share of peak"]
    if any(figure.kernel for figure in figures):
        head += ["kernel alone: ns a row", "cycles", "share of peak"]
    return table(head, [law_line(result, figure) for figure in figures])


def law_line(result: Result, figure: Figure) -> list[str]:
    """Of `laws`."""

    def cost(time: float) -> list[str]:
        return [f"{1e3 * time:.0f}", f"{result.peak.cycles(time):.0f}"]

    def share(time: float) -> str:
        return f"{100 * figure.operations * 1e-3 / time / result.limit:.0f} %" if figure.operations else "-"

    cells = [figure.name, f"{figure.rate:.2f}", f"{1.0 / figure.median:.2f}", *cost(figure.best)]
    cells += [str(figure.operations or "-"), share(figure.best)]
    return cells + ([*cost(figure.kernel), share(figure.kernel)] if figure.kernel else [])


def working(result: Result) -> str:
    """By law and number of working joints."""
    names = list(dict.fromkeys(figure.name for figure in result.of("working")))
    rate = {(figure.name, figure.working): figure.rate for figure in result.of("working")}
    lines = [[name, *(f"{rate[name, k]:.2f}" for k in WORKING)] for name in names]
    return table(("million rows/s; working joints:", *map(str, WORKING)), lines)


def threads(result: Result) -> str:
    """One thread, two, and their ratio."""
    rate = {(figure.name, figure.threads): figure.rate for figure in result.of("threads")}
    names = list(dict.fromkeys(name for name, _ in rate))
    lines = [
        [name, f"{rate[name, 1]:.2f}", f"{rate[name, 2]:.2f}", f"{rate[name, 2] / rate[name, 1]:.2f}"] for name in names
    ]
    return table(("million rows/s", "one thread", "two threads", "ratio"), lines)


def calls(result: Result) -> str:
    """[µs] a call of so many rows."""
    counts = list(next(iter(result.calls.values())))
    lines = [[name, *(f"{cost:.3g}" for cost in costs.values())] for name, costs in result.calls.items()]
    return table(("a call [µs]; rows:", *map(str, counts)), lines)


def machine(result: Result) -> str:
    """Clock and peak in the same minutes, and what else went on."""
    peak = result.peak
    wide = f" in registers of 256 bits, {peak.peak_of_eight:.1f} of 512 bits," if peak.peak_of_eight else ""
    return (
        f"{processor()}, kernel for {result.instruction_set}: clock {peak.clock:.2f} GHz (by dependent "
        f"multiplications), peak of multiply-adds "
        f"{peak.peak:.1f} GFLOP/s{wide} on one core. {result.repeats} interleaved repeats. "
        f"Before: {result.notes[0]} After: {result.notes[-1]}"
    )


def requirements(result: Result) -> str:
    """What is required of a quiet core, and whether it is met here."""
    clock = result.peak.clock
    lines = []
    for figure in result.of("laws"):
        if figure.need is None:
            continue
        word = "met" if figure.rate >= figure.need else "NOT MET"
        at = f"{figure.rate * QUIET_CLOCK / clock:.1f} if the clock were {QUIET_CLOCK:g}"
        lines.append(
            f"- {word}: {figure.name}: {figure.rate:.2f} million rows/s, "
            f"required {figure.need:g} ({clock:.2f} GHz; {at})"
        )
    rates = {(figure.name, figure.threads): figure.rate for figure in result.of("threads")}
    for name in dict.fromkeys(name for name, _ in rates):
        ratio = rates[name, 2] / rates[name, 1]
        word = "met" if ratio >= TWO_THREADS else "NOT MET"
        lines.append(
            f"- {word}: {name}: two threads {ratio:.2f} times one, required {TWO_THREADS:g} where both cores are free"
        )
    return "\n".join(lines)


def text(result: Result) -> str:
    """Everything."""
    head = f"{result.rows} rows in pieces, {100 * PART_OVER:.0f} % of them over the limit, 8 of 11 joints working."
    parts = [head, laws(result, result.of("laws"))]
    if result.of("more"):
        parts += [laws(result, result.of("more")), working(result), calls(result)]
    if result.of("threads"):
        parts.append(threads(result))
    return "\n\n".join([*parts, requirements(result), machine(result)])


def as_json(result: Result) -> dict[str, Any]:
    """All of it, as plain values."""
    return {**asdict(result), "processor": processor(), "load": os.getloadavg()}


def from_json(values: dict[str, Any]) -> Result:
    """What as_json wrote."""
    from bench.machine import Peak

    figures = [Figure(**figure) for figure in values["figures"]]
    calls = {name: {int(count): cost for count, cost in costs.items()} for name, costs in values["calls"].items()}
    of = (values["instruction_set"], values["rows"], values["repeats"])
    return Result(*of, figures, calls, Peak(**values["peak"]), values["notes"])
