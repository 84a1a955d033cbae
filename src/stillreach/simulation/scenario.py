"""A simulation as a value: which arm starts where, what it is told, what breaks and when."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.control import Controller
from stillreach.control.controller import CONSTRUCTOR
from stillreach.control.limits import track_limits
from stillreach.errors import InputError
from stillreach.faults import Fault
from stillreach.laws import Law, LeastError
from stillreach.null_motions import NullMotion, checked_null_motion
from stillreach.simulation.motion import TICK_TOLERANCE, Motion, checked_motion, ends
from stillreach.simulation.plausible import goals_beyond_reach, start_outside
from stillreach.simulation.record import row_bytes
from stillreach.simulation.schedule import Schedule, schedule_of
from stillreach.task import Task

INTEGRATORS = ("euler", "rk4")
LOOPS = ("open", "closed")
CLOCKS = ("time", "arm")
LARGEST_RECORD = 2**33
"""[bytes] of a run; a duration or period mistyped by a few orders of magnitude is refused, not begun."""
CONTROLLER_SETTINGS = (
    "law",
    "task",
    "period",
    "velocity_limits",
    "position_limits",
    "acceleration_limits",
    "null_motion",
    "track_limits",
    "return_rate",
    "transition_rate",
)
"""What a scenario hands to its controller as it is."""


@dataclass(frozen=True, eq=False)
class Scenario:
    """What ``simulate`` runs. Immutable; ``dataclasses.replace`` makes variants.

    Attributes hold what was checked: parts of the motion and faults as tuples, limits as arrays for each joint.

    Args:
        arm: the arm.
        start: (n,) joint values at time 0 [rad] or [m], or a mapping or pandas Series by joint name.
        motion: one part or a list of them, one after the other: ConstantTwist, Line, Circle, Waypoints or PoseTable;
            the last may be a function of time or a ConstantTwist without a duration. After the last part the commanded
            twist is zero.
        faults: what fails when. A fault begins and ends at the first tick that is not before its time; of two on one
            joint the one that began last holds.
        law: how the rates are found; LeastError() where None.
        task: what is asked of the tool; the full pose where None.
        period: time between ticks [s].
        duration: how long [s]; the last tick is the last one not after it. None is the motion's own.
        integrator: ``"euler"`` (the rates of a tick are held until the next one, as a robot's drives do) or ``"rk4"``
            (classical fourth-order Runge-Kutta: the law is asked at half steps, too).
        velocity_limits: (n,) or one for all [rad/s] or [m/s], inf for none; None takes the arm's own.
        position_limits: (n, 2) or one pair for all [rad] or [m]; None takes the arm's own.
        acceleration_limits: (n,) or one for all [rad/s²] or [m/s²], inf for none; None takes the arm's own.
        null_motion: what is done with the freedom that the task leaves, as for Controller; None is nothing.
        loop: ``"open"`` (the commanded twist alone) or ``"closed"`` (feedback on the pose that the commanded motion has
            led to, as ``Controller.track``, with the command as its feedforward).
        clock: ``"time"``, or ``"arm"``: the motion waits for the arm. Each tick takes its time on by the tick's
            ``scale`` times the period, so that under KeepDirection the tool slows down and is not left behind.
            Needs a duration, within which the motion may or may not end, and Euler steps.
        track_gain: [1/s] of that feedback.
        track_limits: largest correction (linear [m/s], angular [rad/s]), as for Controller; inf: no bound.
        return_rate: [rad/s, m/s] at which joints outside their position limits are asked back, as for Controller.
        transition_rate: [1/s] how fast the null motion takes over again after a fault, as for Controller; 0: at once.
        allow_outside: whether the start may be outside the position limits, and courses may lead farther than the arm
            reaches. The usual cause of both is degrees or millimetres where radians and metres are meant.
        name: what plots and files call it.
        description: what it shows, for readers; `stillreach run` prints its first paragraph.

    Raises:
        InputError: if an argument is invalid.
        UnknownJointError: a fault names a joint that the arm does not have.
    """

    _: KW_ONLY
    arm: Arm
    start: FloatArray
    motion: Sequence[Motion] | Motion
    faults: Sequence[Fault] = ()
    law: Law | None = None
    task: Task | None = None
    period: float = 0.01
    duration: float | None = None
    integrator: str = "euler"
    velocity_limits: npt.ArrayLike | None = None
    position_limits: npt.ArrayLike | None = None
    acceleration_limits: npt.ArrayLike | None = None
    null_motion: NullMotion | npt.ArrayLike | None = None
    loop: str = "open"
    clock: str = "time"
    track_gain: float = 2.0
    track_limits: tuple[float, float] | None = None
    return_rate: float = 0.0
    transition_rate: float = 2.0
    allow_outside: bool = False
    name: str = ""
    description: str = ""

    def __post_init__(self) -> None:
        if not isinstance(self.arm, Arm):
            raise InputError("arm", _door.describe(self.arm), "an Arm")
        for name in (self.arm.name, *self.arm.joint_names):
            _door.text("arm", name)
        checked = {
            "name": _door.text("name", self.name),
            "description": _door.text("description", self.description),
            "law": LeastError() if self.law is None else self.law,
            "task": Task() if self.task is None else self.task,
            "start": _door.vector("start", self.start, self.arm.n, labels=self.arm.labels),
            "motion": checked_motion(self.motion),
            "faults": self._checked_faults(),
            "period": _door.positive("period", self.period),
            "clock": _door.choice("clock", self.clock, CLOCKS),
            "duration": self._checked_duration(),
            "integrator": self._checked_integrator(),
            "loop": _door.choice("loop", self.loop, LOOPS),
            "track_gain": _door.positive("track_gain", self.track_gain, or_zero=True),
            "allow_outside": self._checked_allow(),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        self._refuse_too_long()
        # what cannot be used is refused here and not in the middle of a program
        self._keep_checked(self.controller())
        _ = self.schedule
        if not self.allow_outside:
            for error in [*start_outside(self), *goals_beyond_reach(self)]:
                raise error

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Scenario:
        """A scenario from a TOML file (docs/scenarios.md), or one that comes with the package.

        Args:
            path: the file, or the name of a ready scenario (``stillreach.scenario_names()``).

        Raises:
            ScenarioFileError: there is no such file, or something is wrong with it: ``mistakes`` holds everything.
        """
        from stillreach.simulation.scenario_file import load

        return load(path)

    def controller(self) -> Controller:
        """A new controller as the scenario describes it, nothing failed yet.

        Raises:
            InputError: if a setting is invalid.
        """
        settings = {name: getattr(self, name) for name in CONTROLLER_SETTINGS}
        return Controller(self.arm, track_gain=self.track_gain, **settings)

    @cached_property
    def schedule(self) -> Schedule:
        """The plan in ticks: parts of the motion, and changes of faults."""
        return schedule_of(self)

    @property
    def title(self) -> str:
        """Its name, or else its arm and law."""
        return self.name or f"{self.arm.name} under {type(self.law).__name__}"

    def task_pose(self, q: FloatArray) -> FloatArray:
        """Pose of the task's point at joint values (n,), (4, 4) [m]."""
        T = self.arm.forward(q)
        return T if self.task is None or self.task.tool is None else T @ self.task.tool

    @property
    def steps(self) -> int:
        """Number of steps; a run of it has one tick more."""
        assert self.duration is not None
        ticks = self.duration / self.period
        return int(np.floor(ticks + _slack(ticks)))

    def tick_at(self, time: float) -> int:
        """The first tick that is not before a time [s]; infinite times are after every tick."""
        with np.errstate(over="ignore"):
            ticks = float(np.divide(time, self.period))
        if np.isinf(ticks):
            return self.steps + 1
        return max(0, int(np.ceil(ticks - _slack(ticks))))

    def _keep_checked(self, controller: Controller) -> None:
        """Limits and null motion as a controller has checked them: nobody else can change them."""
        limits = {name: getattr(controller, name) for name in CONSTRUCTOR.values() if getattr(self, name) is not None}
        settings = {
            "null_motion": checked_null_motion(self.null_motion, self.arm.labels),
            "track_limits": track_limits(self.track_limits),
            "return_rate": float(self.return_rate),
            "transition_rate": float(self.transition_rate),
        }
        for name, value in (limits | settings).items():
            object.__setattr__(self, name, value)

    def _refuse_too_long(self) -> None:
        assert self.duration is not None
        most = LARGEST_RECORD // row_bytes(self.arm.n)
        ticks = self.duration / self.period
        if ticks > most:
            raise InputError(
                "duration",
                f"{self.duration:g} s, {ticks:.3g} ticks of {self.period:g} s",
                f"at most {most:,} ticks ({LARGEST_RECORD / 2**30:g} GiB of record)",
            )

    def _checked_faults(self) -> tuple[Fault, ...]:
        faults = (self.faults,) if isinstance(self.faults, Fault) else tuple(self.faults)
        for place, fault in enumerate(faults):
            if not isinstance(fault, Fault):
                raise InputError("faults", f"{_door.describe(fault)} at place {place}", "a list of Fault")
            self.arm.joint_index(fault.joint)
        return faults

    def _checked_allow(self) -> bool:
        if not isinstance(self.allow_outside, bool):
            raise InputError("allow_outside", _door.describe(self.allow_outside), "True or False")
        return self.allow_outside

    def _checked_integrator(self) -> str:
        integrator = _door.choice("integrator", self.integrator, INTEGRATORS)
        if self.clock == "arm" and integrator != "euler":
            raise InputError("integrator", repr(integrator), "'euler' with clock='arm'")
        return integrator

    def _checked_duration(self) -> float:
        if self.duration is not None:
            return _door.positive("duration", self.duration)
        if self.clock == "arm":
            raise InputError(
                "duration", "None", "a time above 0: with clock='arm' the motion takes as long as the arm needs"
            )
        last = ends(checked_motion(self.motion))
        if len(last) == 0 or np.isinf(last[-1]):
            raise InputError("duration", "None", "a time above 0: this motion has no end of its own")
        return float(last[-1])


def _slack(ticks: float) -> float:
    """How far rounding may put a time, in ticks, from the tick that was meant."""
    return float(TICK_TOLERANCE + 4 * np.finfo(float).eps * ticks)
