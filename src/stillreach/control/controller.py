"""The controller: one arm, one law, one task, and the state of faults and last rates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy.typing as npt

from stillreach import _door
from stillreach._core import CLOSING_POSITION, CLOSING_RATE, ControllerCore
from stillreach._door import FloatArray
from stillreach.arm.model import Arm
from stillreach.control import limits as of
from stillreach.errors import InputError
from stillreach.faults import FaultKind, Locked, fault_kind
from stillreach.laws import Law, LeastError
from stillreach.null_motions import Manipulability, NullMotion, checked_null_motion, null_motion_settings
from stillreach.status import Health, Status
from stillreach.task import Task, task_of

CONSTRUCTOR = {"velocity": "velocity_limits", "position": "position_limits", "acceleration": "acceleration_limits"}
"""What the constructor calls each limit."""


class Controller(ControllerCore):
    """Turns commanded twists into joint rates, every tick, whatever fails.

    Faults are its state, never a new robot model: indices do not change, a locked joint stays where it is measured.

    Args:
        arm: the arm.
        law: the law; None: LeastError().
        task: the task; None: the full pose.
        period: [s] time between ticks.
        velocity_limits: [rad/s, m/s] one for all, (n,), or (n, 2) lower <= 0 <= upper; None: the arm's.
            0 means 0, inf none.
        position_limits: [rad, m] (n, 2) or one (2,) for all; None: the arm's. Rates towards a limit shrink so that the
            joint can stop at it. A joint outside may not move further out. Limits may also come by joint name.
        acceleration_limits: [rad/s², m/s²] one for all or (n,); None: the arm's.
        null_motion: what to do with the freedom that the task leaves: Posture, Centring, Manipulability, Gradient,
            Rates or bare rates (n,).
        return_rate: [rad/s, m/s] reference rate towards its range for a joint outside its position limits, as far
            as the task leaves it free; 0: none.
        transition_rate: [1/s] when a joint fails or is restored the law stays near the last commanded rates, so that
            the change is the least one that keeps the task; this is how fast the null motion takes over again. 0: none.
        track_gain: [1/s] of ``track``'s feedback on the pose error.
        track_limits: largest correction (linear [m/s], angular [rad/s]), or one for both; inf: no bound. None: the
            fastest that a single working joint, at its rate limit, can move the outstretched arm's tool, and turn it.

    Raises:
        InputError: if an argument is invalid.
    """

    __slots__ = (
        "__weakref__",
        "_arm",
        "_faults",
        "_law",
        "_limits",
        "_null_motion",
        "_settings",
        "_task",
        "_task_weight_definite",
        "_track_limits",
        "tick",
    )
    tick: Callable[[], Status]
    """A place for the tick that ``bind`` returns, where the controller's owner keeps it here; copies do not have it."""

    def __init__(
        self,
        arm: Arm,
        *,
        law: Law | None = None,
        task: Task | None = None,
        period: float = 0.001,
        velocity_limits: npt.ArrayLike | None = None,
        position_limits: npt.ArrayLike | None = None,
        acceleration_limits: npt.ArrayLike | None = None,
        null_motion: NullMotion | npt.ArrayLike | None = None,
        return_rate: float = 0.0,
        transition_rate: float = 2.0,
        track_gain: float = 2.0,
        track_limits: npt.ArrayLike | None = None,
    ) -> None:
        self._arm: Arm = _instance("arm", arm, Arm)
        self._law: Law = LeastError() if law is None else _instance("law", law, Law)
        metric, model, self._task = task_of(arm, self._law.weights, task, semidefinite=self._law.semidefinite)
        self._task_weight_definite = metric.weightless == 0
        self._limits = of.of_arm(arm).changed(
            arm, CONSTRUCTOR, velocity=velocity_limits, position=position_limits, acceleration=acceleration_limits
        )
        self._track_limits = of.track_limits(track_limits)
        self._null_motion = self._checked_null_motion(null_motion)
        self._faults: dict[int, FaultKind] = {}
        self._settings = {
            "period": _door.positive("period", period),
            "return_rate": _door.positive("return_rate", return_rate, or_zero=True),
            "transition_rate": _door.positive("transition_rate", transition_rate, or_zero=True),
            "track_gain": _door.positive("track_gain", track_gain, or_zero=True),
        }
        super().__init__(
            arm=model,
            law=self._law.core(self._task.row_names, arm.reach, self._task.weights),
            metric=metric,
            rows=self._task.indices,
            tool_axes=self._task.frame == "tool",
            rotary=_turns_lead_back(arm),
            labels=arm.labels,
            track_limits=self._track_limits,
            **self._settings,
        )
        self._set_null_motion(*null_motion_settings(self._null_motion, arm.labels))
        self._set_limits(**self._limits.core(), closing=0)

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
        """The faults, by joint name."""
        return {self._arm.joint_names[joint]: kind for joint, kind in sorted(self._faults.items())}

    @property
    def period(self) -> float:
        """[s] time between ticks."""
        return self._settings["period"]

    @property
    def velocity_limits(self) -> FloatArray:
        """(n, 2) lower and upper limits of the rates [rad/s, m/s], at full speed; ``set_limits`` changes them."""
        return self._limits.velocity

    @property
    def position_limits(self) -> FloatArray:
        """(n, 2) lower and upper limits of the positions [rad, m]; ``set_limits`` changes them."""
        return self._limits.position

    @property
    def acceleration_limits(self) -> FloatArray:
        """(n,) limits of the accelerations [rad/s², m/s²]; ``set_limits`` changes them."""
        return self._limits.acceleration

    @property
    def speed(self) -> float:
        """The speed override, a fraction; ``set_speed`` changes it."""
        return self._limits.speed

    def fail(self, joint: str | int, kind: FaultKind = Locked()) -> None:  # noqa: B008 - immutable
        """Marks a joint as failed, from the next tick on.

        Args:
            joint: name or 0-based index.
            kind: what is wrong with it, e.g. Derated(0.2).

        Raises:
            UnknownJointError: if the arm has no such joint.
        """
        index = self._arm.joint_index(joint)
        fault = fault_kind("kind", kind)
        self._set_fault(index, fault.health, *fault.numbers)
        self._faults[index] = fault

    def restore(self, joint: str | int) -> None:
        """Marks a joint as healthy, from the next tick on; without effect if it is."""
        index = self._arm.joint_index(joint)
        if self._faults.pop(index, None) is not None:
            self._set_fault(index, Health.HEALTHY, 0.0, 0.0)

    def reset(self, rates: npt.ArrayLike | None = None) -> None:
        """Sets the last commanded rates: (n,) [rad/s, m/s]; None: 0. Faults stay."""
        self._reset(rates)

    def memory(self) -> Any:
        """What the controller knows and did: faults, last rates, transitions. ``recall`` brings it back."""
        return self._get_state(), dict(self._faults)

    def recall(self, memory: Any) -> None:
        """Goes on from a ``memory()`` of this controller, or of another with the same settings.

        Limits and null motion stay what they are.

        Raises:
            InputError: if the memory is not one of such a controller; nothing is changed.
        """
        if not (isinstance(memory, tuple) and len(memory) == 2 and isinstance(memory[0], bytes)):
            raise InputError("memory", _door.describe(memory), "what memory() of a controller returned")
        core, faults = memory
        try:
            self._set_state(core)
        except InputError as error:
            raise InputError(
                "memory", error.got, f"{error.expected}, of a controller of {self._arm.n} joints"
            ) from None
        self._faults = dict(faults)

    def set_null_motion(self, null_motion: NullMotion | npt.ArrayLike | None) -> None:
        """Another null motion from the next tick on; None for none."""
        motion = self._checked_null_motion(null_motion)
        self._set_null_motion(*null_motion_settings(motion, self._arm.labels))
        self._null_motion = motion

    def _checked_null_motion(self, null_motion: Any) -> Any:
        """InputError also where the null motion does not suit the arm and the task, or its weight is semidefinite."""
        if isinstance(null_motion, Manipulability) and not self._task_weight_definite:
            expected = "positive definite task weights (leave rows out by Task(rows=...)), or another null motion"
            got = f"{type(null_motion).__name__} with task weights that are only semidefinite"
            raise InputError("null_motion", got, expected)
        motion = checked_null_motion(null_motion, self._arm.labels)
        if motion is not None:
            motion.check(self._arm.n, self._task.m)
        return motion

    def set_limits(
        self,
        *,
        velocity: npt.ArrayLike | None = None,
        position: npt.ArrayLike | None = None,
        acceleration: npt.ArrayLike | None = None,
    ) -> None:
        """Other limits from the next tick on; None keeps what is in force.

        A joint that is too fast for new velocity or position limits brakes as hard as its acceleration limit allows
        until it keeps them; without an acceleration limit it keeps them at once. A joint that cannot stop before a new
        position limit passes it, and stops behind it.

        Args:
            velocity: [rad/s, m/s] as the constructor's ``velocity_limits``.
            position: [rad, m] as ``position_limits``.
            acceleration: [rad/s², m/s²] as ``acceleration_limits``.

        Raises:
            InputError: as of the constructor; nothing is changed.
        """
        limits = {"velocity": velocity, "position": position, "acceleration": acceleration}
        closing = CLOSING_RATE * (velocity is not None) | CLOSING_POSITION * (position is not None)
        self._adopt(self._limits.changed(self._arm, {name: name for name in limits}, **limits), closing)

    def set_speed(self, fraction: float) -> None:
        """A speed override from the next tick on: everything that is commanded, at this fraction.

        The twist, ``track``'s correction and the null motion are multiplied by it, and the rates stay below that
        fraction of their limits, so that the arm does the same, more slowly. Rates come down within the acceleration
        limits. A target that moves has to be slowed by its owner.

        Args:
            fraction: from 0 (stand still) to 1.

        Raises:
            InputError: if the fraction is invalid; nothing is changed.
        """
        speed = _door.scalar("fraction", fraction)
        if not 0.0 <= speed <= 1.0:
            raise InputError("fraction", f"{speed:g}", "a number from 0 to 1")
        self._adopt(replace(self._limits, speed=speed), CLOSING_RATE)

    def _adopt(self, limits: of.Limits, closing: int) -> None:
        self._set_limits(**limits.core(), closing=closing)
        self._limits = limits

    def __repr__(self) -> str:
        faults = ", ".join(f"{joint} {kind}" for joint, kind in self.faults.items()) or "no faults"
        return f"<Controller of {self._arm.name}: {self._law}, {1000 * self.period:g} ms, {faults}>"

    def __setattr__(self, name: str, value: Any) -> None:
        try:
            super().__setattr__(name, value)
        except AttributeError:
            ways = "set_limits, set_speed, set_null_motion, fail and restore change a controller"
            raise AttributeError(f"{name} cannot be set: {ways}") from None

    def __reduce__(self) -> tuple[Any, ...]:
        settings = {
            "arm": self._arm,
            "law": self._law,
            "task": self._task,
            "null_motion": self._null_motion,
            "track_limits": self._track_limits,
            **self._settings,
        }
        state = (self._get_state(), dict(self._faults), self._limits, dict(getattr(self, "__dict__", {})))
        return _rebuilt, (type(self), settings), state

    def __setstate__(self, state: tuple[bytes, dict[int, FaultKind], of.Limits, dict[str, Any]]) -> None:
        core, self._faults, limits, own = state
        self._adopt(limits, 0)
        self._set_state(core)
        if own:
            self.__dict__.update(own)


def _rebuilt(kind: type[Controller], settings: dict[str, Any]) -> Controller:
    """A controller of the same kind; a subclass's own attributes come with its state."""
    controller = kind.__new__(kind)
    Controller.__init__(controller, **settings)
    return controller


def _turns_lead_back(arm: Arm) -> list[bool]:
    """(n,) whether the arm's pose is the same after a whole turn of a joint, with all that follow it."""
    back = [True] * arm.n
    for moving in arm.chain:
        back[moving.leader] &= moving.joint.kind == "revolute" and moving.factor == round(moving.factor)
    return back


def _instance(name: str, value: Any, kind: type[Any]) -> Any:
    """The value if it is of the kind; InputError otherwise."""
    if isinstance(value, kind):
        return value
    raise InputError(name, _door.describe(value), f"stillreach.{kind.__name__}")
