"""Robots by name are those of files that nobody here wrote: poses, Jacobians, limits.

The files write right angles to about five digits (1.5708). Ours are whole hundredths of a degree: the files' angles are
rounded to these before Pinocchio reads them, and limits to tenths of a degree where the maker states degrees.
"""

import re
from dataclasses import dataclass
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

import stillreach as sr
from tests.robots.catalogue import BULLET, EXAMPLES, SUITE, TOOLBOX, Robot
from tests.unit.arm import file_peer, mjcf_peer

CLOSE = 1e-6
IN_DEGREES = ("iiwa7", "iiwa14", "jaco2", "rizon4")
"""Arms whose limits the maker states in degrees."""


@dataclass(frozen=True)
class Source:
    """A file that holds one of our arms.

    Attributes:
        arm: its name here.
        package, path: where the file is.
        base: link that our arm stands on.
        tips: {our tip: the file's}.
        joint: name of a joint in the file, ``{}`` for its number; None: as ours.
        beyond: shift along z [m] and turn about z [rad] to our tip, seen from the file's.
        limits: kinds of limits in which the file agrees with the maker.
    """

    arm: str
    package: tuple[str, str]
    path: str
    base: str
    tips: dict[str, str]
    joint: str | None = None
    beyond: tuple[float, float] = (0.0, 0.0)
    limits: tuple[str, ...] = ("position", "velocity")

    @property
    def file(self):
        return Robot(self.package, self.path, 0, "").file

    def names(self, arm):
        """The file's names of our joints."""
        return list(arm.joint_names) if self.joint is None else [self.joint.format(k + 1) for k in range(arm.n)]

    def joints(self):
        """The joint elements of a URDF file or xacro macro, angles rounded."""
        text = self.file.read_text(encoding="utf-8").replace("${prefix}", "")
        joints = [joint for joint in ElementTree.fromstring(text).iter("joint") if joint.find("parent") is not None]
        for origin in (joint.find("origin") for joint in joints):
            if origin is not None and origin.get("rpy"):
                degrees = np.round(np.degrees(np.array(origin.get("rpy").split(), float)), 2)
                origin.set("rpy", " ".join(repr(float(angle)) for angle in np.radians(degrees)))
        return joints

    def peer(self):
        """Pinocchio or MuJoCo with the file."""
        if self.path.endswith("robot.xml"):
            return mjcf_peer.Peer(self.file)
        joints, tags = self.joints(), ("parent", "child", "origin", "axis", "limit")
        links = dict.fromkeys(joint.find(end).get("link") for joint in joints for end in ("parent", "child"))
        body = [f"<link name={link!r}/>" for link in links]
        for joint in joints:
            inside = "".join(ElementTree.tostring(part, encoding="unicode") for part in joint if part.tag in tags)
            body.append(f"<joint name={joint.get('name')!r} type={joint.get('type')!r}>{inside}</joint>")
        return file_peer.Peer(f"<robot name='r'>{''.join(body)}</robot>")

    def limit(self, name):
        """Lower, upper, velocity of a joint in the file."""
        if self.path.endswith("robot.xml"):
            return *mujoco.MjModel.from_xml_path(str(self.file)).joint(name).range, np.nan
        (limit,) = (joint.find("limit") for joint in self.joints() if joint.get("name") == name)
        return tuple(float(limit.get(key, "nan")) for key in ("lower", "upper", "velocity"))


def same(*links):
    return {link: link for link in links}


BAXTER = "baxter_description/urdf/baxter.urdf"
FETCH = "fetch_description/robots/fetch.urdf"
GEN3 = "kortex_description/arms/gen3/7dof/urdf/gen3_macro.xacro"
IIWA14 = "kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf"
PANDA = "panda_description/urdf/panda.urdf"
SAWYER = "../bullet_data/sawyer_description/urdf/sawyer_arm.urdf"
TALOS = "talos_data/robots/talos_reduced.urdf"
TIAGO = "tiago_description/robots/tiago.urdf"
XARM7 = "xarm_description/urdf/xarm7.urdf"
HANDS = {"fr3_link8": "panda_link8", "fr3_hand_tcp": "panda_hand_tcp"}
SOURCES = {
    "baxter": Source("baxter", EXAMPLES, BAXTER, "torso", same("left_gripper", "left_hand_link")),
    "fetch": Source("fetch", TOOLBOX, FETCH, "base_link", same("gripper_link", "wrist_roll_link")),
    "fr3": Source("fr3", EXAMPLES, PANDA, "panda_link0", HANDS, "panda_joint{}", limits=()),
    "gen3": Source("gen3", TOOLBOX, GEN3, "base_link", same("end_effector_link")),
    "iiwa7": Source("iiwa7", SUITE, "iiwa/robot.xml", "base", {"flange": "right_hand"}, None, (0.001, np.pi)),
    "iiwa14": Source(
        "iiwa14",
        BULLET,
        "kuka_iiwa/model.urdf",
        "lbr_iiwa_link_0",
        {"flange": "lbr_iiwa_link_7"},
        "lbr_iiwa_joint_{}",
        (0.045, 0.0),
        ("position",),
    ),
    "iiwa14, rates": Source("iiwa14", TOOLBOX, IIWA14, "base_link", {}, "joint_a{}"),
    "jaco2": Source(
        "jaco2", SUITE, "jaco/robot.xml", "base", {"j2s7s300_end_effector": "right_hand"}, None, (0.16, -np.pi / 2)
    ),
    "panda": Source("panda", EXAMPLES, PANDA, "panda_link0", same("panda_link8", "panda_hand_tcp")),
    "sawyer": Source("sawyer", SUITE, SAWYER, "right_arm_base_link", same("right_l6")),
    "talos": Source("talos", EXAMPLES, TALOS, "base_link", same("gripper_left_base_link", "arm_left_7_link")),
    "tiago": Source("tiago", EXAMPLES, TIAGO, "base_link", same("arm_tool_link", "arm_7_link")),
    "xarm7": Source("xarm7", EXAMPLES, XARM7, "link_base", same("link_eef")),
}


@pytest.mark.parametrize(("name", "tip"), [(name, tip) for name, source in SOURCES.items() for tip in source.tips])
def test_an_arm_by_name_moves_as_in_its_file(name, tip):
    source = SOURCES[name]
    arm = sr.arms.by_name(source.arm, tip=tip)
    shift, turn = source.beyond
    last = sr.DHRow(d=shift, theta=turn)
    arm = arm.with_tool(arm.tool @ np.linalg.inv(sr.Arm.from_dh([last]).forward([0.0])))
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (50, arm.n))
    peer = source.peer()
    expected = [peer.chain(source.base, source.tips[tip], source.names(arm), row) for row in q]
    poses, jacobians = (np.array(part) for part in zip(*expected, strict=True))
    assert np.max(np.abs(arm.forward(q) - poses)) <= CLOSE
    assert np.max(np.abs(arm.jacobian(q) - jacobians)) <= CLOSE


@pytest.mark.parametrize("name", [name for name, source in SOURCES.items() if source.limits])
def test_an_arm_by_name_has_the_limits_of_its_file(name):
    source = SOURCES[name]
    arm = sr.arms.by_name(source.arm)
    file = np.array([source.limit(name) for name in source.names(arm)])
    ours = np.column_stack([arm.position_limits, arm.velocity_limits])
    if source.arm in IN_DEGREES:
        file, ours = np.round(np.degrees(file), 1), np.degrees(ours)
    known = (
        np.isfinite(file)
        & np.isfinite(ours)
        & np.repeat([k in source.limits for k in ("position", "velocity")], (2, 1))
    )
    np.testing.assert_allclose(ours[known], file[known], rtol=0, atol=CLOSE)
    assert np.count_nonzero(known) >= 6
    free = np.isinf(ours)  # a joint that turns without end has no range in URDF, and whole turns elsewhere
    assert np.all(np.isnan(file[free]) | (np.abs(file[free]) >= 2 * np.pi - 1e-5))


def test_the_jaco_has_the_rate_limits_of_its_maker():
    text = Robot(TOOLBOX, "kinova_description/urdf/j2s7s300.xacro", 7, "").file.read_text(encoding="utf-8")
    rates = re.findall(r'joint_\d_velocity_limit" value="\${(\d+)\*J_PI/180}"', text)
    np.testing.assert_allclose(np.degrees(sr.arms.jaco2().velocity_limits), np.array(rates, float))


def test_every_robot_by_name_is_compared_with_a_file():
    robots = {name for name in sr.arms.BUILDERS if hasattr(sr.arms.BUILDERS[name], "tips")}
    assert robots == {source.arm for source in SOURCES.values()} | {"canadarm2", "rizon4"}  # these are solved by hand
