"""The arm as an object: joints and names, limits, tool, text, and that it does not change."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.odd_arms import placement


def slide_and_turn():
    slide = sr.Joint(name="lift", kind="prismatic", position_limits=(-0.5, 2.0), velocity_limit=0.1)
    turn = sr.Joint(axis=(0, 3, 0), placement=placement((0, 0, 1)), velocity_limit=2, acceleration_limit=4)
    return sr.Arm([slide, turn], tool=placement((1, 0, 0)), name="hoist")


def test_what_the_joints_say_as_arrays():
    arm = slide_and_turn()
    assert arm.n == 2
    assert arm.name == "hoist"
    assert arm.joint_names == ("lift", "j2")
    assert arm.kinds.tolist() == [1, 0]
    assert arm.kinds.dtype == np.int8
    assert arm.velocity_limits.tolist() == [0.1, 2.0]
    assert arm.position_limits.tolist() == [[-0.5, 2.0], [-np.inf, np.inf]]
    assert arm.acceleration_limits.tolist() == [np.inf, 4.0]
    assert arm.reach == 4.0


def test_joints_without_a_name_are_numbered_by_place():
    joints = [sr.Joint(), sr.Joint(name="elbow"), sr.Joint()]
    assert sr.Arm(joints).joint_names == ("j1", "elbow", "j3")
    assert sr.Arm(iter(joints)).joints == sr.Arm(joints).joints


def test_reach_is_what_a_stretched_arm_attains():
    for arm in (sr.arms.planar(3), sr.arms.snake(5), sr.arms.nasa_modular()):
        distance = np.linalg.norm(arm.forward(np.zeros(arm.n))[:3, 3])
        np.testing.assert_allclose(arm.reach, distance, rtol=1e-15)
    assert sr.Arm([sr.Joint(kind="prismatic")]).reach == np.inf


def test_an_arm_cannot_be_changed():
    T = np.eye(4)
    joints = [sr.Joint()]
    arm = sr.Arm(joints, tool=T)
    T[0, 3] = 5.0
    joints.append(sr.Joint())
    assert arm.tool[0, 3] == 0.0
    assert arm.n == 1
    for name in ("tool", "kinds", "velocity_limits", "position_limits", "acceleration_limits"):
        with pytest.raises(ValueError, match=r"read-only"):
            getattr(arm, name)[0] = 1
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(arm, name, getattr(arm, name))
    for name in ("n", "joints", "name", "model", "colour"):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(arm, name, 1)


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda arm: pickle.loads(pickle.dumps(arm))])
def test_copies_are_the_same_arm(again, arm):
    arm.forward(np.zeros(arm.n))  # its compiled model exists, and does not stand in the way
    other = again(arm)
    assert other == arm
    assert hash(other) == hash(arm)
    assert not other.tool.flags.writeable
    q = np.linspace(-2, 2, arm.n)
    np.testing.assert_array_equal(other.forward(q), arm.forward(q))


def test_the_compiled_model_is_built_once():
    arm = sr.arms.planar(3)
    assert arm.model is arm.model
    assert arm.model.n == 3


def test_arms_differ_by_joint_tool_and_name():
    arm = slide_and_turn()
    assert arm == slide_and_turn()
    assert arm != arm.with_tool(np.eye(4))
    assert arm != arm.with_limits(velocity=1)
    assert arm != sr.Arm(arm.joints, tool=arm.tool, name="crane")
    assert arm != "hoist"


def test_other_limits_one_for_all_or_one_each():
    arm = slide_and_turn()
    other = arm.with_limits(velocity=3, position=(-1, 1), acceleration=[5, np.inf])
    assert other.velocity_limits.tolist() == [3, 3]
    assert other.position_limits.tolist() == [[-1, 1], [-1, 1]]
    assert other.acceleration_limits.tolist() == [5, np.inf]
    each = arm.with_limits(velocity=[0, 1], position=[(-1, 1), (-np.inf, 3)])
    assert each.velocity_limits.tolist() == [0, 1]
    assert each.position_limits.tolist() == [[-1, 1], [-np.inf, 3]]
    assert each.acceleration_limits.tolist() == arm.acceleration_limits.tolist()
    assert arm == slide_and_turn()
    assert arm.with_limits() == arm


def test_two_pairs_for_two_joints_are_not_one_pair():
    arm = sr.arms.planar(2).with_limits(position=np.array([[-1.0, 1.0], [-2.0, 2.0]]))
    assert arm.position_limits.tolist() == [[-1, 1], [-2, 2]]


@pytest.mark.parametrize(
    ("argument", "value", "told"),
    [
        ("velocity", -1, "velocity: got -1.0, expected 3 numbers (or one for all), each at least 0"),
        ("velocity", [1, -1, 1], "velocity: got -1.0 at index 1"),
        ("velocity", [1, np.nan, 1], "velocity: got nan at index 1"),
        ("velocity", [1, 1], "velocity: got [1, 1] of shape (2,)"),
        ("velocity", "fast", "velocity: got 'fast'"),
        ("acceleration", -0.5, "acceleration: got -0.5"),
        ("acceleration", [[1, 1, 1]], "acceleration: got [[1, 1, 1]] of shape (1, 3)"),
        ("position", 1.0, "position: got 1.0, expected a matrix (3, 2) of numbers"),
        ("position", [[0, 1]] * 2, "position: got [[0, 1], [0, 1]] of shape (2, 2)"),
        ("position", (1, -1), "position_limits of joint 'j1': got [1.0, -1.0]"),
        ("position", [[0, 1], [0, 1], [2, 1]], "position_limits of joint 'j3': got [2.0, 1.0]"),
        ("position", (np.nan, 1), "position: got nan at index (0, 0)"),
    ],
)
def test_other_limits_are_checked(argument, value, told):
    with pytest.raises(sr.InputError) as caught:
        sr.arms.planar(3).with_limits(**{argument: value})
    assert told in str(caught.value)


def test_another_tool_takes_the_place_of_the_one_before():
    arm = sr.arms.planar(2)
    T = placement((0, 0, 0.5), (0, 1, 0), 0.4)
    np.testing.assert_array_equal(arm.with_tool(T).tool, T)
    longer = arm.with_tool(arm.tool @ placement((0.5, 0, 0)))
    np.testing.assert_array_equal(longer.forward([0, 0])[:3, 3], [2.5, 0, 0])
    assert arm.tool[0, 3] == 1.0


@pytest.mark.parametrize("tool", [np.eye(3), 2 * np.eye(4), "gripper", np.full((4, 4), np.nan)])
def test_a_tool_is_a_rigid_transform(tool):
    with pytest.raises(sr.InputError, match=r"^tool: "):
        sr.arms.planar(2).with_tool(tool)
    with pytest.raises(sr.InputError, match=r"^tool: "):
        sr.Arm([sr.Joint()], tool=tool)


@pytest.mark.parametrize(
    ("joints", "told"),
    [
        ([], "joints: got none, expected one or more Joint"),
        (3, "joints: got 3"),
        ([sr.Joint(), "elbow"], "joints: got 'elbow' at place 1"),
        ([sr.Joint(name="a"), sr.Joint(), sr.Joint(name="a")], "the name 'a' at places 0 and 2"),
        ([sr.Joint(name="j2"), sr.Joint()], "the name 'j2' at places 0 and 1"),
    ],
)
def test_an_arm_has_joints_with_names_of_their_own(joints, told):
    with pytest.raises(sr.InputError) as caught:
        sr.Arm(joints)
    assert told in str(caught.value)


@pytest.mark.parametrize("name", ["", None, 3])
def test_the_name_of_an_arm_is_text(name):
    with pytest.raises(sr.InputError, match=r"^name: got"):
        sr.Arm([sr.Joint()], name=name)


def test_a_joint_is_found_by_name_and_by_index():
    arm = slide_and_turn()
    assert [arm.joint_index(joint) for joint in ("lift", "j2", 0, 1, np.int64(1), np.uint8(0))] == [
        0,
        1,
        0,
        1,
        1,
        0,
    ]
    assert type(arm.joint_index(np.int64(1))) is int


@pytest.mark.parametrize("joint", ["j12", "J1", "", -1, 11, 2**70, True, np.True_, 1.0, None, [1], np.array([1])])
def test_an_unknown_joint_is_answered_with_the_choices(joint):
    arm = sr.arms.nasa_modular()
    with pytest.raises(sr.errors.UnknownJointError) as caught:
        arm.joint_index(joint)
    assert caught.value.choices == arm.joint_names
    assert "expected one of j1 … j11 or an index from 0 to 10" in str(caught.value)
    assert str(caught.value).endswith("(did you mean 'j1'?)") == (isinstance(joint, str) and joint == "J1")


def test_names_that_do_not_count_up_are_all_listed():
    with pytest.raises(
        sr.errors.UnknownJointError, match=r"joint: got 'elbow', expected one of lift, j2 or an index from 0 to 1"
    ):
        slide_and_turn().joint_index("elbow")


def test_the_table_shows_every_joint_with_place_axis_limits_and_unit():
    text = slide_and_turn().describe()
    assert str(slide_and_turn()) == text
    lines = [line.split() for line in text.splitlines()]
    assert text.splitlines()[0] == "hoist, 1 revolute + 1 prismatic joints, reach at most 4 m:"
    assert lines[2] == ["lift", "prismatic", "(0,", "0,", "0)", "(0,", "0,", "1)", "-0.5", "…", "2", "0.1", "free", "m"]
    assert lines[3] == ["j2", "revolute", "(0,", "0,", "1)", "(0,", "1,", "0)", "free", "2", "4", "rad"]
    assert lines[4] == ["tool", "at", "zero:", "(1,", "0,", "1)", "m"]


def test_the_short_form_is_one_line():
    assert repr(sr.arms.nasa_modular()) == "<Arm nasa_modular, 11 revolute joints, reach at most 4.572 m>"
    assert repr(sr.arms.planar(1)) == "<Arm planar1, 1 revolute joint, reach at most 1 m>"
