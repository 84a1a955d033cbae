"""What many configurations keep after each loss of joints; the compiled counterpart of a report of each."""

from __future__ import annotations

from collections.abc import Sequence
from math import comb
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stillreach import _core
from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.arm.dexterity import full_rates, least_speeds
from stillreach.arm.relative import failure_sets
from stillreach.errors import InputError
from stillreach.task import Task
from stillreach.tolerance.speeds import row_scales

MOST_SETS = 20_000
"""Sets of joints of all sizes."""
MOST_FACETS = 200_000
"""Of the velocities of a configuration: those of 31 joints in six rows, some 150 configurations a second."""


class Losses(NamedTuple):
    """What N configurations keep without joints: relative manipulability, or a speed.

    Args:
        whole: (N,) with all joints; 1 for relative manipulability.
        joint: (N, n) without each joint.
        worst: (N, k) the least of all sets of each size.
        which: (N, k) the place of that set among those of its size; of speeds only where ``every`` is wanted.
        every: (N, sets) without each set, by size; or None.
    """

    whole: FloatArray
    joint: FloatArray
    worst: FloatArray
    which: npt.NDArray[np.int32]
    every: FloatArray | None


def all_sets(n: int, k: int) -> list[tuple[int, ...]]:
    """All sets of up to k of n joints, by size, lexicographic in each.

    Raises:
        InputError: if there are more than MOST_SETS.
    """
    total = sum(comb(n, size) for size in range(1, k + 1))
    if total > MOST_SETS:
        raise InputError("k", f"{k}, which makes {total} sets of {n} joints", f"at most {MOST_SETS} sets")
    return [tuple(row) for size in range(1, k + 1) for row in failure_sets(range(n), size).tolist()]


def facets(n: int, m: int) -> int:
    """The most facets that the velocities of n joints have in m rows, opposite ones counted once."""
    return comb(n, m - 1)


def relative(
    arm: Arm, q: FloatArray, k: int, *, task: Task | None = None, every: bool = False, threads: int = 0
) -> Losses:
    """Relative manipulability of many configurations: w(J without some joints) / w(J), 0 to 1.

    A configuration whose Jacobian has not full rank gets NaN.

    Args:
        arm: the arm.
        q: (N, n) [rad, m], float64 in C order.
        k: the largest number of joints that fail together, 1 to n.
        task: rows, frame and point; None: the full pose.
        every: also return it for every set.
        threads: how many; 0: as for ``solve_batch``.
    """
    own = Task() if task is None else task
    sets = sum(comb(arm.n, size) for size in range(1, k + 1)) if every else 0
    given = {"scales": np.ones(own.m), "set_count": sets}
    return _losses(arm, q, k, own, given, sets if every else None, threads, speeds=False)


def least_everywhere(
    arm: Arm,
    q: FloatArray,
    k: int,
    *,
    task: Task | None = None,
    least: bool = False,
    sets: Sequence[Sequence[int]] | None = None,
    threads: int = 0,
) -> Losses:
    """The speed that the tool reaches in every direction, of many configurations; as ``Report.speed``.

    Args:
        arm: the arm, of at most 31 joints for six rows.
        q: (N, n) [rad, m], float64 in C order.
        k: the largest number of joints that fail together, 1 to n.
        task: rows, frame and point; None: the full pose. Its weights set the units in which speeds are compared.
        least: in units of the least speeds that count, 1 mm/s and 0.1 deg/s, in place of those of the weights: below 1
            a direction is lost.
        sets: for which to return it as ``every``.
        threads: how many; 0: as for ``solve_batch``.

    Raises:
        InputError: if the arm has too many joints.
    """
    own = Task() if task is None else task
    if facets(arm.n, own.m) > MOST_FACETS:
        got = f"speeds of an arm with {arm.n} joints and {own.m} rows"
        raise InputError("metrics", got, f"at most {MOST_FACETS:,} sets of {own.m - 1} joints")
    scales = 1.0 / least_speeds(own.indices) if least else row_scales(own)
    chosen = np.full((len(sets or ()), k), -1, dtype=np.int32)
    for row, joints in enumerate(sets or ()):
        chosen[row, : len(joints)] = joints
    given = {"scales": scales, "set_count": len(chosen), "sets": chosen}
    return _losses(arm, q, k, own, given, None if sets is None else len(chosen), threads, speeds=True)


def _losses(
    arm: Arm, q: FloatArray, k: int, task: Task, given: dict[str, Any], every: int | None, threads: int, *, speeds: bool
) -> Losses:
    count = len(q)
    own = arm if task.tool is None else arm.with_tool(arm.tool @ task.tool)
    answers: dict[str, Any] = {"joint": np.empty((count, arm.n)), "worst": np.empty((count, k))}
    which = np.zeros((count, k), dtype=np.int32)
    answers |= {"whole": np.ones(count)} if speeds else {"which": which}
    if every is not None:
        answers["every"] = np.empty((count, every))
    given = {**given, "count": count, "q": q, "rates": full_rates(arm.velocity_limits)}
    _core.losses(own.model, task.indices, task.frame == "tool", speeds, k, given, answers, threads)
    return Losses(answers.get("whole", np.ones(count)), answers["joint"], answers["worst"], which, answers.get("every"))
