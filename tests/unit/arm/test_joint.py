"""One joint: what it takes, what it refuses, and that it does not change."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

import stillreach as sr


def test_a_plain_joint_turns_about_z_without_limits():
    joint = sr.Joint()
    assert joint.name is None
    assert joint.kind == "revolute"
    np.testing.assert_array_equal(joint.placement, np.eye(4))
    np.testing.assert_array_equal(joint.axis, [0, 0, 1])
    assert joint.position_limits == (-np.inf, np.inf)
    assert joint.velocity_limit == np.inf
    assert joint.acceleration_limit == np.inf


def test_arguments_are_keywords():
    with pytest.raises(TypeError):
        sr.Joint("elbow")


@pytest.mark.parametrize("axis", [(0, 0, 5), (0, 0, 1e-300), (0, 0, 1e300), (0, 0, 5e-324), (0, 0, 1)])
def test_an_axis_is_a_direction_of_any_length(axis):
    assert sr.Joint(axis=axis).axis.tolist() == [0, 0, 1]


def test_normalising_an_axis_twice_changes_nothing():
    for axis in np.random.default_rng(1).normal(size=(200, 3)):
        once = sr.Joint(axis=axis).axis
        np.testing.assert_array_equal(sr.Joint(axis=once).axis, once)
        np.testing.assert_allclose(once, axis / np.linalg.norm(axis), rtol=1e-15)


def test_zero_limits_mean_zero():
    joint = sr.Joint(velocity_limit=0, acceleration_limit=0.0, position_limits=(0, 0))
    assert (joint.velocity_limit, joint.acceleration_limit, joint.position_limits) == (0.0, 0.0, (0.0, 0.0))


def test_settings_may_be_lists_and_float32():
    joint = sr.Joint(
        placement=np.eye(4, dtype=np.float32).tolist(),
        axis=np.array([0, 1, 0], dtype=np.float32),
        position_limits=np.array([-1, 2], dtype=np.int32),
        velocity_limit=np.float32(0.5),
    )
    assert joint.placement.dtype == joint.axis.dtype == np.float64
    assert joint.position_limits == (-1.0, 2.0)
    assert joint.velocity_limit == 0.5
    assert type(joint.velocity_limit) is float


def test_a_joint_cannot_be_changed():
    T, axis = np.eye(4), np.array([0.0, 1.0, 0.0])
    joint = sr.Joint(name="elbow", placement=T, axis=axis)
    T[0, 3] = axis[0] = 7.0  # the caller's arrays stay the caller's
    assert joint.placement[0, 3] == joint.axis[0] == 0.0
    for array in (joint.placement, joint.axis):
        with pytest.raises(ValueError, match=r"read-only"):
            array[0] = 1.0
    for field in dataclasses.fields(joint):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(joint, field.name, 1)


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda joint: pickle.loads(pickle.dumps(joint))])
def test_copies_are_equal_and_read_only(again):
    joint = sr.Joint(name="elbow", kind="prismatic", axis=(1, 2, 3), position_limits=(-1, np.inf), velocity_limit=0)
    other = again(joint)
    assert other == joint
    assert hash(other) == hash(joint)
    assert not other.axis.flags.writeable
    assert not other.placement.flags.writeable


def test_joints_are_equal_when_all_they_hold_is():
    joint = sr.Joint(name="elbow")
    assert joint == sr.Joint(name="elbow", axis=(0.0, -0.0, 2.0))
    assert hash(joint) == hash(sr.Joint(name="elbow", axis=(0.0, -0.0, 2.0)))
    for change in (
        {"name": "wrist"},
        {"kind": "prismatic"},
        {"axis": (0, 0, -1)},
        {"placement": np.diag([1, -1, -1, 1])},
        {"position_limits": (-1, 1)},
        {"velocity_limit": 1},
        {"acceleration_limit": 1},
    ):
        assert dataclasses.replace(joint, **change) != joint
    assert joint != "elbow"


ALMOST = np.eye(4)
ALMOST[0, 1] = 3e-5
TILTED_ROW = np.eye(4)
TILTED_ROW[3, 0] = 0.1


@pytest.mark.parametrize(
    ("argument", "value", "told"),
    [
        ("kind", "revolut", "did you mean 'revolute'"),
        ("kind", "fixed", "expected one of 'revolute', 'prismatic'"),
        ("kind", 0, "got 0"),
        ("axis", (0, 0, 0), "not all zero"),
        ("axis", (0, 0), "got (0, 0) of shape (2,)"),
        ("axis", (0, np.nan, 1), "got nan at index 1"),
        ("axis", (0, np.inf, 1), "got inf at index 1"),
        ("axis", "z", "got 'z'"),
        ("axis", (True, False, False), "expected 3 finite numbers"),
        ("placement", np.eye(3), "float64 array of shape (3, 3), expected a matrix (4, 4) of finite numbers"),
        ("placement", 2 * np.eye(4), "the last row [0.0, 0.0, 0.0, 2.0]"),
        ("placement", np.diag([1, 1, 1.1, 1]), "off by 0.21, expected a rigid transform"),
        ("placement", np.diag([1, 1, -1, 1]), "a reflection"),
        ("placement", np.zeros((4, 4)), "the last row"),
        ("placement", np.diag([1e200, 1, 1, 1]), "off by inf"),
        ("placement", ALMOST, "off by 3e-05"),
        ("placement", TILTED_ROW, "the last row [0.1, 0.0, 0.0, 1.0]"),
        ("placement", np.full((4, 4), np.nan), "got nan at index (0, 0)"),
        ("position_limits", (1, 0), "lower <= upper"),
        ("position_limits", (np.nan, 0), "got nan at index 0"),
        ("position_limits", (np.inf, np.inf), "lower below inf"),
        ("position_limits", (-np.inf, -np.inf), "upper above -inf"),
        ("position_limits", (0, 1, 2), "two numbers (lower, upper)"),
        ("position_limits", 1.0, "got 1.0"),
        ("position_limits", None, "got None"),
        ("velocity_limit", -0.1, "got -0.1, expected a number of at least 0"),
        ("velocity_limit", np.nan, "got nan"),
        ("velocity_limit", [1.0], "got [1.0] of shape (1,)"),
        ("velocity_limit", True, "got True"),
        ("velocity_limit", None, "got None"),
        ("acceleration_limit", -np.inf, "got -inf"),
        ("acceleration_limit", "2", "got '2'"),
    ],
)
def test_refusals_name_joint_and_argument(argument, value, told):
    with pytest.raises(sr.InputError) as caught:
        sr.Joint(name="elbow", **{argument: value})
    assert caught.value.argument == f"{argument} of joint 'elbow'"
    assert told in str(caught.value)
    with pytest.raises(sr.InputError) as caught:
        sr.Joint(**{argument: value})
    assert caught.value.argument == argument


@pytest.mark.parametrize("name", ["", " ", "elbow ", 3, b"elbow", True])
def test_a_name_is_text(name):
    with pytest.raises(sr.InputError, match=r"^name: got .*, expected a joint name"):
        sr.Joint(name=name)


def test_a_placement_right_to_rounding_is_taken_as_it_is():
    c, s = np.cos(0.3), np.sin(0.3)
    T = np.array([[c, -s, 0, 1], [s, c, 0, 2], [0, 0, 1, 3], [0, 1e-17, 0, 1 - 1e-16]])
    joint = sr.Joint(placement=T)
    np.testing.assert_array_equal(joint.placement[:3], T[:3])
    assert joint.placement[3].tolist() == [0, 0, 0, 1]
