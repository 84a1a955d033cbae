"""An arm with inertia in MuJoCo, for simulations. MuJoCo is an extra, imported only here, inside the functions."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach._door import FloatArray
from stillreach._messages import listed, short
from stillreach.errors import InputError, MissingExtraError
from stillreach.faults import Loses
from stillreach.status import Health

if TYPE_CHECKING:
    from stillreach.arm import Arm
    from stillreach.faults import FaultKind
    from stillreach.plants import MujocoPlant

HOLD = (0.004, 1.0)
"""solref of constraints that hold a joint: time constant [s] and damping ratio."""
HARD = (0.99, 0.9999, 0.001, 0.5, 2.0)
"""solimp of friction: it hardly creeps."""
FAR = 1e6
"""[rad, m] range of a joint that has none."""


class MujocoArm:
    """An arm in MuJoCo; a ``Moving`` of ``stillreach.plants``."""

    def __init__(self, plant: MujocoPlant, arm: Arm, q: FloatArray, period: float) -> None:
        try:
            import mujoco
        except ImportError as error:
            raise MissingExtraError("mujoco", "MujocoPlant") from error
        self._mujoco, self._plant, self._arm = mujoco, plant, arm
        spec = _spec(mujoco, plant, arm)
        self._model, self._steps = _compiled(mujoco, plant, spec, arm), max(1, round(period / plant.step))
        self._model.opt.timestep = period / self._steps
        self._data = mujoco.MjData(self._model)
        joints = [self._model.joint(name) for name in arm.joint_names]
        self._places = np.array([joint.qposadr[0] for joint in joints])
        self._ids = np.array([joint.id for joint in joints])
        self._holds = np.array([self._model.eq(f"stillreach hold {name}").id for name in arm.joint_names])
        self._servos = np.array([self._model.actuator(f"stillreach servo {name}").id for name in arm.joint_names])
        self._data.qpos[self._places] = q
        for follower in arm.followers:
            place = self._model.joint(str(follower.joint.name)).qposadr[0]
            self._data.qpos[place] = follower.multiplier * q[arm.joint_index(follower.leader)] + follower.offset
        mujoco.mj_forward(self._model, self._data)
        self._drives = self._model.actuator_gainprm.copy(), self._model.actuator_biasprm.copy()
        self._faults: dict[int, FaultKind] = {}
        self._limits = np.array(arm.velocity_limits)
        self._waiting = deque([np.zeros(arm.n)] * round(plant.delay / period))
        self._random = np.random.default_rng(plant.seed)

    @property
    def q(self) -> FloatArray:
        """(n,) true joint values [rad] or [m]."""
        return np.array(self._data.qpos[self._places])

    def measure(self) -> FloatArray:
        """(n,) what the encoders say."""
        plant, q = self._plant, self.q + self._plant.offset
        if plant.noise:
            q = q + self._random.normal(0.0, plant.noise, len(q))
        return plant.resolution * np.round(q / plant.resolution) if plant.resolution else q

    def fail(self, joint: int, kind: FaultKind | None) -> None:
        """A joint fails or is whole again."""
        model, data = self._model, self._data
        data.eq_active[self._holds[joint]] = False
        model.jnt_range[self._ids[joint]] = (-FAR, FAR)
        self._drive(joint, kind is None or kind.health != Health.FREE_SWINGING)
        self._faults.pop(joint, None)
        if kind is None:
            return
        self._faults[joint] = kind
        if kind.health == Health.LOCKED:
            self._hold(joint, float(data.qpos[self._places[joint]]))
        elif kind.loses is Loses.RANGE:
            ends = kind.positions(float(data.qpos[self._places[joint]]))
            model.jnt_range[self._ids[joint]] = np.clip(ends, -FAR, FAR)

    def _drive(self, joint: int, on: bool) -> None:
        """Switches the servo of a joint on or off."""
        servo = self._servos[joint]
        for parameters, own in zip(
            (self._model.actuator_gainprm, self._model.actuator_biasprm), self._drives, strict=True
        ):
            parameters[servo] = own[servo] if on else 0.0

    def _hold(self, joint: int, at: float) -> None:
        """Switches on the constraint that holds a joint at a position."""
        place = self._places[joint]
        self._model.eq_data[self._holds[joint], 0] = at - self._model.qpos0[place]
        self._data.eq_active[self._holds[joint]] = True

    def advance(self, rates: FloatArray) -> None:
        """A period goes by with these rates commanded."""
        self._waiting.append(np.array(rates))
        told = self._waiting.popleft()
        for joint, kind in self._faults.items():
            told[joint] = kind.driven(told[joint], self._limits[joint])
        self._data.ctrl[self._servos] = told
        self._mujoco.mj_step(self._model, self._data, self._steps)


def _named(plant: MujocoPlant, arm: Arm) -> str:
    return short(Path(plant.model).name if plant.model else arm.name)


def _spec(mujoco: Any, plant: MujocoPlant, arm: Arm) -> Any:
    """The model before it is compiled: the file's, or the arm's."""
    try:
        if not plant.model:
            return mujoco.MjSpec.from_string(arm.to_urdf())
        if not Path(plant.model).is_file():
            raise InputError("model", repr(plant.model), "an MJCF or URDF file that exists")
        return mujoco.MjSpec.from_file(plant.model)
    except (ValueError, mujoco.FatalError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            "model", f"{_named(plant, arm)}: {' '.join(str(error).split())}", "a model that MuJoCo reads"
        ) from None


def _compiled(mujoco: Any, plant: MujocoPlant, spec: Any, arm: Arm) -> Any:
    """The model with servos and brakes instead of its own actuators, and no joints but the arm's."""
    own = {joint.name: joint for joint in spec.joints}
    missing = [name for name in arm.joint_names if name not in own]
    if missing:
        raise InputError("model", f"no joint {listed(missing)}; it has {listed(own)}", "a joint for each of the arm's")
    for name in ("keys", "sensors", "actuators", "tendons", "equalities"):
        for element in list(getattr(spec, name)):
            spec.delete(element)
    followers = {str(follower.joint.name): follower for follower in arm.followers}
    for name, joint in own.items():
        if name not in arm.joint_names and name not in followers:
            spec.delete(joint)
    for name in (*arm.joint_names, *followers):
        joint = own[name]
        joint.limited, joint.range = mujoco.mjtLimited.mjLIMITED_TRUE, (-FAR, FAR)
        joint.armature, joint.frictionloss = plant.armature, plant.friction
        joint.solref_friction, joint.solimp_friction = HOLD, HARD
        joint.damping = plant.damping * (np.ndim(joint.damping) == 0 or np.eye(3, 1))  # a number, or a polynomial
    for name in arm.joint_names:
        servo = spec.add_actuator(name=f"stillreach servo {name}", trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        servo.set_to_velocity(plant.gain)
        if np.isfinite(plant.force):
            servo.forcelimited, servo.forcerange = mujoco.mjtLimited.mjLIMITED_TRUE, (-plant.force, plant.force)
        spec.add_equality(
            name=f"stillreach hold {name}", type=mujoco.mjtEq.mjEQ_JOINT, name1=name, active=False, solref=HOLD
        )
    for name, follower in followers.items():
        data = np.zeros(11)
        data[:2] = follower.offset, follower.multiplier
        spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=name, name2=follower.leader, data=data, solref=HOLD)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    if not plant.gravity:
        spec.option.gravity = (0.0, 0.0, 0.0)
    try:
        return spec.compile()
    except ValueError as error:
        raise InputError(
            "model", f"{_named(plant, arm)}: {' '.join(str(error).split())}", "a model that MuJoCo reads"
        ) from None
