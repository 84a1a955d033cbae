"""Rows a second of `solve_batch` and its kin from Python, on one thread and on two.

The paper's arm, joints 2, 4 and 7 failed, the pseudoinverse of 15 % of the rows over the limit. A figure is the
minimum of interleaved repeats, of all rows in one call or of pieces of them added up, whichever is less: pieces fit
between what else the machine does. The median is that of one call. Beside them stands what the core could do in the
same minutes: its clock, and its rate of multiply-adds. STILLREACH_INSTRUCTIONS=avx2 measures what processors without
AVX-512 run.
"""

import argparse
import gc
import json
import os
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from statistics import fmean

import numpy as np

import stillreach as sr
from bench import operations
from bench.kernel import kernel_times
from bench.machine import Peak
from bench.rows import ROWS, Rows, make_rows
from bench.timing import Row, machine_note, measure, pin_to_one_core
from bench.workload import arm
from stillreach import _core

N, FEW, PIECES = 11, 20_000, 10
LAWS: dict[str, sr.Law] = {
    "`Pseudoinverse`": sr.Pseudoinverse(),
    "`SingularityRobust`, exact": sr.SingularityRobust(damping="exact"),
    "`SingularityRobust`, closed form": sr.SingularityRobust(damping="closed-form"),
    "`SingularityRobust`, κ given": sr.SingularityRobust(damping=0.001),
    "`LeastError()`": sr.LeastError(),
    "`LeastError(price=None)`": sr.LeastError(price=None),
    "`KeepDirection`": sr.KeepDirection(),
}
REQUIRED = {
    "`Pseudoinverse`": 8.0,
    "`SingularityRobust`, exact": 4.0,
    "`LeastError()`": 3.0,
    "`LeastError(price=None)`": 3.0,
}
"""Million rows a second on one thread of a quiet core at QUIET_CLOCK [GHz], and TWO_THREADS times as many on two."""
QUIET_CLOCK, TWO_THREADS = 3.2, 1.7
SPARSE = tuple(name for name in LAWS if "closed" not in name and "given" not in name)
WORKING = (11, 8, 6, 5, 3)
STEPS = 10
ALONE = 4096
"""Rows that the kernel is timed on without Python."""
CALLS = (1, 4, 16, 64, 256, 1024, 4096, 16384)


@dataclass(frozen=True)
class Figure:
    """best, median, kernel (alone) [µs] a row; need [million rows/s]; operations of every row, None if not counted."""

    table: str
    name: str
    working: int
    threads: int
    best: float
    median: float
    need: float | None = None
    operations: int | None = None
    kernel: float | None = None

    @property
    def rate(self) -> float:
        """Million rows a second."""
        return 1.0 / self.best


@dataclass
class Case:
    """What is timed, and what its figure is called."""

    table: str
    name: str
    run: Callable[[slice], object]
    working: int = 8
    threads: int = 1
    need: float | None = None
    operations: int | None = None
    row: Row = field(init=False)

    def figure(self) -> Figure:
        """Times of all pieces but the last, which is the whole in one call."""
        *pieces, whole = self.row.times
        best, median = min(fmean(map(min, pieces)), min(whole)), statistics.median(whole)
        return Figure(self.table, self.name, self.working, self.threads, best, median, self.need, self.operations)


def solver(law: sr.Law, rows: Rows, threads: int = 1, *, new: bool = False) -> Callable[[slice], object]:
    """solve_batch on a part of the rows, into one array or into new ones."""
    robot, rates = arm(), np.empty_like(rows.q)
    shared = rows.bounds(slice(None)) if rows.lower.ndim == 1 else None

    def run(part: slice) -> sr.BatchSolution:
        bounds, out = shared or rows.bounds(part), None if new else rates[part]
        return sr.solve_batch(robot, law, rows.q[part], rows.twist[part], bounds, out=out, threads=threads)

    return run


def law_cases(rows: Rows) -> list[Case]:
    """Every law; then what else is asked of a batch."""
    counted = operations.pseudoinverse(N, 8)
    cases = [
        Case("laws", name, solver(law, rows), need=REQUIRED.get(name), operations=counted) for name, law in LAWS.items()
    ]
    own, mixed = rows.bounds_by_row(), make_rows(len(rows), mixed=True)
    for name in REQUIRED:
        cases.append(Case("more", f"{name}, a new array", solver(LAWS[name], rows, new=True), operations=counted))
    for name in REQUIRED:
        cases.append(Case("more", f"{name}, bounds by row", solver(LAWS[name], own), operations=counted))
    for name in REQUIRED:
        cases.append(Case("more", f"{name}, other joints failed in each row", solver(LAWS[name], mixed)))
    robot = arm()
    once = operations.kinematics(N)
    cases.append(Case("more", "`forward`", lambda part: robot.forward(rows.q[part]), operations=once))
    cases.append(Case("more", "`jacobian`", lambda part: robot.jacobian(rows.q[part]), operations=once))
    cases.append(Case("more", f"`rollout_batch`, `LeastError()`, a step of {STEPS}", roller(rows)))
    return cases


def roller(rows: Rows) -> Callable[[slice], object]:
    """Rollouts of STEPS steps from so few of the rows that all their steps are as many as the rows."""
    robot, bounds = arm(), rows.bounds(slice(None))

    def run(part: slice) -> sr.BatchRollout:
        few = slice(part.start, part.start + max(1, (part.stop - part.start) // STEPS))
        q, twist = rows.q[few], rows.twist[few]
        return sr.rollout_batch(robot, sr.LeastError(), q, twist, bounds, period=0.001, steps=STEPS, threads=1)

    return run


def working_cases(count: int) -> list[Case]:
    """Laws with fewer or more joints that work."""
    cases = []
    for working in WORKING:
        rows = make_rows(count, working=working)
        cases += [Case("working", name, solver(LAWS[name], rows), working=working) for name in SPARSE]
    return cases


def thread_cases(rows: Rows) -> list[Case]:
    """One thread and two, on the same rows."""
    return [
        Case("threads", name, solver(LAWS[name], rows, threads), threads=threads)
        for name in REQUIRED
        for threads in (1, 2)
    ]


def timed(
    cases: list[Case], rows: int, pieces: int, repeats: int, between: Callable[[], object] | None = None
) -> list[Figure]:
    """The figures of interleaved repeats over `pieces` parts of the rows, and all of them in one call."""
    edges = np.linspace(0, rows, pieces + 1).astype(int)
    parts = [slice(int(a), int(b)) for a, b in zip([*edges[:-1], 0], [*edges[1:], rows], strict=True)]
    for case in cases:
        case.row = Row(case.name, case.table, case.run, times=[[] for _ in parts])
        case.run(parts[0])
    measure([case.row for case in cases], 0.0, parts, least=repeats, between=between)
    return [case.figure() for case in cases]


def call_costs(rows: Rows, repeats: int) -> dict[str, dict[int, float]]:
    """[µs] a whole call, the minimum, by law and by number of rows in the call."""
    found: dict[str, dict[int, float]] = {}
    gc.collect()
    for name in REQUIRED:
        run = solver(LAWS[name], rows)
        for count in (c for c in CALLS if c <= len(rows)):
            part, best = slice(0, count), np.inf
            for _ in range(repeats * max(1, 100 // count)):
                began = time.perf_counter_ns()
                run(part)
                best = min(best, time.perf_counter_ns() - began)
            found.setdefault(name, {})[count] = best / 1e3
    return found


@dataclass
class Result:
    """All that was measured; calls: [µs] by law and rows in a call."""

    instruction_set: str
    rows: int
    repeats: int
    figures: list[Figure]
    calls: dict[str, dict[int, float]]
    peak: Peak
    notes: list[str]

    @property
    def limit(self) -> float:
        """Most multiply-adds in registers of the length that the kernel uses [GFLOP/s]."""
        return self.peak.peak_of_eight if self.instruction_set == "avx512" else self.peak.peak

    def of(self, table: str) -> list[Figure]:
        return [figure for figure in self.figures if figure.table == table]


def run(rows: int, repeats: int, *, only_laws: bool = False) -> Result:
    """Measures everything, or the laws' table alone."""
    os.environ["STILLREACH_THREADS"] = "1"  # for forward and jacobian, which take no argument for it
    free = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    cores = pin_to_one_core()
    peak, notes, work = Peak(), [machine_note(cores)], make_rows(rows)
    peak.look()
    pieces = min(PIECES, rows)
    alone = kernel_times(make_rows(min(ALONE, rows)), 10 * repeats)
    cases = [case for case in law_cases(work) if case.table == "laws" or not only_laws]
    figures = timed(cases, rows, pieces, repeats, peak.look)
    figures = [replace(one, kernel=alone[one.name]) if one.table == "laws" else one for one in figures]
    if only_laws:
        return Result(_core.instruction_set(), rows, repeats, figures, {}, peak, [*notes, machine_note(cores)])
    few = min(FEW, rows)
    figures += timed(working_cases(few), few, min(pieces, 4), repeats, peak.look)
    calls = call_costs(work, repeats)
    if free is not None:
        os.sched_setaffinity(0, free)
    if cores > 1:
        figures += timed(thread_cases(work), rows, min(pieces, 5), repeats)
    return Result(_core.instruction_set(), rows, repeats, figures, calls, peak, [*notes, machine_note(cores)])


def main() -> None:
    from bench.batch_tables import as_json, text

    parser = argparse.ArgumentParser(
        prog="python -m bench.batch", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rows", type=int, default=ROWS, metavar="N", help="of the batch (default %(default)s)")
    parser.add_argument("--repeats", type=int, default=15, metavar="N", help="of each piece (default %(default)s)")
    parser.add_argument("--laws", action="store_true", help="only their table")
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the figures there")
    asked = parser.parse_args()
    for name in ("rows", "repeats"):
        if getattr(asked, name) < 1:
            parser.error(f"--{name}: {getattr(asked, name)}, expected 1 or more")
    result = run(asked.rows, asked.repeats, only_laws=asked.laws)
    print(text(result))
    if asked.json:
        asked.json.parent.mkdir(parents=True, exist_ok=True)
        asked.json.write_text(json.dumps(as_json(result), indent=1))


if __name__ == "__main__":
    main()
