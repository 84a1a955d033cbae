"""Many scenarios of one arm advanced together, each row by itself, with a batch's speed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _core, _door
from stillreach._door import FloatArray
from stillreach._labels import Labels
from stillreach.arm import Arm
from stillreach.batch import bounds_of_rows, motion_limits, threads_of
from stillreach.bounds import Bounds
from stillreach.errors import InputError
from stillreach.laws import Law
from stillreach.task import Task, task_of

__all__ = ["rollout_batch"]

INTEGRATORS = ("euler", "rk4")
MOST_STEPS = 10**12


@dataclass(frozen=True, eq=False)
class BatchRollout:
    """Results of N scenarios. R = steps / every, rounded up; records that were not requested are None.

    Attributes:
        final_q: (N, n) [rad, m] after the last step.
        final_rates: (N, n) [rad/s, m/s] of the last step: ``last_rates`` of a rollout that goes on from there.
        worst_error: (N,) largest weighted task error on the way.
        any_status: (N,) int32 all Status flags of the row's steps.
        q: (N, R, n) before each recorded step.
        rates: (N, R, n).
        task_error: (N, R).
        status: (N, R) int32.
    """

    final_q: FloatArray
    final_rates: FloatArray
    worst_error: FloatArray
    any_status: npt.NDArray[np.int32]
    q: FloatArray | None = None
    rates: FloatArray | None = None
    task_error: FloatArray | None = None
    status: npt.NDArray[np.int32] | None = None

    def __len__(self) -> int:
        return len(self.any_status)


RECORDS = tuple(field.name for field in fields(BatchRollout))[4:]


def rollout_batch(
    arm: Arm,
    law: Law,
    start: npt.ArrayLike,
    twist: npt.ArrayLike,
    bounds: Bounds | tuple[npt.ArrayLike, npt.ArrayLike],
    *,
    period: float,
    steps: int,
    task: Task | None = None,
    last_rates: npt.ArrayLike | None = None,
    integrator: str = "euler",
    record: str | Iterable[str] = (),
    every: int = 1,
    threads: int | None = None,
) -> BatchRollout:
    """Advances N scenarios of one arm together: each step ``solve_batch``, then the joints move at its rates.

    The arm's position and acceleration limits narrow the bounds as a Controller's do. A fault with an onset is a
    rollout up to it, and another from ``final_q`` and ``final_rates`` with the bounds after it. Answers do not depend
    on threads. Bad rows (a NaN, bounds that leave no rate) get INVALID_INPUT and do not stop the others.

    Args:
        arm: the arm.
        law: the law.
        start: (N, n) [rad, m] configurations to start from.
        twist: what the tool should do [m/s, rad/s], base axes: (6,) for all rows and steps, (N, 6) by row, (1, T, 6) by
            step, or (N, T, 6) by both, with T = steps. A command holds for a step.
        bounds: Bounds for all rows, or a pair of arrays (lower, upper), each (N, n), (n,) or one number.
        period: [s] of a step.
        steps: how many.
        task: which rows of the twist count, at which point; None: all six at the arm's tool.
        last_rates: (N, n) rates before the first step; None: at rest.
        integrator: "euler", or "rk4" with rates from the law at each of its stages.
        record: what to record, any of q, rates, task_error, status.
        every: record each so many steps.
        threads: as of ``solve_batch``.

    Raises:
        InputError: an argument of another shape or type, a shared one with a NaN, or records beyond the memory.
    """
    if not isinstance(arm, Arm):
        raise InputError("arm", _door.describe(arm), "stillreach.Arm")
    if not isinstance(law, Law):
        raise InputError("law", _door.describe(law), "a law, such as stillreach.LeastError()")
    metric, model, chosen_task = task_of(arm, law.weights, task, semidefinite=law.semidefinite)
    points = _matrix("start", start, None, arm.labels)
    count, total, interval = len(points), _steps("steps", steps), _steps("every", every)
    commands, strides = _commands(twist, count, total)
    given: dict[str, Any] = {"start": points, "twist": commands}
    given["lower"], given["upper"] = bounds_of_rows(bounds, count, arm.n)
    if last_rates is not None:
        given["last_rates"] = _matrix("last_rates", last_rates, count, arm.labels)
    if np.isfinite(arm.position_limits).any() or np.isfinite(arm.acceleration_limits).any():
        given |= motion_limits(arm)
    answers = _answers(record, count, -(-total // interval), arm.n)
    _core.rollout_batch(
        law.core(chosen_task.row_names, arm.reach, chosen_task.weights),
        metric,
        model,
        chosen_task.indices,
        chosen_task.frame == "tool",
        count,
        total,
        interval,
        _door.positive("period", period),
        _door.choice("integrator", integrator, INTEGRATORS) == "rk4",
        strides,
        given,
        answers,
        threads_of(threads),
    )
    return BatchRollout(**answers)


def _steps(name: str, value: Any) -> int:
    """A number of steps."""
    number = _door.count(name, value)
    if number > MOST_STEPS:
        raise InputError(name, str(number), f"an integer from 1 to {MOST_STEPS}")
    return number


def _matrix(name: str, value: Any, count: int | None, labels: Labels) -> FloatArray:
    """(N, n) as it is; by label where it has labels."""
    n = len(labels.names)
    expected = f"an array ({'N' if count is None else count}, {n})"
    array = _door.array(name, value, expected, labels)
    if array.ndim != 2 or array.shape[1] != n or (count is not None and len(array) != count):
        raise InputError(name, _door.describe(array), expected)
    return array


def _commands(twist: Any, count: int, steps: int) -> tuple[FloatArray, tuple[int, int]]:
    """The commands as a flat array, and how far apart they are per row and per step."""
    expected = f"an array (6,), ({count}, 6), (1, {steps}, 6) or ({count}, {steps}, 6)"
    array = _door.array("twist", twist, expected, _door.TWIST)
    strides = {
        (6,): (0, 0),
        (count, 6): (6, 0),
        (1, steps, 6): (0, 6),
        (count, steps, 6): (6 * steps, 6),
    }.get(array.shape)
    if strides is None:
        raise InputError("twist", _door.describe(array), expected)
    if strides[0] == 0 and not np.isfinite(array).all():
        raise InputError("twist", _door.describe(array), "finite numbers where all rows share them")
    return array.reshape(-1), strides


def _answers(record: str | Iterable[str], count: int, records: int, n: int) -> dict[str, Any]:
    """Arrays for the answers, and for the records that are wanted."""
    if not isinstance(record, Iterable):
        raise InputError("record", _door.describe(record), f"any of {', '.join(RECORDS)}")
    answers: dict[str, Any] = {
        "final_q": np.empty((count, n)),
        "final_rates": np.empty((count, n)),
        "worst_error": np.empty(count),
        "any_status": np.empty(count, dtype=np.int32),
    }
    for name in (record,) if isinstance(record, str) else tuple(record):
        _door.choice("record", name, RECORDS)
        shape = (count, records, n) if name in ("q", "rates") else (count, records)
        try:
            answers[name] = np.empty(shape, dtype=np.int32 if name == "status" else np.float64)
        except (MemoryError, ValueError):
            raise InputError("record", f"{name} of {shape} numbers", "what the memory holds: a larger every") from None
    return answers
