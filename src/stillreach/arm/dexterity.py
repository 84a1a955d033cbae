"""How well an arm can move its tool: singular values of a task's Jacobian, their product, and lost directions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._core import Metric
from stillreach._door import FloatArray
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm.model import Arm

LEAST_SPEED, LEAST_TURN = 1e-3, float(np.deg2rad(0.1))
"""[m/s] and [rad/s]: a direction in which full rates give less counts as lost."""
FULL_RATE = 1.0
"""[rad/s] or [m/s]: full rate of a joint without a velocity limit."""


@runtime_checkable
class Asked(Protocol):
    """The parts of a task that an arm reads; ``stillreach.Task`` has them."""

    @property
    def indices(self) -> tuple[int, ...]:
        """Rows of [v; w]."""

    @property
    def frame(self) -> str:
        """The axes of the rows, "base" or "tool"."""

    @property
    def tool(self) -> FloatArray | None:
        """(4, 4) the task's point in the frame of the arm's tool, or None."""

    @property
    def weights(self) -> Any:
        """Units and weights, or None."""


class Directions(NamedTuple):
    """Directions of a task, in the coordinates of its Jacobian.

    Args:
        served: (m, k) orthonormal columns: directions in which full rates move the tool.
        lost: (m, m - k) orthonormal columns: the others, worst first.
        gains: (k,) singular values of the served ones: least speeds at full rates.
    """

    served: FloatArray
    lost: FloatArray
    gains: FloatArray


def directions(J: FloatArray, least: FloatArray, to_twist: FloatArray | None = None) -> Directions:
    """Directions that full joint rates serve, by gain. Rank alone would count rounding in a robot file as motion.

    Speeds are measured in least speeds, so the result does not depend on units or weights.

    Args:
        J: (m, k) Jacobian whose columns are scaled by the full rates of their joints.
        least: (rows,) least speeds that count [m/s, rad/s].
        to_twist: (rows, m) matrix from the coordinates of J to a twist; None: these are rows of a twist.
    """
    m = len(J)
    scale = np.diag(1.0 / least) if to_twist is None else np.linalg.qr(to_twist / least[:, None])[1]
    scaled = scale @ J
    U, sigma, _ = np.linalg.svd(scaled, full_matrices=True) if J.size else (np.eye(m), np.zeros(0), None)
    gains = np.pad(sigma, (0, m - len(sigma)))
    weak = np.sum(np.abs(U.T @ scaled), axis=1) < 1.0
    basis = np.linalg.qr(scale.T @ U[:, weak][:, ::-1], mode="complete")[0]
    split = np.count_nonzero(weak)
    return Directions(basis[:, split:], np.ascontiguousarray(basis[:, :split]), gains[~weak])


def full_rates(limits: FloatArray) -> FloatArray:
    """(n,) velocity limits, FULL_RATE for joints without one [rad/s, m/s]."""
    return np.where(np.isfinite(limits), limits, FULL_RATE)


def least_speeds(rows: Iterable[int], speed: float = LEAST_SPEED, turn: float = LEAST_TURN) -> FloatArray:
    """(m,) least speeds [m/s, rad/s] of rows of [v; w]."""
    return np.array([speed if row < 3 else turn for row in rows])


def task_jacobian(arm: Arm, q: FloatArray, task: Asked | None) -> FloatArray:
    """(..., m, n) Jacobian of a task's rows at q (..., n), in metres and radians."""
    if task is None:
        return arm.jacobian(q)
    if task.tool is not None:
        arm = arm.with_tool(arm.tool @ task.tool)
    J = arm.jacobian(q)
    if task.frame == "tool":
        to_tool = np.swapaxes(arm.forward(q)[..., :3, :3], -1, -2)
        J = np.concatenate([to_tool @ J[..., :3, :], to_tool @ J[..., 3:, :]], axis=-2)
    return J[..., task.indices, :]


def spectra(
    arm: Arm, q: npt.ArrayLike, task: Asked | None, joints: Iterable[str | int] | None, *, product: bool
) -> FloatArray:
    """Singular values (..., min(m, k)) of the chosen joints' weighted Jacobian at q (..., n), or their product."""
    checked_task(task)
    values = _door.configurations("q", q, arm.labels)
    chosen = tuple(range(arm.n)) if joints is None else _chosen(arm, joints)
    rows = tuple(range(6)) if task is None else task.indices
    metric, model, along_tool = Metric(len(rows), arm.n), arm.model, False
    if task is not None:
        along_tool = task.frame == "tool"
        if task.weights is not None:
            prismatic = [joint.kind == "prismatic" for joint in arm.joints]
            metric = task.weights.metric([row < 3 for row in rows], prismatic, rows)
        if task.tool is not None:
            model = arm.with_tool(arm.tool @ task.tool).model
    result = model.spectra(values.reshape(-1, arm.n), metric, rows, along_tool, chosen, product)
    return result.reshape(values.shape[:-1] + result.shape[1:])


def checked_task(task: Any) -> None:
    """Raises InputError unless the value is a task or None."""
    if task is not None and not isinstance(task, Asked):
        raise InputError("task", _door.describe(task), "a Task, such as Task('position'), or None for all six rows")


def _chosen(arm: Arm, joints: Any) -> tuple[int, ...]:
    """Indices of the joints, each once."""
    expected = "names or indices of joints, each once"
    if isinstance(joints, str) or not isinstance(joints, Iterable):
        raise InputError("joints", _door.describe(joints), expected)
    chosen = tuple(arm.joint_index(joint) for joint in joints)
    if len(set(chosen)) < len(chosen):
        raise InputError("joints", _door.describe(joints), expected)
    return chosen
