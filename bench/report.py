"""Tables of what was measured, the requirements they are held against, and their place in the README."""

import datetime
import os
import platform
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from bench.field import Peer
from bench.page import put
from bench.timing import machine_note

MARK = "†"
LEGEND = (
    f"{MARK}: exceeds a limit, moves a locked joint or misses a feasible twist. Excess error: error above the least "
    "possible, relative to the twist; mean over the ticks or rows that are not feasible, in brackets the worst of them."
)
BEGIN, END = "<!-- bench-peers -->", "<!-- /bench-peers -->"
BOUND_RATIO, NEW_RATIO, QP_RATIO = 10.0, 6.0, 80.0
"""Required: our time with bound buffers and with a new array under the fastest peer's, and under Pink's and mink's."""


@dataclass
class Machine:
    """Where and when it was measured."""

    cores: int
    processor: str
    date: str
    notes: list[str] = field(default_factory=list)

    @classmethod
    def here(cls, cores: int) -> "Machine":
        """This machine, now."""
        return cls(cores, processor(), datetime.date.today().isoformat(), [machine_note(cores)])

    def finish(self) -> None:
        """Notes what the machine is doing at the end."""
        self.notes.append(machine_note(self.cores))


def processor() -> str:
    """Its name, as Linux tells it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def measured(peers: list[Peer]) -> list[Peer]:
    """Those that have times, ours first, then by time."""
    return sorted((peer for peer in peers if peer.times), key=lambda peer: (not peer.entry.ours, peer.best))


def reference(peers: list[Peer]) -> Peer | None:
    """What the ratios are over: the first of ours in the table."""
    return next((peer for peer in peers if peer.entry.ours and peer.times), None)


def table(peers: list[Peer], unit: str) -> list[str]:
    """Markdown, one line a peer; those whose answers are wrong have a mark, ours among them."""
    ours = reference(peers)
    names = (f"min [{unit}]", f"median [{unit}]", "times ours", "over the limit", "locked joint moved")
    names = (*names, "feasible missed", "excess error: mean (worst)")
    lines = [f"| | {' | '.join(names)} |", "|---" + "|---:" * len(names) + "|"]
    for peer in measured(peers):
        verdict = peer.verdict
        assert verdict is not None
        ratio = "-" if ours is None else f"{peer.best / ours.best:.1f}"
        over = f"{verdict.over_limit}" + (f" (by {verdict.worst_over:.1e})" if verdict.over_limit else "")
        missed = f"{verdict.missed} of {verdict.feasible}"
        mean, worst = verdict.excess, verdict.worst_excess
        excess = "0" if worst <= 1e-6 else f"{100 * mean:.2g} % ({100 * worst:.2g} %)"
        title = peer.entry.title if verdict.clean else f"{peer.entry.title} {MARK}"
        cells = [title, f"{peer.best:.2f}", f"{peer.median:.2f}", ratio, over, str(verdict.locked_moved)]
        lines.append("| " + " | ".join([*cells, missed, excess]) + " |")
    return lines


def failures(peers: list[Peer]) -> list[str]:
    """Who took no part, and why."""
    return [f"Left out: {peer.entry.title}: {peer.reason}." for peer in peers if peer.reason]


def versions(*tables: list[Peer]) -> str:
    """Of the peers' libraries."""
    found = {name: version for peers in tables for peer in peers for name, version in peer.versions.items()}
    found.pop("stillreach", None)  # what is measured is this tree, whatever its version
    return ", ".join(f"{name} {version}" for name, version in sorted(found.items()))


def requirements(ticks: list[Peer]) -> list[str]:
    """Each requirement, and whether it is met."""
    by_key = {peer.entry.key: peer for peer in ticks if peer.times}
    others = [peer for peer in by_key.values() if not peer.entry.ours]
    bound, new = by_key.get("ours-bound"), by_key.get("ours-new")
    lines = []
    if others and bound and new:
        fastest = min(others, key=lambda peer: peer.best)
        for ours, least, call in ((bound, BOUND_RATIO, "bound buffers"), (new, NEW_RATIO, "a new array")):
            lines.append(_met(f"{call} over the fastest peer ({fastest.entry.title})", fastest.best / ours.best, least))
    for key in ("pink", "pink-frame", "mink", "mink-frame"):
        if bound and key in by_key:
            lines.append(_met(f"bound buffers over {by_key[key].entry.title}", by_key[key].best / bound.best, QP_RATIO))
    lines += [_safe(ours) for ours in (bound, new) if ours]
    return lines


def _met(what: str, ratio: float, least: float) -> str:
    return f"- {'met' if ratio >= least else 'MISSED'}: {what}: {ratio:.1f} times, required {least:g}"


def _safe(ours: Peer) -> str:
    v = ours.verdict
    assert v is not None
    word = "met" if v.clean and v.worst_over <= 0.0 else "MISSED"
    wrong = f"{v.over_limit} limits violated, {v.locked_moved} locked joints moved, {v.missed} feasible ticks missed"
    return f"- {word}: {ours.entry.title}: {wrong}"


def report(ticks: list[Peer], batches: list[Peer], count: int, rows: int, machine: Machine) -> str:
    """All of it, in Markdown."""
    lines = [f"One tick from Python, {count} ticks of which half are feasible, in µs:", "", *table(ticks, "µs")]
    if measured(batches):
        lines += ["", f"A batch of {rows} rows, one thread, in µs a row:", "", *table(batches, "µs")]
    lines += ["", LEGEND, "", *failures([*ticks, *batches])]
    lines += ["", "Required of a single tick:", "", *requirements(ticks)]
    busy = ", ".join(sorted({note.split(":")[0].lower() for note in machine.notes}))
    where = f"{machine.date}, one core of {machine.processor} ({machine.cores} cores; {busy})"
    lines += ["", f"{where}; Python {platform.python_version()}, {versions(ticks, batches)}."]
    return "\n".join(lines)


def as_json(machine: Machine, *tables: list[Peer]) -> dict[str, Any]:
    """What is known so far, for the results file."""
    peers = [
        {
            "key": peer.entry.key,
            "title": peer.entry.title,
            "reason": peer.reason,
            "versions": peer.versions,
            "verdict": asdict(peer.verdict) if peer.verdict else None,
            "passes": len(peer.times[0]) if peer.times else 0,
            "min_us": peer.best if peer.times else None,
            "median_us": peer.median if peer.times else None,
        }
        for table in tables
        for peer in table
    ]
    return {"machine": asdict(machine), "load": os.getloadavg(), "peers": peers}


def into_readme(path: Path, text: str) -> None:
    """Puts the text between the markers.

    Raises:
        ValueError: the file has no markers.
    """
    put(path, BEGIN, END, text)
