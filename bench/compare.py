"""Times stillreach beside its peers, on the same work, and judges the answers of all.

Every peer is a process of its own; all take turns on one core, again and again. An interrupted run prints what it has
measured.
"""

import argparse
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.field import Peer, interleave
from bench.page import put
from bench.peers import BATCHES, ENTRIES, TICKS, Entry
from bench.problem import Problem, make_batch, make_problem
from bench.report import report, requirements, short_table
from bench.timing import machine_note, pin_to_one_core

ROOT = Path(__file__).parents[1]
README, PAGE = ROOT / "README.md", ROOT / "docs" / "why-it-is-fast.md"


@dataclass(frozen=True)
class Size:
    """How much work, for how long: single ticks, rows of the batch, seconds of each table, seconds of a turn."""

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
    parser.add_argument("--seconds", type=float, metavar="S", help=f"time for each table (default {FULL.seconds:g})")
    parser.add_argument(
        "--write",
        action="store_true",
        help="put the tables into the pages; needs a full run",
    )
    asked = parser.parse_args(given)
    unknown = [key for key in (asked.peers or "").split(",") if key and key not in ENTRIES]
    if unknown:
        parser.error(f"--peers: {', '.join(unknown)} not among {', '.join(ENTRIES)}")
    if asked.write and (asked.quick or asked.peers):
        parser.error("--write: only a full run may go into the README, without --quick and --peers")
    return asked


def chosen(entries: tuple[Entry, ...], peers: str | None) -> list[Peer]:
    """Ours, and the peers asked for; none where there are none of these."""
    wanted = set(ENTRIES if peers is None else peers.split(","))
    found = [Peer(entry) for entry in entries if entry.ours or entry.key in wanted]
    return found if any(peer.entry.key in wanted for peer in found) else []


def say(text: str) -> None:
    """Progress, apart from the results."""
    print(text, file=sys.stderr, flush=True)


def main() -> None:
    asked = arguments()
    size = QUICK if asked.quick else FULL
    cores = pin_to_one_core()
    notes = {machine_note(cores)}
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that results are printed then, too
    say("what is feasible, by linear programming …")
    ticks, (batch, *rows) = make_problem(size.ticks), make_batch(size.rows)
    tables = [chosen(entries, asked.peers) for entries in (TICKS, BATCHES)]
    try:
        for peers, problem, more in zip(tables, (ticks, batch), (None, tuple(rows)), strict=True):
            race(peers, problem, more, asked.seconds or size.seconds, size.turn)
    except KeyboardInterrupt:
        say("\ninterrupted: what was measured until then")
        asked.write = False
    finally:
        for peer in (*tables[0], *tables[1]):
            peer.stop()
    text = report(*tables, len(ticks), size.rows, cores, notes | {machine_note(cores)})
    print(text, "\nRequired of a single tick:\n", *requirements(tables[0]), sep="\n")
    if asked.write:
        put(README, "bench-peers", short_table(tables[0]))
        put(PAGE, "bench-peers", text)
        say(f"written: {README.name}, {PAGE.name}")


def race(
    peers: list[Peer], problem: Problem, rows: tuple[np.ndarray, np.ndarray] | None, seconds: float, turn: float
) -> None:
    """Starts the peers, times them in turns, stops them."""
    for peer in peers:
        say(f"{peer.entry.key}: getting ready …")
        peer.start(problem, rows)
        if peer.reason:
            say(f"{peer.entry.key}: left out, {peer.reason}")
    began = time.monotonic()
    if running := [peer for peer in peers if peer.reason is None]:
        after = lambda turns: say(f"round {turns}, {time.monotonic() - began:.0f} of {seconds:g} s")  # noqa: E731
        interleave(running, seconds, turn, after)
    for peer in peers:
        peer.stop()


if __name__ == "__main__":
    main()
