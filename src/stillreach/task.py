"""Tasks and weights: which rows of the twist count, along which axes, and in which units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from stillreach import _door
from stillreach._core import ArmModel, Metric
from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.errors import InputError

__all__ = ["Task", "Weights"]

ROWS = {"pose": (0, 1, 2, 3, 4, 5), "position": (0, 1, 2), "orientation": (3, 4, 5)}
FRAMES = ("base", "tool")
SEMIDEFINITE = 1e-12
"""Eigenvalues of a weight count as 0 up to here, with its diagonal scaled to 1."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Weights:
    """Units and weights of task errors and joint rates.

    Args:
        length: [m] the unit of v rows and prismatic joints (0.0254: they are measured in inches).
        angle: [rad] the unit of w rows and revolute joints.
        task: W1, weight of the squared task error in these units: (6,) diagonal or (6, 6) symmetric (for a Jacobian
            with m rows (m,) or (m, m)); None is the identity.
        joints: W2, weight of the squared rates in these units: (n,) diagonal or (n, n) symmetric; None is the identity.

    Weights are positive definite. ``SingularityRobust`` and ``Pseudoinverse`` also accept positive semidefinite ones
    wherever P = J' W1 J + W2 of the paper's eq. (8) is regular: every motion of the joints needs a weight, by itself
    or through the task.

    Raises:
        InputError: if a unit is not positive, or a weight has a wrong shape, is not symmetric or is negative.
    """

    length: float = 1.0
    angle: float = 1.0
    task: FloatArray | None = None
    joints: FloatArray | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "length", _door.positive("length", self.length))
        object.__setattr__(self, "angle", _door.positive("angle", self.angle))
        for name in ("task", "joints"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, _weight(name, value))

    def metric(
        self,
        linear_rows: Sequence[bool],
        prismatic: Sequence[bool],
        rows: Sequence[int] | None = None,
        *,
        semidefinite: bool = False,
    ) -> Metric:
        """The core's form of these weights, for rows and joints of the given kinds.

        Args:
            linear_rows: (m,) True for a row in [m/s], False for [rad/s].
            prismatic: (n,) True for a joint in [m/s].
            rows: which rows of a six-row task weight are used; None: the weight has m rows itself.
            semidefinite: whether weights may be only positive semidefinite.

        Raises:
            InputError: if a weight has another size, or is only semidefinite where that is not accepted.
        """
        kept = None if rows is None else tuple(rows)
        return _metric(self, tuple(linear_rows), tuple(prismatic), kept, semidefinite)

    def _metric(
        self,
        linear_rows: tuple[bool, ...],
        prismatic: tuple[bool, ...],
        rows: tuple[int, ...] | None,
        semidefinite: bool,
    ) -> Metric:
        m, n = len(linear_rows), len(prismatic)
        units = np.where(np.asarray(prismatic, dtype=bool), self.length, self.angle)
        row_units = np.where(np.asarray(linear_rows, dtype=bool), self.length, self.angle)
        W1 = _selected(self.task, m, rows)
        for name, weight in (("task", W1), ("joints", self.joints)):
            if not (semidefinite or weight is None or is_definite(weight)):
                raise InputError(
                    f"weights.{name}",
                    "weights that are only positive semidefinite",
                    "positive definite weights; the laws SingularityRobust and Pseudoinverse accept semidefinite ones",
                )
        factor = np.diag(1.0 / row_units) if W1 is None else _triangle(W1) / row_units
        columns, full = units, None
        if self.joints is not None:
            if len(self.joints) != n:
                raise InputError("weights.joints", _door.describe(self.joints), f"weights of {n} joints")
            if self.joints.ndim == 1 and is_definite(self.joints):
                columns = units / np.sqrt(self.joints)
            else:
                full = np.ascontiguousarray(_full(self.joints))
        return Metric(
            m,
            n,
            rows=None if np.array_equal(factor, np.eye(m)) else np.ascontiguousarray(factor),
            units=None if np.all(units == 1.0) else units,
            columns=None if np.all(columns == 1.0) else columns,
            joints=full,
        )


UNIT_WEIGHTS = Weights()
"""One metre, one radian, all equal."""


@lru_cache(maxsize=64)
def _metric(
    weights: Weights,
    linear_rows: tuple[bool, ...],
    prismatic: tuple[bool, ...],
    rows: tuple[int, ...] | None,
    semidefinite: bool,
) -> Metric:
    """Cached, because a loop of single calls uses the same one every time."""
    return weights._metric(linear_rows, prismatic, rows, semidefinite)


@lru_cache(maxsize=64)
def some_joint_unweighted(weights: Weights) -> bool:
    """Whether the joints' weight is only semidefinite: some motion of the joints has the weight 0."""
    return weights.joints is not None and not is_definite(weights.joints)


def _weight(name: str, value: Any) -> FloatArray:
    """A vector without negative entries, or a symmetric positive semidefinite matrix."""
    if np.ndim(value) == 1:
        vector = _door.vector(name, value, None)
        if not np.all(vector >= 0.0):
            raise InputError(name, _door.describe(value), "weights of at least 0")
        return vector
    expected = "weights (k,) of at least 0 or a symmetric positive semidefinite matrix (k, k)"
    matrix = _door.matrix(name, value, (None, None))
    scale = float(np.max(np.abs(matrix), initial=0.0))
    if matrix.shape[0] != matrix.shape[1] or np.max(np.abs(matrix - matrix.T), initial=0.0) > 1e-12 * scale:
        raise InputError(name, _door.describe(value), expected)
    matrix = (matrix + matrix.T) / 2
    if len(matrix) and _least_eigenvalue(matrix) < -SEMIDEFINITE:
        lowest = float(np.linalg.eigvalsh(matrix)[0])
        raise InputError(name, f"a matrix with the negative eigenvalue {lowest:.3g}", expected)
    return _door.frozen(matrix)


def is_definite(weight: FloatArray) -> bool:
    """Whether a weight is positive definite, and not only semidefinite."""
    return bool(np.all(weight > 0.0)) if weight.ndim == 1 else _least_eigenvalue(weight) > SEMIDEFINITE


def _least_eigenvalue(matrix: FloatArray) -> float:
    """The least eigenvalue of a symmetric matrix whose diagonal is scaled to 1; entries without a diagonal stay."""
    diagonal = np.diag(matrix)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, max(float(np.max(np.abs(matrix))), 1e-300)))
    return float(np.linalg.eigvalsh(matrix / np.outer(scale, scale))[0])


def _full(weight: FloatArray) -> FloatArray:
    """A weight as a matrix."""
    return np.diag(weight) if weight.ndim == 1 else weight


def _triangle(W1: FloatArray) -> FloatArray:
    """Upper triangular R with R'R = W1; where W1 is only semidefinite, its last rows are 0."""
    if is_definite(W1):
        return np.asarray(np.linalg.cholesky(W1).T)
    root = weight_root(W1)
    R = np.zeros(W1.shape)
    R[: len(root)] = np.linalg.qr(root, mode="r")
    return R


def weight_root(weight: FloatArray) -> FloatArray:
    """S (rank, k) with S'S the weight."""
    full = _full(weight)
    diagonal = np.diag(full)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(full / np.outer(scale, scale))
    kept = values > SEMIDEFINITE
    return np.asarray(np.sqrt(values[kept])[:, None] * vectors[:, kept].T * scale)


def _selected(W1: FloatArray | None, m: int, rows: Sequence[int] | None) -> FloatArray | None:
    """The task weight of the rows in use, as an (m, m) matrix."""
    if W1 is None:
        return None
    full = _full(W1)
    if rows is not None and len(full) == 6:
        return full[np.ix_(rows, rows)]
    if len(full) != m:
        expected = f"weights of {m} rows" + ("" if rows is None else " or of 6")
        raise InputError("weights.task", _door.describe(W1), expected)
    return full


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """Which part of the commanded twist is the task.

    Args:
        rows: "pose" (all six), "position", "orientation", or a mask of 6 booleans over [vx, vy, vz, wx, wy, wz];
            (True, True, True, True, True, False) in the tool frame is five-axis work.
        frame: the axes that the rows are taken along, "base" or "tool". The commanded twist is along base axes always.
        tool: (4, 4) [m] the task's point and axes seen from the arm's tool; None: the arm's tool itself.
        weights: units and weights; None: one metre, one radian, all equal.

    Raises:
        InputError: if an argument is invalid.
    """

    rows: str | Sequence[bool] = "pose"
    frame: str = "base"
    tool: FloatArray | None = None
    weights: Weights | None = None
    indices: tuple[int, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "indices", _row_indices(self.rows))
        _door.choice("frame", self.frame, FRAMES)
        if self.tool is not None:
            object.__setattr__(self, "tool", _door.pose("tool", self.tool))
        if self.weights is not None and not isinstance(self.weights, Weights):
            raise InputError("weights", _door.describe(self.weights), "stillreach.Weights")

    @property
    def row_names(self) -> tuple[str, ...]:
        """Names of the rows, among vx, vy, vz, wx, wy, wz."""
        return tuple("vvvwww"[i] + "xyz"[i % 3] for i in self.indices)

    @property
    def m(self) -> int:
        """Number of task rows."""
        return len(self.indices)


def _row_indices(rows: str | Sequence[bool]) -> tuple[int, ...]:
    """Indices into [v; w] of the selected rows."""
    if isinstance(rows, str):
        return ROWS[_door.choice("rows", rows, tuple(ROWS))]
    mask = list(rows) if isinstance(rows, Sequence | np.ndarray) else []
    if len(mask) != 6 or not all(isinstance(flag, bool | np.bool_) for flag in mask) or not any(mask):
        raise InputError(
            "rows", _door.describe(rows), "'pose', 'position', 'orientation' or 6 booleans, one of them True"
        )
    return tuple(i for i, flag in enumerate(mask) if flag)


def task_of(
    arm: Arm, weights: Weights | None, task: Any, *, semidefinite: bool = False
) -> tuple[Metric, ArmModel, Task]:
    """Metric of the task's rows, the arm with the task's tool, and the task; None is all six rows.

    Args:
        arm: the arm.
        weights: those of the law.
        task: a Task or None.
        semidefinite: whether the law accepts weights that are only positive semidefinite.

    Raises:
        InputError: if it is not a task, has other weights than the law, or weights that the law cannot use.
    """
    chosen_task = Task() if task is None else task
    if not isinstance(chosen_task, Task):
        raise InputError("task", _door.describe(chosen_task), "a Task, such as Task('position')")
    if weights is not None and chosen_task.weights is not None and weights is not chosen_task.weights:
        raise InputError("weights", "different weights of law and task", "weights in one of them")
    prismatic = [joint.kind == "prismatic" for joint in arm.joints]
    linear = [row < 3 for row in chosen_task.indices]
    chosen = weights or chosen_task.weights or UNIT_WEIGHTS
    metric = chosen.metric(linear, prismatic, chosen_task.indices, semidefinite=semidefinite)
    _refuse_singular(chosen, chosen_task)
    return metric, (arm if chosen_task.tool is None else arm.with_tool(arm.tool @ chosen_task.tool)).model, chosen_task


def _refuse_singular(weights: Weights, task: Task) -> None:
    """Weights with which P = J' W1 J + W2 is singular for every Jacobian.

    Raises:
        InputError: if the joints without weight are more than the task has rows with weight.
    """
    if weights.joints is None or not some_joint_unweighted(weights):
        return
    W1 = _selected(weights.task, task.m, task.indices)
    rows = task.m if W1 is None else len(weight_root(W1))
    rank, n = len(weight_root(weights.joints)), len(weights.joints)
    if rank + rows < n:
        raise InputError(
            "weights.joints",
            f"weights of rank {rank} for {n} joints",
            f"a rank of at least {n - rows}: P = J' W1 J + W2 of eq. (8) must be regular, and the task has {rows} rows "
            "with weight",
        )
