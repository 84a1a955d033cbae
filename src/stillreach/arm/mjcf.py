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
from stillreach._rotations import from_quaternions
from stillreach.arm.chain import Chain, ChainBuilder, Move
from stillreach.arm.mimic import Mimic, Positions
from stillreach.arm.placements import inverse, moved, translation, turned
from stillreach.arm.robot_file import RobotFile, listing, read
from stillreach.arm.robot_xml import parse
from stillreach.errors import MissingExtraError, RobotFileError

NOT_KINEMATICS = (
    *("actuators", "sensors", "tendons", "skins", "flexes", "pairs", "excludes", "keys", "tuples", "numerics", "texts"),
    *("cameras", "lights", "geoms", "meshes", "hfields", "materials", "textures", "plugins"),
)
"""Parts of a model, in an order in which none refers to one that is gone already, once sites have no material."""


def mjcf_chain(source: Any, tip: Any, base: Any, fixed: Mapping[str, float] | None) -> Chain:
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
    bodies = _Bodies(mujoco, file, model)
    start = 0 if base is None else bodies.body("base", base)
    end, last = bodies.end(tip, start)
    way = bodies.way(start, end)
    joints = [joint for body, backwards in way for joint in bodies.joints(body, backwards)]
    builder = ChainBuilder(file, passed=len(joints))
    positions = Positions(file, [bodies.joint_name(joint) for joint in joints], bodies.mimic_of, fixed)
    for body, backwards in way:
        bodies.pass_through(builder, positions, body, backwards)
    builder.fix(last)
    return builder.chain(bodies.title or file.stem)


def _parsed(mujoco: Any, file: RobotFile) -> Any:
    """The MjSpec of a file, after a first look at its XML."""
    root = parse(file, max_attribute=len(file.data))
    if root.tag != "mujoco":
        advice = " (Arm.from_urdf reads URDF files)" if root.tag == "robot" else ""
        raise file.error(f"<{root.tag[:80]}>", f"<mujoco>, the root of an MJCF file{advice}", line=root.line)
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
        self.by_name = {self.joint_name(joint): joint for joint in reversed(range(model.njnt))}
        self.couplings = {}
        for i in range(model.neq):
            if model.eq_type[i] == mujoco.mjtEq.mjEQ_JOINT and model.eq_active0[i]:
                self.couplings[int(model.eq_obj1id[i])] = (int(model.eq_obj2id[i]), model.eq_data[i, :5])

    def body(self, argument: str, name: Any) -> int:
        """Index of a body."""
        if isinstance(name, str) and name in self.names:
            return self.names.index(name)
        raise self.file.unknown(name, "a body", [n for n in self.names if n], argument=argument)

    def end(self, tip: Any, start: int) -> tuple[int, FloatArray]:
        """The body that carries the tip, and the tip's frame (4, 4) seen from that body."""
        if tip is None:
            leaves = [
                name for i, name in enumerate(self.names) if i not in set(self.model.body_parentid) and i != start
            ]
            if len(leaves) != 1:
                expected = (
                    f"the name of a body or site, because the tree has {len(leaves)} ends: {listing(tuple(leaves))}"
                )
                raise RobotFileError("tip", "None", expected, self.file.name, choices=tuple(leaves))
            tip = leaves[0]
        if isinstance(tip, str) and tip in self.names:
            return self.names.index(tip), np.eye(4)
        if isinstance(tip, str) and tip in self.sites:
            site = self.sites.index(tip)
            return int(self.model.site_bodyid[site]), _pose(self.model.site_pos[site], self.model.site_quat[site])
        choices = [name for name in (*self.names, *self.sites) if name]
        raise self.file.unknown(tip, "a body or a site", choices, argument="tip")

    def way(self, start: int, end: int) -> list[tuple[int, bool]]:
        """The bodies whose joints are passed from start to end, each with whether it is left towards its parent."""
        up, down = self._to_world(start), self._to_world(end)
        while up and down and up[-1] == down[-1]:
            up.pop()
            down.pop()
        return [(body, True) for body in up] + [(body, False) for body in reversed(down)]

    def _to_world(self, body: int) -> list[int]:
        way = []
        while body:
            way.append(body)
            body = int(self.model.body_parentid[body])
        return way

    def joints(self, body: int, backwards: bool) -> range:
        """Indices of a body's joints.

        Raises:
            RobotFileError: one of them is neither hinge nor slide.
        """
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        for joint in range(first, first + count):
            if int(self.model.jnt_type[joint]) not in self.kinds:
                raise self._unfit(joint, body, backwards)
        return range(first, first + count)

    def _unfit(self, joint: int, body: int, backwards: bool) -> RobotFileError:
        """The error of a joint that no chain can pass, with the chain beside it."""
        name, word = self.names[body], ("free", "ball")[int(self.model.jnt_type[joint])]
        got = f"a {word} joint between base and tip, in body {name!r}"
        argument, verb = ("tip", "ends before") if backwards else ("base", "begins after")
        advice = f"; {argument}={name!r} {verb} it" if name else ""
        expected = f"a chain of hinges and slides{advice}"
        element, choices = f"joint {self.joint_name(joint)!r}", (name,) if name else ()
        return self.file.error(got, expected, element=element, argument=argument, choices=choices)

    def joint_name(self, joint: int) -> str:
        """Its name, or its body's and its place there."""
        body = int(self.model.jnt_bodyid[joint])
        place = joint - int(self.model.body_jntadr[body]) + 1
        return self.model.joint(joint).name or f"{self.names[body] or f'body {body}'} joint {place}"

    def mimic_of(self, name: str) -> Mimic | None:
        """Whom a joint follows, by an equality constraint between joints."""
        joint = self.by_name[name]
        if joint not in self.couplings:
            return None
        leader, data = self.couplings[joint]
        offset = self._reference(joint) + float(data[0])
        if leader < 0:
            return Mimic(None, 0.0, offset)
        if np.any(data[2:]):
            got = f"a joint that follows {self.joint_name(leader)!r} by a polynomial of degree above 1"
            raise self.file.error(got, "a linear coupling, or the joint held by `fixed`", element=f"joint {name!r}")
        return Mimic(self.joint_name(leader), float(data[1]), offset - float(data[1]) * self._reference(leader))

    def _reference(self, joint: int) -> float:
        return float(self.model.qpos0[self.model.jnt_qposadr[joint]])

    def pass_through(self, builder: ChainBuilder, positions: Positions, body: int, backwards: bool) -> None:
        """Add a body's frame and joints to the chain, in either direction."""
        frame = _pose(self.model.body_pos[body], self.model.body_quat[body])
        if not backwards:
            builder.fix(frame)
        joints = self.joints(body, backwards)
        for joint in reversed(joints) if backwards else joints:
            kind = self.kinds[int(self.model.jnt_type[joint])]
            axis = self.model.jnt_axis[joint].copy()
            anchor = translation(*self.model.jnt_pos[joint])
            limited = bool(self.model.jnt_limited[joint])
            lower, upper = self.model.jnt_range[joint].tolist() if limited else (-math.inf, math.inf)
            builder.fix(anchor @ moved(kind, -axis if backwards else axis, -self._reference(joint)))
            move = Move(self.joint_name(joint), kind, axis, (lower, upper))
            builder.go(positions.of(move.name), move, backwards=backwards)
            builder.fix(inverse(anchor))
        if backwards:
            builder.fix(inverse(frame))


def _pose(position: FloatArray, quaternion: FloatArray) -> FloatArray:
    """(4, 4) from a position (3,) [m] and a unit quaternion (4,), scalar first."""
    return translation(*position) @ turned(from_quaternions("quat", quaternion))
