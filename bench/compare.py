"""Times stillreach beside its peers, on the same work, and judges the answers of all.

Every peer is a process of its own; all take turns on one core, again and again. What has been measured is kept in the
JSON file after each round, and printed if the run is interrupted.
"""

import argparse
import json
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.field import ROOT, Peer, interleave, prepare
from bench.peers import BATCHES, ENTRIES, TICKS, Entry
from bench.plot import draw
from bench.problem import Problem, make_batch, make_problem
from bench.report import Machine, as_json, into_readme, report
from bench.timing import pin_to_one_core

README, PLOT = ROOT / "README.md", ROOT / "docs" / "images" / "bench-peers.png"
OUT = ROOT / "out" / "bench-peers.json"


@dataclass(frozen=True)
class Size:
    """How much work, for how long: rows of the batch, seconds of each table, seconds of a turn."""

    ticks: int
    rows: int
    seconds: float
    turn: float


FULL, QUICK = Size(1024, 16384, 240.0, 0.2), Size(256, 2048, 10.0, 0.05)


def arguments(given: list[str] | None = None) -> argparse.Namespace:
    """What was asked for.

    Raises:
        SystemExit: it makes no sense.
    """
    parser = argparse.ArgumentParser(prog="python -m bench.compare", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="less work, for seconds instead of minutes")
    parser.add_argument("--peers", metavar="A,B", help=f"only these, and ours: {', '.join(ENTRIES)}")
    parser.add_argument("--ticks", type=int, metavar="N", help=f"single ticks in the workload (default {FULL.ticks})")
    parser.add_argument("--seconds", type=float, metavar="S", help=f"time for each table (default {FULL.seconds:g})")
    parser.add_argument(
        "--json", type=Path, default=OUT, metavar="FILE", help="where results are kept (default %(default)s)"
    )
    parser.add_argument("--write", action="store_true", help="put table and plot into the README; needs a full run")
    asked = parser.parse_args(given)
    unknown = [key for key in (asked.peers or "").split(",") if key and key not in ENTRIES]
    if unknown:
        parser.error(f"--peers: {', '.join(unknown)} not among {', '.join(ENTRIES)}")
    if asked.ticks is not None and asked.ticks < 64:
        parser.error(f"--ticks: {asked.ticks}, expected 64 or more")
    if asked.write and (asked.quick or asked.peers or asked.ticks):
        parser.error("--write: only a full run may go into the README, without --quick, --peers and --ticks")
    return asked


def chosen(entries: tuple[Entry, ...], peers: str | None) -> list[Entry]:
    """Ours, and the peers asked for."""
    wanted = None if peers is None else set(peers.split(","))
    found = [entry for entry in entries if wanted is None or entry.ours or entry.key in wanted]
    return found if wanted is None or any(entry.key in wanted for entry in found) else []


def say(text: str) -> None:
    """Progress, apart from the results."""
    print(text, file=sys.stderr, flush=True)


def main() -> None:
    asked = arguments()
    size = QUICK if asked.quick else FULL
    seconds = asked.seconds or size.seconds
    machine = Machine.here(pin_to_one_core())
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that results are printed then, too
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        say("what is feasible, by linear programming …")
        ticks = make_problem(asked.ticks or size.ticks)
        ticks.save(folder / "ticks.npz")
        batch, q, twist = make_batch(size.rows)
        batch.save(folder / "batch.npz")
        np.savez(folder / "rows.npz", q=q, twist=twist)
        prepare(folder, ticks)
        tables = [[Peer(entry, folder) for entry in chosen(entries, asked.peers)] for entries in (TICKS, BATCHES)]
        try:
            for peers, problem in zip(tables, (ticks, batch), strict=True):
                race(peers, problem, seconds, size.turn, lambda: keep(asked.json, machine, tables))
        except KeyboardInterrupt:
            say("\ninterrupted: what was measured until then")
            asked.write = False
        finally:
            for peer in (*tables[0], *tables[1]):
                peer.stop()
    machine.finish()
    keep(asked.json, machine, tables)
    text = report(*tables, len(ticks), len(q), machine)
    print(text)
    if asked.write:
        draw(*tables, PLOT)
        into_readme(README, text)
        say(f"written: {README.name}, {PLOT.relative_to(ROOT)}")


def race(peers: list[Peer], problem: Problem, seconds: float, turn: float, save: Callable[[], None]) -> None:
    """Starts the peers, times them in turns, stops them."""
    for peer in peers:
        say(f"{peer.entry.key}: getting ready …")
        peer.start(problem)
        if peer.reason:
            say(f"{peer.entry.key}: left out, {peer.reason}")
    began = time.monotonic()

    def after(turns: int) -> None:
        save()
        say(f"round {turns}, {time.monotonic() - began:.0f} of {seconds:g} s")

    running = [peer for peer in peers if peer.reason is None]
    if running:
        interleave(running, seconds, turn, after)
    for peer in peers:
        peer.stop()


def keep(path: Path, machine: Machine, tables: list[list[Peer]]) -> None:
    """Writes what is known so far, in one step."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_text(json.dumps(as_json(machine, *tables), indent=1))
    part.replace(path)


if __name__ == "__main__":
    main()
