"""Arms from MJCF files: MuJoCo reads and compiles the file, the chain is taken from its model.

What is not kinematics is thrown away before compiling: meshes need not be there, and loading takes milliseconds.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach._formats import advice
from stillreach._rotations import from_quaternions
from stillreach.arm.chain import Chain, Step, along, assembled, check_length, way
from stillreach.arm.joint import Joint
from stillreach.arm.led import Led
from stillreach.arm.placements import inverse, moved, translation, turned
from stillreach.arm.robot_file import RobotFile, read
from stillreach.arm.robot_xml import parse
from stillreach.errors import MissingExtraError, RobotFileError

NOT_KINEMATICS = (
    *("actuators", "sensors", "tendons", "skins", "flexes", "pairs", "excludes", "keys", "tuples", "numerics", "texts"),
    *("cameras", "lights", "geoms", "meshes", "hfields", "materials", "textures", "plugins"),
)
"""Parts of a model, in an order in which none refers to one that is gone already, once sites have no material."""


def chain(source: Any, tip: Any, base: Any, fixed: Mapping[str, float] | None) -> Chain:
    """The chain between two bodies; ``Arm.from_mjcf`` says what the arguments are."""
    try:
        import mujoco
    except ImportError as error:
        raise MissingExtraError("mujoco", "Arm.from_mjcf()") from error

    if isinstance(source, mujoco.MjModel):
        file, model = RobotFile("<MjModel>", "arm", b""), source
    elif isinstance(source, mujoco.MjSpec):
        file = RobotFile("<MjSpec>", "arm", b"")
        model = _compile(mujoco, file, source.copy)
    else:
        file = read(source, "an MJCF file", also=", a mujoco.MjSpec, a mujoco.MjModel")
        model = _compile(mujoco, file, lambda: _parsed(mujoco, file))
    return _Bodies(mujoco, file, model).chain(tip, base, fixed)


def _parsed(mujoco: Any, file: RobotFile) -> Any:
    """The MjSpec of a file, after a first look at its XML."""
    root = parse(file, max_attribute=len(file.data))
    if root.tag != "mujoco":
        raise file.error(root.label, f"<mujoco>, the root of an MJCF file{advice(root.tag)}", line=root.line)
    if file.path is None:
        return mujoco.MjSpec.from_string(file.data.decode(file.encoding or "utf-8"))
    beside = file.path.with_name(f"{file.path.name}.xml")  # MuJoCo reads files of other names and encodings under one
    return mujoco.MjSpec.from_file(str(beside), include={beside.name: file.data})


def _compile(mujoco: Any, file: RobotFile, get_spec: Callable[[], Any]) -> Any:
    """The model of a spec, stripped of all but bodies, joints, sites and couplings of joints.

    Static bodies are not fused: MuJoCo would take those away that only a stripped part refers to.
    """
    try:
        spec = get_spec()
        for site in spec.sites:
            site.material = ""
        for part in NOT_KINEMATICS:
            for item in list(getattr(spec, part, ())):
                spec.delete(item)
        for item in list(spec.equalities):
            if item.type != mujoco.mjtEq.mjEQ_JOINT:
                spec.delete(item)
        for body in spec.bodies[1:]:  # without geoms they have no mass
            body.explicitinertial, body.mass, body.inertia, body.fullinertia = True, 1.0, np.ones(3), np.full(6, np.nan)
            body.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
        spec.compiler.fusestatic = False
        return spec.compile()
    except RobotFileError:
        raise
    except (ValueError, mujoco.FatalError) as error:
        text = " ".join(str(error).split())[:300]
        line = re.search(r"line (\d+)", text)
        raise file.error(f"what MuJoCo refuses ({text})", "an MJCF file", line=int(line[1]) if line else None) from None


class _Bodies:
    """The tree of a MuJoCo model."""

    def __init__(self, mujoco: Any, file: RobotFile, model: Any) -> None:
        self.file, self.model = file, model
        self.kinds = {int(mujoco.mjtJoint.mjJNT_HINGE): "revolute", int(mujoco.mjtJoint.mjJNT_SLIDE): "prismatic"}
        self.names = [model.body(i).name for i in range(model.nbody)]
        self.sites = [model.site(i).name for i in range(model.nsite)]
        self.title = model.names[: model.names.index(b"\0")].decode("utf-8", "replace").strip()
        self.by_name = {self._joint_name(joint): joint for joint in reversed(range(model.njnt))}
        self.couplings = {}
        for i in range(model.neq):
            if model.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT and model.eq_active0[i]:
                self.couplings[int(model.eq_obj1id[i])] = (int(model.eq_obj2id[i]), model.eq_data[i, :5])

    def chain(self, tip: Any, base: Any, fixed: Any) -> Chain:
        start = 0 if base is None else self.names.index(self.file.chosen("base", base, "a body", self.names))
        end, last = self._end(tip, start)
        passed = way(start, end, lambda body: int(self.model.body_parentid[body]) if body else None)
        check_length(self.file, int(sum(self.model.body_jntnum[body] for body, _ in passed)))
        steps = [*along(passed, self._steps), last]
        return assembled(self.file, self.title or self.file.stem, steps, self._mimic_of, fixed)

    def _end(self, tip: Any, start: int) -> tuple[int, FloatArray]:
        """The body that carries the tip, and the tip's frame (4, 4) seen from that body."""
        if tip is None:
            parents = {start, *self.model.body_parentid.tolist()}
            leaves = tuple(name for i, name in enumerate(self.names) if i not in parents)
            tip = self.file.only(leaves, "the name of a body or site")
        if self.file.chosen("tip", tip, "a body or a site", [*self.names, *self.sites]) in self.names:
            return self.names.index(tip), np.eye(4)
        site = self.sites.index(tip)
        return int(self.model.site_bodyid[site]), _pose(self.model.site_pos[site], self.model.site_quat[site])

    def _steps(self, body: int, up: bool) -> list[Step]:
        """The steps from a body's parent to the body.

        Raises:
            RobotFileError: if one of its joints is neither hinge nor slide.
        """
        steps: list[Step] = [_pose(self.model.body_pos[body], self.model.body_quat[body])]
        first = int(self.model.body_jntadr[body])
        for joint in range(first, first + int(self.model.body_jntnum[body])):
            kind = self.kinds.get(int(self.model.jnt_type[joint]))
            if kind is None:
                raise self._unfit(joint, body, up)
            axis, anchor = self.model.jnt_axis[joint].copy(), translation(*self.model.jnt_pos[joint])
            limits = self.model.jnt_range[joint] if self.model.jnt_limited[joint] else (-math.inf, math.inf)
            moving = Joint(name=self._joint_name(joint), kind=kind, axis=axis, position_limits=limits)
            steps += [anchor @ moved(kind, axis, -self._reference(joint)), moving, inverse(anchor)]
        return steps

    def _unfit(self, joint: int, body: int, up: bool) -> RobotFileError:
        """The error of a joint that no chain can pass, with the chain beside it."""
        name, word = self.names[body], ("free", "ball")[int(self.model.jnt_type[joint])]
        argument, verb = ("tip", "ends before") if up else ("base", "begins after")
        return self.file.error(
            f"a {word} joint between base and tip, in body {name!r}",
            f"a chain of hinges and slides{f'; {argument}={name!r} {verb} it' if name else ''}",
            element=f"joint {self._joint_name(joint)!r}",
            argument=argument,
            choices=(name,) if name else (),
        )

    def _joint_name(self, joint: int) -> str:
        """Its name, or its body's and its place there."""
        body = int(self.model.jnt_bodyid[joint])
        place = joint - int(self.model.body_jntadr[body]) + 1
        return self.model.joint(joint).name or f"{self.names[body] or f'body {body}'} joint {place}"

    def _mimic_of(self, name: str) -> Led | None:
        """Whom a joint follows, by an equality constraint between joints."""
        joint = self.by_name[name]
        if joint not in self.couplings:
            return None
        leader, data = self.couplings[joint]
        offset = self._reference(joint) + float(data[0])
        if leader < 0:
            return Led(None, 0.0, offset)
        if np.any(data[2:]):
            got = f"a joint that follows {self._joint_name(leader)!r} by a polynomial of degree above 1"
            raise self.file.error(got, "a linear coupling, or the joint held by `fixed`", element=f"joint {name!r}")
        return Led(self._joint_name(leader), float(data[1]), offset - float(data[1]) * self._reference(leader))

    def _reference(self, joint: int) -> float:
        return float(self.model.qpos0[self.model.jnt_qposadr[joint]])


def _pose(position: FloatArray, quaternion: FloatArray) -> FloatArray:
    """(4, 4) from a position (3,) [m] and a quaternion (4,), scalar first."""
    return translation(*position) @ turned(from_quaternions("quat", quaternion))
