"""Plants: what an arm makes of the rates that it is told, in a simulation."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from stillreach import _door
from stillreach._core import SimulatedPlant
from stillreach._door import FloatArray
from stillreach._forms import Flag, Integer, Number, Text
from stillreach._kinds import Kind, key
from stillreach._packages import file_at
from stillreach._reading import Reading
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm import Arm
    from stillreach.faults import FaultKind

__all__ = ["KinematicPlant", "MujocoPlant", "Plant"]


class Moving(Protocol):
    """An arm in motion, as a simulation reads and moves it from tick to tick."""

    @property
    def q(self) -> FloatArray:
        """(n,) true joint values [rad] or [m]."""

    def measure(self) -> FloatArray:
        """(n,) what the encoders say of them now."""

    def fail(self, joint: int, kind: FaultKind | None) -> None:
        """A joint (index) fails from now on, or is whole again (None), whether or not the controller knows."""

    def advance(self, rates: FloatArray) -> None:
        """A period goes by with these rates (n,) commanded [rad/s, m/s]."""


class Plant(Kind):
    """Base of the plants. One of your own is a frozen dataclass with ``word``, ``in_files = False`` and ``begin``."""

    def begin(self, arm: Arm, q: FloatArray, period: float) -> Moving:
        """The arm at rest at q (n,), to be commanded every period [s]."""
        raise TypeError(f"{type(self).__name__} is a base class; use one of the plants")


@dataclass(frozen=True, kw_only=True)
class KinematicPlant(Plant):
    """An arm without inertia. By default its joints have the rates that they are told and the positions it measures.

    Its joints have their true faults from the onset on, whether or not the controller knows of them.

    Args:
        lag: [s] time constant of the drives (first order); 0: none.
        dead_time: [s] until a rate arrives at the drives, in whole ticks (the nearest number); 0: none.
        resolution: [rad, m] of the encoders; 0: exact.
        noise: [rad, m] standard deviation of the encoders (normal, independent); 0: none.
        seed: of the noise.

    Raises:
        InputError: if an argument is invalid.
    """

    word = "kinematic"

    lag: float = field(default=0.0, metadata=key(Number("s", least=0.0), "Time constant of the drives"))
    dead_time: float = field(default=0.0, metadata=key(Number("s", least=0.0), "Time until a rate arrives"))
    resolution: float = field(default=0.0, metadata=key(Number("arm", least=0.0), "Resolution of the encoders"))
    noise: float = field(default=0.0, metadata=key(Number("arm", least=0.0), "Standard deviation of the encoders"))
    seed: int = field(default=0, metadata=key(Integer(0, 2**32 - 1), "Seed of the noise"))

    def __post_init__(self) -> None:
        self.check_numbers()

    @property
    def exact(self) -> bool:
        """Whether joints do what they are told and positions are measured exactly, faults aside."""
        return not (self.lag or self.dead_time or self.resolution or self.noise)

    def settings(self, period: float) -> dict[str, Any]:
        """What the core reads, for ticks of a period [s]."""
        follow = -math.expm1(-period / self.lag) if self.lag else 1.0
        return {"follow": follow, "dead": round(self.dead_time / period), "resolution": self.resolution}

    def errors(self, ticks: int, n: int) -> FloatArray | None:
        """(ticks, n) what the encoders are off at each tick of a run; None without noise."""
        if not self.noise:
            return None
        return np.random.default_rng(self.seed).normal(0.0, self.noise, (ticks, n))

    def simulated(self, n: int, period: float) -> SimulatedPlant:
        """Its state for n joints and ticks of a period [s]."""
        return SimulatedPlant(n, **self.settings(period))


@dataclass(frozen=True, kw_only=True)
class MujocoPlant(Plant):
    """An arm with inertia, driven by velocity servos, in MuJoCo (extra ``mujoco``).

    Without a model its links have 1 kg and 0.01 kg m² each. A locked joint is held by a constraint, the servo of a
    derated one has a lower command at most and that of a one-way one none against its way, a confined one stops at its
    ends, a runaway one is driven at its rate, and a free-swinging one has no servo.

    Args:
        model: MJCF or URDF file of the robot with its masses, with joints of the arm's names; its own actuators are
            replaced, and joints that the arm does not have are held. Empty: the arm itself.
        gain: [N s/m, N m s/rad] of the servos: force for each unit of speed that is missing.
        force: [N, N m] the largest of each servo; inf: no limit. A low one is a weak actuator.
        armature: [kg, kg m²] inertia of each drive.
        damping: [N s/m, N m s/rad] of each joint.
        friction: [N, N m] of each joint.
        gravity: whether there is any.
        delay: [s] until a rate arrives at the servos, in whole ticks.
        offset: [rad, m] that every encoder says too much.
        resolution: [rad, m] of the encoders; 0: exact.
        noise: [rad, m] standard deviation of the encoders.
        seed: of the noise.
        step: [s] of the physics, at most the period.

    Raises:
        InputError: if an argument is invalid.
    """

    word = "mujoco"

    model: str = field(default="", metadata=key(Text(), "MJCF or URDF file of the robot with its masses"))
    gain: float = field(default=400.0, metadata=key(Number(above=0.0), "Gain of the servos"))
    force: float = field(default=math.inf, metadata=key(Number(above=0.0, most=math.inf), "Largest force or torque"))
    armature: float = field(default=0.1, metadata=key(Number(above=0.0), "Inertia of each drive"))
    damping: float = field(default=1.0, metadata=key(Number(least=0.0), "Damping of each joint"))
    friction: float = field(default=0.0, metadata=key(Number(least=0.0), "Friction of each joint"))
    gravity: bool = field(default=False, metadata=key(Flag(), "Whether there is gravity"))
    delay: float = field(default=0.0, metadata=key(Number("s", least=0.0), "Time until a rate arrives"))
    offset: float = field(default=0.0, metadata=key(Number("arm"), "What the encoders say too much"))
    resolution: float = field(default=0.0, metadata=key(Number("arm", least=0.0), "Resolution of the encoders"))
    noise: float = field(default=0.0, metadata=key(Number("arm", least=0.0), "Standard deviation of the encoders"))
    seed: int = field(default=0, metadata=key(Integer(0, 2**32 - 1), "Seed of the noise"))
    step: float = field(default=0.002, metadata=key(Number("s", above=0.0), "Step of the physics"))

    def __post_init__(self) -> None:
        _door.text("model", self.model)
        self.check_numbers()
        if not isinstance(self.gravity, bool):
            raise InputError("gravity", _door.describe(self.gravity), "True or False")

    @classmethod
    def read(cls, values: dict[str, Any], reading: Reading) -> MujocoPlant:
        """From a file, where the model is relative to it."""
        if values.get("model"):
            values["model"] = str(file_at(values["model"], reading.folder))
        return super().read(values, reading)

    def begin(self, arm: Arm, q: FloatArray, period: float) -> Moving:
        """The arm in MuJoCo.

        Raises:
            InputError: if the model has no joint of a name of the arm's, or cannot be read.
            MissingExtraError: if MuJoCo is not installed.
        """
        from stillreach.physics import MujocoArm

        return MujocoArm(self, arm, q, period)


PLANTS: tuple[type[Plant], ...] = (KinematicPlant, MujocoPlant)
"""Every plant."""
