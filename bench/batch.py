"""Rows a second of `solve_batch` and its kin from Python, on one thread and on two.

The paper's arm, joints 2, 4 and 7 failed, the pseudoinverse of 15 % of the rows over the limit. A figure is the
minimum of interleaved repeats, of all rows in one call or of pieces of them added up, whichever is less: pieces fit
between what else the machine does. The median is that of one call. STILLREACH_INSTRUCTIONS=avx2 measures what
processors without AVX-512 run.
"""

import argparse
import gc
import os
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import fmean

import numpy as np

import stillreach as sr
from bench.report import markdown, processor
from bench.rows import PART_OVER, ROWS, Rows, make_rows
from bench.timing import Row, machine_note, measure, pin_to_one_core
from bench.workload import arm
from stillreach import _core
from stillreach.batch import BatchSolution
from stillreach.rollouts import BatchRollout

FEW, PIECES = 20_000, 10
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
"""Million rows a second on one thread of a quiet core at 3.2 GHz, and TWO_THREADS times as many on two."""
TWO_THREADS = 1.7
SPARSE = tuple(name for name in LAWS if "closed" not in name and "given" not in name)
WORKING = (11, 8, 6, 5, 3)
STEPS = 10
CALLS = (1, 4, 16, 64, 256, 1024, 4096, 16384)


@dataclass
class Case:
    """What is timed, and what it is called."""

    name: str
    run: Callable[[slice], object]
    row: Row = field(init=False)

    @property
    def rate(self) -> float:
        """Million rows a second, by the shortest times of all pieces, or of the last, all rows in one call."""
        *pieces, whole = self.row.times
        return 1.0 / min(fmean(map(min, pieces)), min(whole))

    def cells(self) -> list[str]:
        """Of `rates`."""
        median = 1.0 / statistics.median(self.row.times[-1])
        return [self.name, f"{self.rate:.2f}", f"{median:.2f}", f"{1e3 / self.rate:.0f}"]


def solver(law: sr.Law, rows: Rows, threads: int = 1, *, new: bool = False) -> Callable[[slice], object]:
    """solve_batch on a part of the rows, into one array or into new ones."""
    robot, rates = arm(), np.empty_like(rows.q)
    shared = rows.bounds(slice(None)) if rows.lower.ndim == 1 else None

    def run(part: slice) -> BatchSolution:
        bounds, out = shared or rows.bounds(part), None if new else rates[part]
        return sr.solve_batch(robot, law, rows.q[part], rows.twist[part], bounds, out=out, threads=threads)

    return run


def more_cases(rows: Rows) -> list[Case]:
    """What else is asked of a batch."""
    own, mixed, robot = rows.bounds_by_row(), make_rows(len(rows), mixed=True), arm()
    cases = [Case(f"{name}, a new array", solver(LAWS[name], rows, new=True)) for name in REQUIRED]
    cases += [Case(f"{name}, bounds by row", solver(LAWS[name], own)) for name in REQUIRED]
    cases += [Case(f"{name}, other joints failed in each row", solver(LAWS[name], mixed)) for name in REQUIRED]
    cases.append(Case("`forward`", lambda part: robot.forward(rows.q[part])))
    cases.append(Case("`jacobian`", lambda part: robot.jacobian(rows.q[part])))
    return [*cases, Case(f"`rollout_batch`, `LeastError()`, a step of {STEPS}", roller(rows))]


def roller(rows: Rows) -> Callable[[slice], object]:
    """Rollouts of STEPS steps from so few of the rows that all their steps are as many as the rows."""
    robot, bounds = arm(), rows.bounds(slice(None))

    def run(part: slice) -> BatchRollout:
        few = slice(part.start, part.start + max(1, (part.stop - part.start) // STEPS))
        q, twist = rows.q[few], rows.twist[few]
        return sr.rollout_batch(robot, sr.LeastError(), q, twist, bounds, period=0.001, steps=STEPS, threads=1)

    return run


def timed(cases: list[Case], rows: int, pieces: int, repeats: int) -> list[Case]:
    """Interleaved repeats over `pieces` parts of the rows, and all of them in one call."""
    edges = np.linspace(0, rows, pieces + 1).astype(int)
    parts = [slice(int(a), int(b)) for a, b in zip([*edges[:-1], 0], [*edges[1:], rows], strict=True)]
    for case in cases:
        case.row = Row(case.name, "", case.run, times=[[] for _ in parts])
        case.run(parts[0])
    measure([case.row for case in cases], 0.0, parts, least=repeats)
    return cases


def rates(cases: list[Case]) -> str:
    """Rates and times of a row."""
    return markdown(("one thread, from Python", "million rows/s", "median", "ns a row"), [c.cells() for c in cases])


def by_working(rows: int, pieces: int, repeats: int) -> str:
    """Rates with fewer or more joints that work."""
    given = {k: make_rows(rows, working=k) for k in WORKING}
    cases = [Case(name, solver(LAWS[name], given[k])) for name in SPARSE for k in WORKING]
    found = [f"{case.rate:.2f}" for case in timed(cases, rows, pieces, repeats)]
    lines = [[name, *found[len(WORKING) * i :][: len(WORKING)]] for i, name in enumerate(SPARSE)]
    return markdown(("million rows/s; working joints:", *map(str, WORKING)), lines)


def by_threads(rows: Rows, pieces: int, repeats: int) -> tuple[str, dict[str, float]]:
    """Rates on one thread and on two, and their ratios."""
    one, two = ([Case(name, solver(LAWS[name], rows, threads)) for name in REQUIRED] for threads in (1, 2))
    timed([*one, *two], len(rows), pieces, repeats)
    ratios = {a.name: b.rate / a.rate for a, b in zip(one, two, strict=True)}
    lines = [[a.name, f"{a.rate:.2f}", f"{b.rate:.2f}", f"{ratios[a.name]:.2f}"] for a, b in zip(one, two, strict=True)]
    return markdown(("million rows/s", "one thread", "two threads", "ratio"), lines), ratios


def by_rows_in_a_call(rows: Rows, repeats: int) -> str:
    """[µs] a whole call, the minimum, by law and by number of rows in the call."""
    counts, lines = [count for count in CALLS if count <= len(rows)], []
    gc.collect()
    for name in REQUIRED:
        run, cells = solver(LAWS[name], rows), []
        for count in counts:
            part, best = slice(0, count), np.inf
            for _ in range(repeats * max(1, 100 // count)):
                began = time.perf_counter_ns()
                run(part)
                best = min(best, time.perf_counter_ns() - began)
            cells.append(f"{best / 1e3:.3g}")
        lines.append([name, *cells])
    return markdown(("a call [µs]; rows:", *map(str, counts)), lines)


def requirements(laws: list[Case], ratios: dict[str, float]) -> str:
    """What is required of a quiet core at 3.2 GHz, and of two, and whether it is met here."""
    rate = {case.name: case.rate for case in laws}
    judged = [
        (rate[name] >= need, f"{name}: {rate[name]:.2f} million rows/s, required {need:g}")
        for name, need in REQUIRED.items()
    ]
    judged += [
        (ratio >= TWO_THREADS, f"{name}: two threads {ratio:.2f} times one, required {TWO_THREADS:g}")
        for name, ratio in ratios.items()
    ]
    return "\n".join(f"- {'met' if met else 'NOT MET'}: {text}" for met, text in judged)


def run(rows: int, repeats: int, *, only_laws: bool = False) -> list[str]:
    """Measures everything, or the laws' table alone; the paragraphs to print."""
    os.environ["STILLREACH_THREADS"] = "1"  # for forward and jacobian, which take no argument for it
    free = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
    cores, work, pieces = pin_to_one_core(), make_rows(rows), min(PIECES, rows)
    before, ratios = machine_note(cores), {}
    laws = [Case(name, solver(law, work)) for name, law in LAWS.items()]
    more = [] if only_laws else more_cases(work)
    timed([*laws, *more], rows, pieces, repeats)
    said = [f"{rows} rows, {100 * PART_OVER:.0f} % of them over the limit, 8 of 11 joints working.", rates(laws)]
    if not only_laws:
        said += [rates(more), by_working(min(FEW, rows), min(pieces, 4), repeats), by_rows_in_a_call(work, repeats)]
        if free is not None:
            os.sched_setaffinity(0, free)
        if cores > 1:
            text, ratios = by_threads(work, min(pieces, 5), repeats)
            said.append(text)
    where = f"{processor()}, kernel for {_core.instruction_set()}, {repeats} interleaved repeats."
    return [*said, requirements(laws, ratios), f"{where} Before: {before} After: {machine_note(cores)}"]


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m bench.batch", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rows", type=int, default=ROWS, metavar="N", help="of the batch (default %(default)s)")
    parser.add_argument("--repeats", type=int, default=15, metavar="N", help="of each piece (default %(default)s)")
    parser.add_argument("--laws", action="store_true", help="only their table")
    asked = parser.parse_args()
    for name in ("rows", "repeats"):
        if getattr(asked, name) < 1:
            parser.error(f"--{name}: {getattr(asked, name)}, expected 1 or more")
    print("\n\n".join(run(asked.rows, asked.repeats, only_laws=asked.laws)))


if __name__ == "__main__":
    main()
