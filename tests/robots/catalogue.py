"""Arms from robot files that nobody here wrote; one line joins one to every test here, and to the laws' tests."""

from dataclasses import dataclass, field
from importlib.metadata import distribution

import stillreach as sr

EXAMPLES = "example-robot-data", "cmeel.prefix/share/example-robot-data/robots"
TOOLBOX = "rtb-data", "rtbdata/xacro"
BULLET = "pybullet", "pybullet_data"
SUITE = "robosuite", "robosuite/models/assets/robots"


@dataclass(frozen=True)
class Robot:
    """A chain in a robot file.

    Attributes:
        package: the package that brings the file, and the folder in it.
        path: the file, from that folder on.
        n: number of joints that move.
        tip, base: as for `Arm.from_urdf` and `Arm.from_mjcf`.
        slides: how many of the joints are prismatic.
        held: {joint: position} of joints that are held.
        follows: {joint: (leader, multiplier, offset)} of joints that follow others.
    """

    package: tuple[str, str]
    path: str
    n: int
    tip: str
    base: str | None = None
    slides: int = 0
    held: dict[str, float] = field(default_factory=dict)
    follows: dict[str, tuple[str, float, float]] = field(default_factory=dict)

    @property
    def file(self):
        """Where the file is."""
        name, folder = self.package
        return distribution(name).locate_file(f"{folder}/{self.path}")

    def make(self):
        """The arm."""
        read = sr.Arm.from_mjcf if self.package is SUITE else sr.Arm.from_urdf
        return read(self.file, tip=self.tip, base=self.base, fixed=self.held)


URDF = {
    "Panda": Robot(EXAMPLES, "panda_description/urdf/panda.urdf", 7, "panda_hand_tcp"),
    "xArm7": Robot(EXAMPLES, "xarm_description/urdf/xarm7.urdf", 7, "link_eef"),
    "TALOS, left arm": Robot(
        EXAMPLES, "talos_data/robots/talos_reduced.urdf", 7, "gripper_left_base_link", "torso_2_link"
    ),
    "TALOS, torso and arm": Robot(EXAMPLES, "talos_data/robots/talos_reduced.urdf", 9, "gripper_left_base_link"),
    "Baxter": Robot(EXAMPLES, "baxter_description/urdf/baxter.urdf", 7, "left_gripper"),
    "Baxter, hand to hand": Robot(
        EXAMPLES, "baxter_description/urdf/baxter.urdf", 14, "right_gripper", base="left_gripper"
    ),
    "human, pelvis to hand": Robot(EXAMPLES, "human_description/robots/human.urdf", 13, "right_hand"),
    "TIAGo": Robot(EXAMPLES, "tiago_description/robots/tiago.urdf", 8, "arm_tool_link", slides=1),
    "PR2": Robot(EXAMPLES, "pr2_description/urdf/pr2.urdf", 8, "l_gripper_tool_frame", slides=1),
    "PR2, with a finger that follows another": Robot(
        EXAMPLES,
        "pr2_description/urdf/pr2.urdf",
        9,
        "l_gripper_l_finger_tip_link",
        slides=1,
        follows={"l_gripper_l_finger_tip_joint": ("l_gripper_l_finger_joint", 1.0, 0.0)},
    ),
    "iiwa 14": Robot(TOOLBOX, "kuka_description/kuka_lbr_iiwa/urdf/lbr_iiwa_14_r820.urdf", 7, "tool0"),
    "Kinova Gen3": Robot(TOOLBOX, "kortex_description/arms/gen3/7dof/urdf/GEN3_URDF_V12.urdf", 7, "EndEffector_Link"),
    "Valkyrie, waist to palm": Robot(TOOLBOX, "val_description/model/robots/valkyrie_A.urdf", 10, "rightPalm"),
    "Valkyrie, waist to thumb": Robot(
        TOOLBOX, "val_description/model/robots/valkyrie_A.urdf", 14, "rightThumbPitch3Link"
    ),
    "iiwa of PyBullet": Robot(BULLET, "kuka_iiwa/model.urdf", 7, "lbr_iiwa_link_7"),
    "TIAGo, torso held": Robot(
        EXAMPLES, "tiago_description/robots/tiago.urdf", 7, "arm_tool_link", held={"torso_lift_joint": 0.2}
    ),
}

MJCF = {
    "robosuite Panda": Robot(SUITE, "panda/robot.xml", 7, "right_hand"),
    "robosuite iiwa": Robot(SUITE, "iiwa/robot.xml", 7, "right_hand"),
    "robosuite Jaco": Robot(SUITE, "jaco/robot.xml", 7, "right_hand"),
    "robosuite Kinova Gen3": Robot(SUITE, "kinova3/robot.xml", 7, "right_hand"),
    "robosuite Sawyer": Robot(SUITE, "sawyer/robot.xml", 7, "right_hand"),
    "robosuite UR5e": Robot(SUITE, "ur5e/robot.xml", 6, "right_hand"),
    "robosuite xArm7": Robot(SUITE, "xarm7/robot.xml", 7, "right_hand"),
    "robosuite Spot's arm": Robot(SUITE, "spot_arm/robot.xml", 6, "right_hand"),
    "robosuite Baxter, hand to hand": Robot(SUITE, "baxter/robot.xml", 14, "right_hand", base="left_hand"),
    "robosuite TIAGo": Robot(SUITE, "tiago/robot.xml", 7, "left_hand", slides=1),
    "robosuite GR1, waist to hand": Robot(SUITE, "gr1/robot.xml", 10, "l_hand_pitch", base="base"),
}

ROBOTS = URDF | MJCF
