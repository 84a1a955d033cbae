"""How well an arm can move its tool: singular values of a task's Jacobian, and their product."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy.typing as npt

from stillreach import _door
from stillreach._core import Metric
from stillreach._door import FloatArray
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm.model import Arm


@runtime_checkable
class Asked(Protocol):
    """What an arm needs to know of a task; ``stillreach.Task`` is one."""

    @property
    def indices(self) -> tuple[int, ...]:
        """Rows of [v; w]."""

    @property
    def frame(self) -> str:
        """The axes they are taken along, "base" or "tool"."""

    @property
    def tool(self) -> FloatArray | None:
        """(4, 4) the task's point seen from the arm's tool, or None."""

    @property
    def weights(self) -> Any:
        """Units and weights, or None."""


def spectra(
    arm: Arm, q: npt.ArrayLike, task: Asked | None, joints: Iterable[str | int] | None, *, product: bool
) -> FloatArray:
    """Singular values (..., min(m, k)) of the chosen joints' weighted Jacobian at q (..., n), or their product."""
    if task is not None and not isinstance(task, Asked):
        raise InputError("task", _door.describe(task), "stillreach.Task, or None for all six rows")
    many = _door.configurations("q", q, arm.labels)
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
    answer = model.spectra(many.reshape(-1, arm.n), metric, rows, along_tool, chosen, product)
    return answer.reshape(many.shape[:-1] + answer.shape[1:])


def _chosen(arm: Arm, joints: Any) -> tuple[int, ...]:
    """Indices of the joints, each once."""
    expected = "names or indices of joints, each once"
    if isinstance(joints, str) or not isinstance(joints, Iterable):
        raise InputError("joints", _door.describe(joints), expected)
    chosen = tuple(arm.joint_index(joint) for joint in joints)
    if len(set(chosen)) < len(chosen):
        raise InputError("joints", _door.describe(joints), expected)
    return chosen
