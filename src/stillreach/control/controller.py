"""The controller: one arm, one law, one task; what is broken and what was commanded last."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._core import ControllerCore
from stillreach._door import FloatArray
from stillreach.arm.model import Arm
from stillreach.control.null_motion import Manipulability, NullMotion, null_motion_settings
from stillreach.errors import InputError
from stillreach.faults import FaultKind, Locked, fault_kind
from stillreach.laws import Law, LeastError
from stillreach.status import Health
from stillreach.task import Task, task_of


class Controller(ControllerCore):
    """Turns commanded twists into joint rates, every tick, whatever fails.

    Faults are its state, never a new robot model: indices do not change, a locked joint stays where it is measured.

    Args:
        arm: the arm.
        law: what is best; LeastError() where None.
        task: what is asked; the full pose where None.
        period: [s] time between ticks.
        rate_limits: [rad/s, m/s] one for all, (n,), or (n, 2) lower <= 0 <= upper; None: the arm's.
            0 means 0, inf none.
        position_limits: [rad, m] (n, 2) or one (2,) for all; None: the arm's. Rates towards a limit shrink so that the
            joint can stop at it. A joint outside may not move further out.
        acceleration_limits: [rad/s², m/s²] one for all or (n,); None: the arm's.
        null_motion: what to do with the freedom that the task leaves: Posture, Centring, Manipulability, Gradient,
            Rates or bare rates (n,).
        return_rate: [rad/s, m/s] at which a joint outside its position limits is asked back as far as the task leaves
            it free; 0: it is not asked.
        transition_rate: [1/s] when a joint fails or is restored the law stays near the last commanded rates, so that
            the change is the least one that keeps the task; this is how fast the null motion takes over again. 0: none.
        track_gain: [1/s] of ``track``'s feedback on the pose error.
        track_limits: largest correction (linear [m/s], angular [rad/s]); None: no bound.

    Raises:
        InputError: any argument that is not what it says here.
    """

    def __init__(
        self,
        arm: Arm,
        *,
        law: Law | None = None,
        task: Task | None = None,
        period: float = 0.001,
        rate_limits: npt.ArrayLike | None = None,
        position_limits: npt.ArrayLike | None = None,
        acceleration_limits: npt.ArrayLike | None = None,
        null_motion: NullMotion | npt.ArrayLike | None = None,
        return_rate: float = 0.0,
        transition_rate: float = 2.0,
        track_gain: float = 2.0,
        track_limits: tuple[float, float] | None = None,
    ) -> None:
        self._arm: Arm = _instance("arm", arm, Arm)
        self._law: Law = LeastError() if law is None else _instance("law", law, Law)
        metric, model, self._task = task_of(arm, self._law.weights, task, semidefinite=self._law.semidefinite)
        n = arm.n
        rates = _rate_limits(arm, rate_limits)
        positions = _position_limits(arm, position_limits)
        accelerations = arm.acceleration_limits if acceleration_limits is None else acceleration_limits
        linear, angular = _track_limits(track_limits)
        self._task_weight_definite = metric.weightless == 0
        settings = self._null_motion_settings(null_motion)
        super().__init__(
            arm=model,
            law=self._law.core(self._task.row_names, arm.reach, self._task.weights),
            metric=metric,
            rows=self._task.indices,
            tool_axes=self._task.frame == "tool",
            period=_door.positive("period", period),
            rate_lower=np.ascontiguousarray(rates[:, 0]),
            rate_upper=np.ascontiguousarray(rates[:, 1]),
            position_lower=np.ascontiguousarray(positions[:, 0]),
            position_upper=np.ascontiguousarray(positions[:, 1]),
            acceleration=_door.vector("acceleration_limits", accelerations, n, allow_inf=True, minimum=0.0),
            return_rate=_door.positive("return_rate", return_rate, or_zero=True),
            transition_rate=_door.positive("transition_rate", transition_rate, or_zero=True),
            track_gain=_door.positive("track_gain", track_gain, or_zero=True),
            track_linear=linear,
            track_angular=angular,
        )
        self._set_null_motion(*settings)
        self._faults: dict[int, FaultKind] = {}

    @property
    def arm(self) -> Arm:
        """The arm."""
        return self._arm

    @property
    def law(self) -> Law:
        """The law."""
        return self._law

    @property
    def task(self) -> Task:
        """The task."""
        return self._task

    @property
    def faults(self) -> dict[str, FaultKind]:
        """What is broken, by joint name."""
        return {self._arm.joint_names[joint]: kind for joint, kind in sorted(self._faults.items())}

    def fail(self, joint: str | int, kind: FaultKind = Locked()) -> None:  # noqa: B008 - immutable
        """A joint fails, from the next tick on: locked where it is, or as ``kind`` says.

        Args:
            joint: name or 0-based index.
            kind: Locked(), Derated(fraction) or Runaway(rate).

        Raises:
            UnknownJointError: the arm has no such joint.
        """
        index = self._arm.joint_index(joint)
        fault = fault_kind("kind", kind)
        self._set_health(index, int(fault.health), fault.value)
        self._faults[index] = fault

    def restore(self, joint: str | int) -> None:
        """A joint works again, from the next tick on (nothing happens where it never failed)."""
        index = self._arm.joint_index(joint)
        if self._faults.pop(index, None) is not None:
            self._set_health(index, int(Health.HEALTHY), 0.0)

    def reset(self, rates: npt.ArrayLike | None = None) -> None:
        """Tells what the last commanded rates were: (n,) [rad/s, m/s], 0 where None. Faults stay."""
        self._reset(rates)

    def set_null_motion(self, null_motion: NullMotion | npt.ArrayLike | None) -> None:
        """Another null motion from the next tick on; None for none."""
        self._set_null_motion(*self._null_motion_settings(null_motion))

    def _null_motion_settings(self, null_motion: Any) -> Any:
        """As the core reads them; InputError for Manipulability of a task whose weight is only semidefinite."""
        if isinstance(null_motion, Manipulability) and not self._task_weight_definite:
            expected = "positive definite task weights (leave rows out by Task(rows=...)), or another null motion"
            raise InputError("null_motion", "Manipulability with task weights that are only semidefinite", expected)
        return null_motion_settings(null_motion, self._arm.n)


def _instance(name: str, value: Any, kind: type[Any]) -> Any:
    """The value if it is of the kind; InputError otherwise."""
    if isinstance(value, kind):
        return value
    raise InputError(name, _door.describe(value), f"stillreach.{kind.__name__}")


def _rate_limits(arm: Arm, value: npt.ArrayLike | None) -> FloatArray:
    """(n, 2) lower and upper rate limits."""
    if value is not None and np.ndim(value) == 2:
        limits = _door.matrix("rate_limits", value, (arm.n, 2), allow_inf=True)
        if np.any(limits[:, 0] > 0.0) or np.any(limits[:, 1] < 0.0):
            raise InputError("rate_limits", _door.describe(value), "lower <= 0 <= upper for each joint")
        return limits
    high = _door.vector(
        "rate_limits", arm.velocity_limits if value is None else value, arm.n, allow_inf=True, minimum=0.0
    )
    return np.stack([-high, high], axis=1)


def _position_limits(arm: Arm, value: npt.ArrayLike | None) -> FloatArray:
    """(n, 2) lower and upper position limits."""
    if value is None:
        return arm.position_limits
    both = np.broadcast_to(value, (arm.n, 2)) if np.shape(value) == (2,) else value
    limits = _door.matrix("position_limits", both, (arm.n, 2), allow_inf=True)
    if np.any(limits[:, 0] > limits[:, 1]):
        raise InputError("position_limits", _door.describe(value), "lower <= upper for each joint")
    return limits


def _track_limits(value: tuple[float, float] | None) -> tuple[float, float]:
    """Largest linear and angular correction."""
    if value is None:
        return np.inf, np.inf
    pair = _door.vector("track_limits", value, 2, allow_inf=True, minimum=0.0)
    return float(pair[0]), float(pair[1])
