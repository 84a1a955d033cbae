"""Chains from URDF files, against Pinocchio and against arms solved by hand."""

import subprocess
import sys

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.file_peer import Peer
from tests.unit.arm.urdf_texts import joint, random_tree, robot

POSES = 20


def agree(arm, peer, base, tip, seed=0):
    """Pose and Jacobian are Pinocchio's at random configurations."""
    rng = np.random.default_rng(seed)
    for q in rng.uniform(-3.0, 3.0, (POSES, arm.n)):
        T, J = peer.chain(base, tip, arm.joint_names, q)
        assert np.max(np.abs(arm.forward(q) - T)) <= 1e-12
        assert np.max(np.abs(arm.jacobian(q) - J)) <= 1e-12


@pytest.mark.parametrize("seed", range(12))
def test_any_chain_of_a_random_tree_is_pinocchios(seed):
    text, rng, refused = random_tree(seed), np.random.default_rng([1, seed]), []
    peer = Peer(text)
    for base, tip in rng.integers(0, 13, (12, 2)):
        try:
            arm = sr.Arm.from_urdf(text, base=f"link{base}", tip=f"link{tip}")
        except sr.errors.RobotFileError as error:
            refused.append(str(error))
            continue
        agree(arm, peer, f"link{base}", f"link{tip}")
    assert all("no joint that moves" in text for text in refused)
    assert len(refused) < 6


def test_a_chain_up_one_branch_and_down_another_is_in_order_of_the_way():
    text = robot(
        joint("waist", "pelvis", "torso", xyz="0 0 0.5"),
        joint("left_hip", "pelvis", "left_leg", xyz="0 0.1 0", axis="0 1 0"),
        joint("left_knee", "left_leg", "left_foot", xyz="0 0 -0.4", axis="0 1 0"),
        joint("shoulder", "torso", "arm", "prismatic", xyz="0 0.2 0.3", axis="1 0 0"),
        joint("hand_mount", "arm", "hand", "fixed", xyz="0 0 0.2"),
    )
    arm = sr.Arm.from_urdf(text, base="left_foot", tip="hand")
    assert arm.joint_names == ("left_knee", "left_hip", "waist", "shoulder")
    assert arm.forward(np.zeros(4))[:3, 3] == pytest.approx([0.0, 0.1, 1.4])
    bent = arm.forward([0.3, 0.0, 0.0, 0.0])
    assert bent[:3, 3] == pytest.approx([-1.4 * np.sin(0.3), 0.1, 1.4 * np.cos(0.3)])
    agree(arm, Peer(text), "left_foot", "hand")


def test_all_that_is_read_of_a_joint():
    limit = 'lower="-0.5" upper="1.5" velocity="2.5" effort="1e30"'
    text = robot(
        joint("turn", "a", "b", limit=limit, axis="0 0 5"),
        joint("spin", "b", "c", "continuous", limit='velocity="7" effort="1"'),
        joint("slide", "c", "d", "prismatic", limit='lower="0" upper="1e12" velocity="1e9"'),
        joint("stiff", "d", "e", limit='velocity="1"'),
    )
    arm = sr.Arm.from_urdf(text)
    assert arm.name == "test robot"
    assert arm.joint_names == ("turn", "spin", "slide", "stiff")
    assert arm.kinds.tolist() == [0, 0, 1, 0]
    assert arm.position_limits.tolist() == [[-0.5, 1.5], [-np.inf, np.inf], [0.0, np.inf], [0.0, 0.0]]
    assert arm.velocity_limits.tolist() == [2.5, 7.0, np.inf, 1.0]
    assert arm.joints[0].axis.tolist() == [0.0, 0.0, 1.0]


def test_defaults_are_those_of_urdf():
    text = robot(
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>',
        '<joint name="k" type="fixed"><origin xyz="1 2 3"/><parent link="b"/><child link="c"/></joint>',
    )
    arm = sr.Arm.from_urdf(text)
    assert arm.joints[0].axis.tolist() == [1.0, 0.0, 0.0]
    assert arm.velocity_limits.tolist() == [np.inf]
    assert arm.tool[:3, 3].tolist() == [1.0, 2.0, 3.0]


def test_what_is_beside_the_chain_does_not_matter():
    text = robot(
        joint("j", "a", "b"),
        joint("float", "b", "c", "floating"),
        joint("odd", "b", "d", "spherical", axis="0 0 0", xyz="nan"),
        '<gazebo><plugin xmlns:g="x"><g:joint name="j"/></plugin></gazebo>',
        '<transmission name="t"><joint name="j"/></transmission>',
    ).replace('<link name="a"/>', '<link name="a"><visual><mesh filename="package://gone.dae"/></visual></link>')
    assert sr.Arm.from_urdf(text, tip="b").joint_names == ("j",)


def test_the_only_leaf_is_the_tip_and_a_base_narrows_the_choice():
    text = robot(joint("j", "a", "b"), joint("k", "b", "c"), joint("l", "a", "d"))
    with pytest.raises(sr.errors.RobotFileError, match=r"tip: got None, .* 2 ends: c, d") as caught:
        sr.Arm.from_urdf(text)
    assert caught.value.choices == ("c", "d")
    assert sr.Arm.from_urdf(text, base="b").joint_names == ("k",)


def test_fixed_joints_stay_where_they_are_told():
    text = robot(
        joint("j", "a", "b", xyz="1 0 0"), joint("k", "b", "c", xyz="0 1 0"), joint("l", "c", "d", xyz="0 0 1")
    )
    whole, held = sr.Arm.from_urdf(text), sr.Arm.from_urdf(text, fixed={"k": 0.7})
    assert held.joint_names == ("j", "l")
    for q in np.random.default_rng(3).uniform(-2, 2, (POSES, 2)):
        assert held.forward(q) == pytest.approx(whole.forward([q[0], 0.7, q[1]]), abs=1e-15)


def test_a_joint_that_follows_one_outside_the_chain_stands_as_if_that_were_at_zero_or_where_it_is_held():
    follow = '<mimic joint="far" multiplier="2" offset="0.25"/>'
    again = '<mimic joint="k" multiplier="-1" offset="0.5"/>'
    text = robot(
        joint("far", "a", "elsewhere"),
        joint("j", "a", "b", xyz="1 0 0"),
        joint("k", "b", "c", xyz="0 1 0", axis="0 1 0", extra=follow),
        joint("l", "c", "d", "prismatic", extra=again),
    )
    follows = {"k": ("far", 2.0, 0.25), "l": ("far", -2.0, 0.25)}
    at_zero = sr.Arm.from_urdf(text, tip="d")
    assert at_zero.joint_names == ("j",)
    agree(at_zero, Peer(text, follows), "a", "d")
    held = {"far": 0.6}
    agree(sr.Arm.from_urdf(text, tip="d", fixed=held), Peer(text, follows, held), "a", "d")
    held = {"far": 0.6, "k": -0.1, "l": 0.2}
    agree(sr.Arm.from_urdf(text, tip="d", fixed=held), Peer(text, follows, held), "a", "d")


def test_a_file_is_read_from_a_path_and_named_after_it(tmp_path):
    path = tmp_path / "seven.urdf"
    path.write_text(robot(joint("j", "a", "b"), name=""), encoding="utf-8")
    assert sr.Arm.from_urdf(path) == sr.Arm.from_urdf(str(path))
    assert sr.Arm.from_urdf(path).name == "seven"


def test_text_is_text_whatever_encoding_it_names():
    text = robot(joint("ölbogen", "a", "b")).replace('version="1.0"', 'version="1.0" encoding="latin-1"')
    arm = sr.Arm.from_urdf(text)
    assert arm.joint_names == ("ölbogen",)


def test_a_file_in_latin_1(tmp_path):
    path = tmp_path / "arm.urdf"
    text = robot(joint("ölbogen", "a", "b")).replace('version="1.0"', 'version="1.0" encoding="ISO-8859-1"')
    path.write_bytes(text.encode("latin-1"))
    assert sr.Arm.from_urdf(path).joint_names == ("ölbogen",)


def test_an_arm_needs_no_reader_of_files():
    code = "import stillreach, sys; stillreach.Arm; print([m for m in ('mujoco', 'pyexpat') if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "[]"
