"""Scenario: arm, start, motion and faults of a simulation."""

from __future__ import annotations

import inspect
import os
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import TYPE_CHECKING

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
from stillreach.plants import KinematicPlant, Plant
from stillreach.simulation.motion import TICK_TOLERANCE, Motion, checked_motion, ends
from stillreach.simulation.plausible import goals_beyond_reach, start_outside
from stillreach.simulation.record import row_bytes
from stillreach.simulation.schedule import Schedule, schedule_of
from stillreach.task import Task

if TYPE_CHECKING:
    from stillreach.page import Page

INTEGRATORS = ("euler", "rk4")
LOOPS = ("open", "closed")
CLOCKS = ("time", "arm")
LARGEST_RECORD = 2**33
"""[bytes] of a run: a duration or period that is wrong by orders of magnitude is rejected before the start."""
CONTROLLER_SETTINGS = tuple(inspect.signature(Controller).parameters)[1:]
"""Arguments passed unchanged to the controller: all but the arm."""


@dataclass(frozen=True, eq=False)
class Scenario:
    """The input of ``simulate``. Immutable; ``dataclasses.replace`` makes variants.

    Attributes hold checked values: parts of the motion and faults as tuples, limits as arrays for each joint.

    Args:
        arm: the arm.
        start: (n,) joint values at time 0 [rad] or [m], or a mapping or pandas Series by joint name.
        motion: one part or a list of them, one after the other: ConstantTwist, Line, Circle, Waypoints or PoseTable;
            the last may be a function of time or a ConstantTwist without a duration. After the last part the commanded
            twist is zero.
        plant: what the arm makes of the rates that it is told; None: KinematicPlant(), which does as it is told.
        faults: the faults. A fault begins and ends at the first tick at or after its time. Of two on one joint, the
            later one holds.
        law: the law; None: LeastError().
        task: the task; None: the full pose.
        period: time between ticks [s].
        duration: [s]; the last tick is at or before it. None: that of the motion.
        integrator: ``"euler"`` (the rates of a tick are held until the next one, as by a robot's drives) or ``"rk4"``
            (classical fourth-order Runge-Kutta: the law also runs at half steps).
        velocity_limits: (n,) or one for all [rad/s] or [m/s], inf for no limit; None: the arm's own.
        position_limits: (n, 2) or one pair for all [rad] or [m]; None: the arm's own.
        acceleration_limits: (n,) or one for all [rad/s²] or [m/s²], inf for no limit; None: the arm's own.
        null_motion: use of the freedom that the task leaves, as for Controller; None: none.
        loop: ``"open"`` (the commanded twist alone) or ``"closed"`` (feedback on the commanded pose, as
            ``Controller.track``, with the command as feedforward).
        clock: ``"time"``, or ``"arm"``: the motion waits for the arm. Each tick advances its time by ``scale``
            times the period, so that under KeepDirection the tool slows down and does not fall behind. Requires Euler
            steps and a duration, within which the motion may or may not end.
        track_gain: [1/s] of that feedback.
        track_limits: largest correction (linear [m/s], angular [rad/s]), as for Controller; inf: no bound.
        return_rate: [rad/s, m/s] at which joints outside their position limits return, as for Controller.
        transition_rate: [1/s] at which the null motion fades in after a fault, as for Controller; 0: at once.
        allow_outside: whether the start may be outside the position limits, and courses may exceed the arm's reach. The
            usual cause of both is degrees or millimetres instead of radians and metres.
        name: its name in plots and files.
        description: for readers; `stillreach run` prints its first paragraph.

    Raises:
        InputError: if an argument is invalid.
        UnknownJointError: if a fault names an unknown joint.
    """

    _: KW_ONLY
    arm: Arm
    start: FloatArray
    motion: Sequence[Motion] | Motion
    faults: Sequence[Fault] = ()
    plant: Plant | None = None
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
            "plant": KinematicPlant() if self.plant is None else self.plant,
            "period": _door.positive("period", self.period),
            "clock": _door.choice("clock", self.clock, CLOCKS),
            "duration": self._checked_duration(),
            "integrator": self._checked_integrator(),
            "loop": _door.choice("loop", self.loop, LOOPS),
            "track_gain": _door.positive("track_gain", self.track_gain, or_zero=True),
            "allow_outside": self._checked_allow(),
        }
        if not isinstance(checked["plant"], Plant):
            raise InputError("plant", _door.describe(self.plant), "a plant, such as stillreach.plants.KinematicPlant()")
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        self._refuse_too_long()
        # invalid arguments raise here, not in the middle of a simulation
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
            ScenarioFileError: if the file is missing or invalid; ``mistakes`` lists all mistakes.
        """
        from stillreach.simulation.scenario_file import load

        return load(path)

    def controller(self) -> Controller:
        """A new controller with the scenario's settings, without faults.

        Raises:
            InputError: if a setting is invalid.
        """
        settings = {name: getattr(self, name) for name in CONTROLLER_SETTINGS}
        return Controller(self.arm, **settings)

    def page(self) -> Page:
        """A page that plays this scenario in a browser, and in which a click breaks a joint.

        Raises:
            PageNotBuiltError: if this installation has no program for it.
        """
        from stillreach.page import scenario_page

        return scenario_page(self)

    @cached_property
    def schedule(self) -> Schedule:
        """The plan in ticks: parts of the motion, and changes of faults."""
        return schedule_of(self)

    @property
    def title(self) -> str:
        """The name, or else arm and law."""
        return self.name or f"{self.arm.name} under {type(self.law).__name__}"

    def task_pose(self, q: FloatArray) -> FloatArray:
        """Pose of the task's point at joint values (n,), (4, 4) [m]."""
        T = self.arm.forward(q)
        return T if self.task is None or self.task.tool is None else T @ self.task.tool

    @property
    def steps(self) -> int:
        """Number of steps; a run has one tick more."""
        assert self.duration is not None
        ticks = self.duration / self.period
        return int(np.floor(ticks + _slack(ticks)))

    def tick_at(self, time: float) -> int:
        """The first tick at or after a time [s]; infinite times are after all ticks."""
        with np.errstate(over="ignore"):
            ticks = float(np.divide(time, self.period))
        if np.isinf(ticks):
            return self.steps + 1
        return max(0, int(np.ceil(ticks - _slack(ticks))))

    def _keep_checked(self, controller: Controller) -> None:
        """Limits and null motion as checked by a controller, as read-only copies."""
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
        given = [self.faults] if isinstance(self.faults, Fault) else self.faults
        faults = _door.members("faults", given, Fault, "a list of Fault", least=0)
        for fault in faults:
            self.arm.joint_index(fault.joint)
        return tuple(faults)

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
                "duration", "None", "a time above 0: with clock='arm' the arm determines how long the motion takes"
            )
        last = ends(checked_motion(self.motion))
        if len(last) == 0 or np.isinf(last[-1]):
            raise InputError("duration", "None", "a time above 0: this motion has no end")
        return float(last[-1])


def _slack(ticks: float) -> float:
    """Largest rounding error of a time, in ticks."""
    return float(TICK_TOLERANCE + 4 * np.finfo(float).eps * ticks)
