"""Measures what docs/why-it-is-fast.md tells, and writes the figures and the picture into it.

Each part is kept in out/why/ and can be measured alone: `batch` (bench.batch, with AVX2), `wide` (its laws with
AVX-512, where the machine has that), `stages` (bench.stages), `tick` (bench.tick), `long_arms` (bench.long_arms). What
is written holds for the machine at hand.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Callable

from bench import batch_tables, operations, stages
from bench.batch import N, Result
from bench.batch_tables import table
from bench.machine import ROOT
from bench.page import markers, put
from bench.stages import Count
from bench.why_plot import draw

PAGE, PLOT = ROOT / "docs" / "why-it-is-fast.md", ROOT / "docs" / "images" / "why-it-is-fast.png"
OUT = ROOT / "out" / "why"
PARTS = ("batch", "wide", "stages", "tick", "long_arms")


def measure(part: str, repeats: int) -> None:
    """Runs a part's command and keeps what it found."""
    file = OUT / (f"{part}.json" if part in ("batch", "wide", "stages") else f"{part}.md")
    command = [sys.executable, "-m", f"bench.{'batch' if part == 'wide' else part}"]
    if file.suffix == ".json":
        command += ["--json", str(file)]
    if part in ("batch", "wide"):
        command += ["--repeats", str(repeats)]
    if part == "wide":
        command += ["--laws"]
    sets = {"batch": "avx2", "wide": "avx512"}
    environment = os.environ | ({"STILLREACH_INSTRUCTIONS": sets[part]} if part in sets else {})
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False, env=environment)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)} failed")
    if file.suffix == ".md":
        file.write_text(done.stdout)


def arithmetic() -> str:
    """Operations of each piece of the pseudoinverse by the formulas, for the common work and for a longer arm."""
    pieces: dict[str, Callable[[int, int], int]] = {
        "sines and cosines": lambda n, k: operations.sines(n),
        "pose and Jacobian": lambda n, k: operations.kinematics(n) - operations.sines(n),
        "Gram matrix": lambda n, k: operations.gram(k),
        "its factors, inverse, condition bound": lambda n, k: operations.factor(),
        "solution": lambda n, k: operations.solve(k) + k,
        "is it a number": lambda n, k: operations.checks(k),
        "all": operations.pseudoinverse,
        "all, in code for the paper's arm alone": lambda n, k: (
            operations.pseudoinverse(n, k) - operations.kinematics(n) + operations.kinematics_of_modules(n)
        ),
    }
    sizes = ((N, 8), (7, 7), (50, 50))
    head = ("operations a row", *(f"n = {n}, k = {k}" for n, k in sizes))
    return table(head, [[name, *(str(count(n, k)) for n, k in sizes)] for name, count in pieces.items()])


def shares(result: Result, counts: list[Count]) -> str:
    """What the kernel executed, in the time that it took."""
    time = {figure.name: figure.kernel for figure in result.of("laws")}
    lines = []
    for one in counts:
        flops = one.operations * 1e-3 / time[one.law]
        per_cycle = one.instructions / result.peak.cycles(time[one.law])
        cells = [f"{one.operations:.0f}", f"{flops:.1f}", f"{100 * flops / result.limit:.0f} %"]
        lines.append([one.law, *cells, f"{one.instructions:.0f}", f"{per_cycle:.1f}"])
    head = ("kernel alone", "operations a row", "GFLOP/s", "of the peak", "instructions a row", "a cycle")
    return table(head, lines)


def eight_lanes(result: Result) -> str:
    """The laws with AVX-512."""
    if result.instruction_set != "avx512":
        return "The machine that this page was made on has no AVX-512."
    tables = [batch_tables.laws(result, result.of("laws")), batch_tables.requirements(result)]
    return "\n\n".join([*tables, batch_tables.machine(result)])


def sections() -> dict[str, str]:
    """Text by marker, of the parts that were measured."""
    found = {"arithmetic": arithmetic()}
    batch, counted = OUT / "batch.json", OUT / "stages.json"
    counts = [Count(**one) for one in json.loads(counted.read_text())] if counted.exists() else []
    if batch.exists():
        result = batch_tables.from_json(json.loads(batch.read_text()))
        found["machine"] = batch_tables.machine(result)
        found["laws"] = batch_tables.laws(result, result.of("laws"))
        found["required"] = batch_tables.requirements(result)
        found["more"] = batch_tables.laws(result, result.of("more"))
        found["working"] = batch_tables.working(result)
        found["calls"] = batch_tables.calls(result)
        found["threads"] = batch_tables.threads(result)
        if counts and all(figure.kernel for figure in result.of("laws")):
            found["shares"] = shares(result, counts)
            draw(result, counts, PLOT)
    if (OUT / "wide.json").exists():
        found["wide"] = eight_lanes(batch_tables.from_json(json.loads((OUT / "wide.json").read_text())))
    if counts:
        found["stages"], found["kinds"] = stages.by_stage(counts), stages.by_kind(counts)
    for name in ("tick", "long_arms"):
        if (OUT / f"{name}.md").exists():
            found[name] = (OUT / f"{name}.md").read_text().strip()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m bench.why", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"what to measure (default: {', '.join(PARTS)})")
    parser.add_argument("--repeats", type=int, default=30, metavar="N", help="of the batch (default %(default)s)")
    parser.add_argument("--kept", action="store_true", help="measure nothing, write what out/why/ holds")
    asked = parser.parse_args()
    if unknown := [part for part in asked.parts if part not in PARTS]:
        parser.error(f"PART: {', '.join(unknown)} not among {', '.join(PARTS)}")
    if asked.kept and asked.parts:
        parser.error("--kept: expected no PART beside it")
    OUT.mkdir(parents=True, exist_ok=True)
    for part in () if asked.kept else asked.parts or PARTS:
        print(f"{part} …", file=sys.stderr, flush=True)
        measure(part, asked.repeats)
    for name, text in sections().items():
        put(PAGE, *markers(name), text)
    print(f"written: {PAGE.relative_to(ROOT)}", file=sys.stderr)


if __name__ == "__main__":
    main()
