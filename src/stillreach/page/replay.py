"""What a page draws of a run: the ticks it needs, in the precision of a screen."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach.simulation import Run
from stillreach.simulation.commanded import deviation

MOST_ROWS = 6000
MOST_NUMBERS = 150_000
"""Of all rows together: with these a run stays below 1 MB, whatever it holds."""


def replay_of(run: Run, label: str) -> tuple[dict[str, Any], list[str]]:
    """A run for ``pack``, thinned where it is long, and what a reader has to know of that.

    Args:
        run: with at least one tick.
        label: what the page calls it.
    """
    n, ticks = run.scenario.arm.n, len(run)
    rows = min(ticks, MOST_ROWS, max(2, MOST_NUMBERS // (2 * n + 8)))
    kept = np.unique(np.linspace(0, ticks - 1, rows).round().astype(np.int64))
    changes = np.flatnonzero(np.any(run.health[1:] != run.health[:-1], axis=1)) + 1
    kept = np.unique(np.concatenate([kept, changes[: rows // 4]]))
    distance, angle = deviation(run)
    notes = []
    if len(kept) < ticks:
        notes.append(f"{label}: {len(kept):,} of its {ticks:,} ticks are drawn.")

    def numbers(array: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(array[kept], dtype=np.float32)

    return {
        "label": label,
        "tick": kept.astype(np.int32),
        "end": ticks - 1,
        "q": numbers(run.q),
        "rates": numbers(run.rates),
        "tool": numbers(run.pose[:, :3, 3]),
        "target": numbers(run.target[:, :3, 3]),
        "off": numbers(np.stack([distance, angle], axis=1)),
        "status": run.status[kept],
        "health": run.health[kept],
        "known": run.known[kept],
        "faults": _numbers_of(run),
    }, notes


def _numbers_of(run: Run) -> list[dict[str, Any]]:
    """The faults of the scenario with their numbers, to go on from a moment."""
    found = []
    for fault in run.scenario.faults:
        first, second = (float(np.clip(number, -1e300, 1e300)) for number in fault.kind.numbers)
        found.append(
            {
                "joint": run.scenario.arm.joint_index(fault.joint),
                "first_tick": run.scenario.tick_at(fault.at),
                "end_tick": run.scenario.steps + 1 if fault.until is None else run.scenario.tick_at(fault.until),
                "health": int(fault.kind.health),
                "first": first,
                "second": second,
            }
        )
    return found
