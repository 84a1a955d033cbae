"""The data of a run in a page: a sample of its ticks in single precision."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach.page.task import number
from stillreach.simulation import Run
from stillreach.simulation.commanded import deviation

MOST_ROWS = 6000
MOST_NUMBERS = 150_000
"""Numbers in all rows together; they keep a run below 1 MB."""


def replay_of(run: Run, label: str, task: int = 0) -> tuple[dict[str, Any], list[str]]:
    """A run for ``pack``, and a note if it is thinned.

    Args:
        run: with at least one tick.
        label: what the page calls it.
        task: index of its scenario among those of the page.
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
        "task": task,
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
        "faults": _faults_of(run),
    }, notes


def _faults_of(run: Run) -> list[dict[str, Any]]:
    """The faults of the scenario with their ticks and numbers."""
    scenario, found = run.scenario, []
    for fault in scenario.faults:
        first, second = map(number, fault.kind.numbers)
        found.append(
            {
                "joint": scenario.arm.joint_index(fault.joint),
                "begin": scenario.tick_at(fault.at),
                "end": scenario.steps + 1 if fault.until is None else scenario.tick_at(fault.until),
                "health": int(fault.kind.health),
                "first": first,
                "second": second,
            }
        )
    return found
