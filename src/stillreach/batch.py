"""Many independent problems of one arm in one call: on SIMD lanes and several threads, with the GIL released."""

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
from stillreach.bounds import Bounds
from stillreach.errors import InputError
from stillreach.laws import Law
from stillreach.laws.law import row_names
from stillreach.task import Task, task_of

__all__ = ["solve_batch"]


@dataclass(frozen=True, eq=False)
class BatchSolution:
    """Results of N rows; fields that were not requested are None.

    Attributes:
        rates: (N, n) [rad/s, m/s].
        status: (N,) int32 Status bits; ``Status(batch.status[i])`` names them. INVALID_INPUT marks rows with a NaN, an
            infinite value or contradictory bounds: their rates are 0, or the nearest value inside the bounds.
        residual: (N, m) twist - J rates.
        damping: (N,) damping factor.
        scale: (N,) fraction of the twist that was kept.
        task_error: (N,) weighted norm of the residual.
        pose: (N, 4, 4) [m] of the tool; zeros in rows that are invalid.
        jacobian: (N, m, n) of the task's rows.
        active: (N, n) int8: as ``Solution.active``. Without ``last_rates`` only the bounds are known: FAULT for a joint
            with one rate left, RATE for any other active bound.
        iterations: (N,) int32 factorisations, or steps of the damping search.
    """

    rates: FloatArray
    status: npt.NDArray[np.int32]
    residual: FloatArray | None = None
    damping: FloatArray | None = None
    scale: FloatArray | None = None
    task_error: FloatArray | None = None
    pose: FloatArray | None = None
    jacobian: FloatArray | None = None
    active: npt.NDArray[np.int8] | None = None
    iterations: npt.NDArray[np.int32] | None = None

    def __len__(self) -> int:
        return len(self.status)


WANTED = tuple(field.name for field in fields(BatchSolution))[2:]
MOST_THREADS = 1024


def solve_batch(
    arm: Arm | None,
    law: Law,
    q: npt.ArrayLike | None,
    twist: npt.ArrayLike,
    bounds: Bounds | tuple[npt.ArrayLike, npt.ArrayLike],
    *,
    jacobians: npt.ArrayLike | None = None,
    task: Task | None = None,
    reference: npt.ArrayLike | None = None,
    last_rates: npt.ArrayLike | None = None,
    period: float | None = None,
    want: str | Iterable[str] = (),
    out: npt.ArrayLike | None = None,
    row_kinds: str | None = None,
    joint_kinds: str | None = None,
    length: float | None = None,
    threads: int | None = None,
) -> BatchSolution:
    """The best joint rates of N independent rows; each is what ``law.solve`` gives for it alone, to the last bit.

    Float64 arrays in C order are used where they are; others are converted. Memory beyond the answers does not grow
    with N. Invalid rows (a NaN, contradictory bounds) get INVALID_INPUT and do not affect the others.

    Args:
        arm: the arm; None where ``jacobians`` come from elsewhere.
        law: the law.
        q: (N, n) [rad, m] configurations, or a DataFrame with a column for each joint, or None with ``jacobians``.
        twist: (N, 6) or (6,) for all [m/s, rad/s] of the tool along base axes; with ``jacobians`` (N, m) or (m,).
        bounds: Bounds for all rows, or a pair of arrays (lower, upper), each (N, n), (n,) or one number.
        jacobians: (N, m, n), m <= 6, in place of configurations; [v; w] where m is 6.
        task: which rows of the twist count, at which point; None: all six at the arm's tool.
        reference: (N, n) or (n,) rates to stay near where the task leaves a choice; None is 0.
        last_rates: (N, n) rates commanded a tick ago: the arm's position and acceleration limits then narrow the
            bounds as a Controller's do, with ``period``.
        period: [s] of a tick; only with ``last_rates``.
        want: what else to return, any of residual, damping, scale, task_error, pose, jacobian, active, iterations.
        out: (N, n) float64, C order, writable: receives the rates instead of a new array. It shares no memory with an
            input.
        row_kinds: with ``jacobians`` of m != 6 rows: v for a row in m/s, w for one in rad/s.
        joint_kinds: with ``jacobians`` and no arm: R or P for each joint; None: all revolute.
        length: [m] with ``jacobians``: a length typical of the arm, needed without an arm where the law has a price
            for v rows alone.
        threads: how many to use, up to 1024; None: the environment's STILLREACH_THREADS, or the processors at hand.
            Answers do not depend on it.

    Raises:
        InputError: if an argument has a wrong shape or type, or a shared one has a NaN.
    """
    if not isinstance(law, Law):
        raise InputError("law", _door.describe(law), "a law, such as stillreach.LeastError()")
    problem = (
        _of_configurations(arm, law, q, twist, task, row_kinds, joint_kinds, length)
        if jacobians is None
        else _of_jacobians(arm, law, q, jacobians, twist, task, row_kinds, joint_kinds, length)
    )
    settings, metric, model, rows, tool_axes, given = problem
    source = given["q"] if model is not None else given["jacobians"]
    count, m, n = len(source), len(rows), source.shape[-1]
    given["lower"], given["upper"] = bounds_of_rows(bounds, count, n)
    if reference is not None:
        given["reference"] = _rows("reference", reference, count, n, None if arm is None else arm.labels)
    given |= _last(arm, model, last_rates, period, count, n)
    answers = _answers(want, model is not None, count, m, n)
    answers["rates"] = np.empty((count, n)) if out is None else _apart("out", out, given)
    _core.solve_batch(settings, metric, model, rows, tool_axes, count, given, answers, threads_of(threads))
    return BatchSolution(**answers)


def _of_configurations(
    arm: Any,
    law: Law,
    q: Any,
    twist: Any,
    task: Task | None,
    row_kinds: str | None,
    joint_kinds: str | None,
    length: float | None,
) -> tuple[_core.Law, _core.Metric, _core.ArmModel | None, tuple[int, ...], bool, dict[str, Any]]:
    """Metric, arm, task rows, whether they are the tool's, and the arrays of a call with configurations."""
    if not isinstance(arm, Arm):
        raise InputError("arm", _door.describe(arm), "stillreach.Arm (or jacobians=)")
    for name, value in (("row_kinds", row_kinds), ("joint_kinds", joint_kinds), ("length", length)):
        if value is not None:
            raise InputError(name, _door.describe(value), "None: the arm and the task define it")
    metric, model, chosen_task = task_of(arm, law.weights, task, semidefinite=law.semidefinite)
    points = _door.array("q", q, "an array (N, n)", arm.labels)
    if points.ndim != 2 or points.shape[1] != arm.n:
        raise InputError("q", _door.describe(points), f"an array (N, {arm.n}) of joint values")
    given = {"q": points, "twist": _rows("twist", twist, len(points), 6, _door.TWIST)}
    settings = law.core(chosen_task.row_names, arm.reach, chosen_task.weights)
    return settings, metric, model, chosen_task.indices, chosen_task.frame == "tool", given


def _of_jacobians(
    arm: Any,
    law: Law,
    q: Any,
    jacobians: Any,
    twist: Any,
    task: Any,
    row_kinds: str | None,
    joint_kinds: str | None,
    length: float | None,
) -> tuple[_core.Law, _core.Metric, _core.ArmModel | None, tuple[int, ...], bool, dict[str, Any]]:
    """The same of a call with Jacobians."""
    for name, value in (("q", q), ("task", task)):
        if value is not None:
            raise InputError(name, _door.describe(value), "None, as jacobians are given")
    matrices = _door.array("jacobians", jacobians, "an array (N, m, n)")
    if matrices.ndim != 3 or not 1 <= matrices.shape[1] <= 6 or matrices.shape[2] < 1:
        raise InputError("jacobians", _door.describe(matrices), "an array (N, m, n) with 1 to 6 rows each")
    count, m, n = matrices.shape
    if arm is not None:
        if not isinstance(arm, Arm) or arm.n != n:
            raise InputError("arm", _door.describe(arm), f"None or an arm of {n} joints, as the Jacobians have columns")
        joint_kinds = "".join("P" if joint.kind == "prismatic" else "R" for joint in arm.joints)
    metric = law._metric(m, n, row_kinds, joint_kinds)
    reach = (None if arm is None else arm.reach) if length is None else _door.positive("length", length)
    settings = law.core(row_names(m, row_kinds), reach)
    given = {"jacobians": matrices, "twist": _rows("twist", twist, count, m)}
    return settings, metric, None, tuple(range(m)), False, given


def bounds_of_rows(bounds: Any, count: int, n: int) -> tuple[FloatArray, FloatArray]:
    """Lower and upper bounds, both (n,) or both (N, n)."""
    if isinstance(bounds, Bounds):
        if bounds.n != n:
            raise InputError("bounds", f"bounds of {bounds.n} joints", f"bounds of {n} joints")
        return bounds.lower, bounds.upper
    expected = f"stillreach.Bounds, or a pair of arrays (lower, upper) of shape ({count}, {n}) or ({n},)"
    if not isinstance(bounds, tuple | list) or len(bounds) != 2:
        raise InputError("bounds", _door.describe(bounds), expected)
    low, high = (_door.array("bounds", side, expected) for side in bounds)
    for side in (low, high):
        if side.shape not in ((count, n), (n,), ()):
            raise InputError("bounds", _door.describe(side), expected)
    if low.ndim < 2 and high.ndim < 2:
        try:
            shared = Bounds(np.broadcast_to(low, n), np.broadcast_to(high, n))
        except InputError as error:
            raise InputError("bounds", error.got, f"for all rows {error.expected}") from None
        return shared.lower, shared.upper
    return tuple(np.ascontiguousarray(np.broadcast_to(side, (count, n))) for side in (low, high))  # type: ignore[return-value]


def _last(arm: Any, model: Any, last_rates: Any, period: Any, count: int, n: int) -> dict[str, Any]:
    """What turns limits of position and acceleration into bounds."""
    if last_rates is None:
        if period is not None:
            raise InputError("period", _door.describe(period), "None without last_rates")
        return {}
    if model is None:
        raise InputError("last_rates", _door.describe(last_rates), "None with jacobians: limits are an arm's")
    last = _rows("last_rates", last_rates, count, n, arm.labels)
    return {
        "last": np.ascontiguousarray(np.broadcast_to(last, (count, n))),
        "period": _door.positive("period", period),
        **motion_limits(arm),
    }


def motion_limits(arm: Arm) -> dict[str, FloatArray]:
    """Position and acceleration limits, (n,) each, as the core reads them."""
    return {
        "position_lower": np.ascontiguousarray(arm.position_limits[:, 0]),
        "position_upper": np.ascontiguousarray(arm.position_limits[:, 1]),
        "acceleration": np.ascontiguousarray(arm.acceleration_limits),
    }


def _answers(want: str | Iterable[str], has_arm: bool, count: int, m: int, n: int) -> dict[str, Any]:
    """Arrays for the answers that are wanted."""
    choices = WANTED if has_arm else tuple(name for name in WANTED if name != "pose")
    if not isinstance(want, Iterable):
        raise InputError("want", _door.describe(want), f"any of {', '.join(choices)}")
    names = (want,) if isinstance(want, str) else tuple(want)
    answers: dict[str, Any] = {"status": np.empty(count, dtype=np.int32)}
    shapes = {"residual": (count, m), "pose": (count, 4, 4), "jacobian": (count, m, n), "active": (count, n)}
    types = {"active": np.int8, "iterations": np.int32}
    for name in names:
        _door.choice("want", name, choices)
        answers[name] = np.empty(shapes.get(name, (count,)), dtype=types.get(name, np.float64))
    return answers


def _apart(name: str, array: Any, given: dict[str, Any]) -> Any:
    """The caller's array for the rates, which must not lie where a row that is still to come is read."""
    if not isinstance(array, np.ndarray):
        raise InputError(name, _door.describe(array), "a writable C-contiguous float64 array (N, n), or None")
    for other, values in given.items():
        if isinstance(values, np.ndarray) and np.may_share_memory(array, values):
            raise InputError(name, f"an array in the memory of {other}", "memory of its own")
    return array


def threads_of(value: Any) -> int:
    """How many threads to use, 0 for the default; InputError otherwise."""
    if value is None:
        return 0
    number = _door.count("threads", value)
    if number > MOST_THREADS:
        raise InputError("threads", str(number), f"an integer from 1 to {MOST_THREADS}")
    return number


def _rows(name: str, value: Any, count: int, length: int, labels: Labels | None = None) -> FloatArray:
    """(N, length) as it is, or (length,) finite numbers that all rows share; by label where it has labels."""
    expected = f"an array of shape ({count}, {length}), or ({length},) for all rows"
    array = _door.array(name, value, expected, labels)
    if array.shape == (length,):
        return _door.vector(name, array, length)
    if array.shape != (count, length):
        raise InputError(name, _door.describe(array), expected)
    return array
