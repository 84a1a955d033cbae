"""Tables of what was measured beside the peers, and the requirements they are held against."""

import datetime
import platform
from collections.abc import Iterable, Sequence
from pathlib import Path

from bench.field import Peer

MARK = "†"
LEGEND = (
    f"{MARK}: exceeds a limit, moves a locked joint or misses a feasible twist. Excess error: error above the least "
    "possible, relative to the twist; mean over the ticks or rows that are not feasible, in brackets the worst of them."
)
BOUND_RATIO, NEW_RATIO, QP_RATIO = 10.0, 6.0, 80.0
"""Required: our time with bound buffers and with a new array under the fastest peer's, and under Pink's and mink's."""
SHORT = ("default-bound", "ours-bound", "pinocchio-daqp", "placo", "pink", "mink")
"""The lines of the README's table."""
HEAD = "over the limit", "locked joint moved", "feasible missed", "excess error: mean (worst)"


def processor() -> str:
    """Its name, as Linux tells it."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def markdown(head: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """A table; numbers to the right of the first column."""
    rows = ["| " + " | ".join(cells) + " |" for cells in (head, *lines)]
    return "\n".join([rows[0], "|---" + "|---:" * (len(head) - 1) + "|", *rows[1:]])


def table(peers: list[Peer], unit: str) -> str:
    """One line a peer, ours first, then by time; those whose answers are wrong have a mark, ours among them."""
    measured = sorted((peer for peer in peers if peer.times), key=lambda peer: (not peer.entry.ours, peer.best))
    ours = next((peer.best for peer in peers if peer.entry.ours and peer.times), None)
    lines = []
    for peer in measured:
        verdict = peer.verdict
        assert verdict is not None
        ratio = "-" if ours is None else f"{peer.best / ours:.1f}"
        over = f"{verdict.over_limit}" + (f" (by {verdict.worst_over:.1e})" if verdict.over_limit else "")
        mean, worst = verdict.excess, verdict.worst_excess
        excess = "0" if worst <= 1e-6 else f"{100 * mean:.2g} % ({100 * worst:.2g} %)"
        title = peer.entry.title if verdict.clean else f"{peer.entry.title} {MARK}"
        cells = [title, f"{peer.best:.2f}", f"{peer.median:.2f}", ratio, over, str(verdict.locked_moved)]
        lines.append([*cells, f"{verdict.missed} of {verdict.feasible}", excess])
    return markdown(("", f"min [{unit}]", f"median [{unit}]", "times ours", *HEAD), lines)


def short_table(ticks: list[Peer]) -> str:
    """The README's: time, ratio to our default law, and error above the least possible."""
    by_key = {peer.entry.key: peer for peer in ticks if peer.times}
    shown = [by_key[key] for key in SHORT if key in by_key]
    lines = []
    for peer in shown:
        assert peer.verdict is not None
        worst = peer.verdict.worst_excess
        excess = "0" if worst <= 1e-6 else f"{100 * peer.verdict.excess:.2g} % (worst {100 * worst:.2g} %)"
        lines.append([peer.entry.title, f"{peer.best:.2f}", f"{peer.best / shown[0].best:.1f}", excess])
    return markdown(("one tick from Python", "µs", "times ours", "excess error, mean"), lines)


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
    return lines + [_safe(ours) for ours in (bound, new) if ours]


def _met(what: str, ratio: float, least: float) -> str:
    return f"- {'met' if ratio >= least else 'MISSED'}: {what}: {ratio:.1f} times, required {least:g}"


def _safe(ours: Peer) -> str:
    v = ours.verdict
    assert v is not None
    word = "met" if v.clean and v.worst_over <= 0.0 else "MISSED"
    wrong = f"{v.over_limit} limits violated, {v.locked_moved} locked joints moved, {v.missed} feasible ticks missed"
    return f"- {word}: {ours.entry.title}: {wrong}"


def report(ticks: list[Peer], batches: list[Peer], count: int, rows: int, cores: int, notes: set[str]) -> str:
    """Both tables, who took no part, and where they were measured."""
    lines = [f"One tick from Python, {count} ticks of which half are feasible, in µs:", "", table(ticks, "µs")]
    if any(peer.times for peer in batches):
        lines += ["", f"A batch of {rows} rows, one thread, in µs a row:", "", table(batches, "µs")]
    every = [*ticks, *batches]
    lines += ["", LEGEND, *(f"Left out: {peer.entry.title}: {peer.reason}." for peer in every if peer.reason)]
    versions = {name: version for peer in every for name, version in peer.versions.items() if name != "stillreach"}
    busy = ", ".join(sorted({note.split(":")[0].lower() for note in notes}))
    where = f"{datetime.date.today().isoformat()}, one core of {processor()} ({cores} cores; {busy})"
    listed = ", ".join(f"{name} {version}" for name, version in sorted(versions.items()))
    return "\n".join([*lines, "", f"{where}; Python {platform.python_version()}, {listed}."])
