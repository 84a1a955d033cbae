"""Arms by name: what makes them, what they take, what is refused. The robots' numbers: tests/robots/test_arms.py."""

import math
import pickle

import numpy as np
import pytest

import stillreach as sr

ROBOTS = [name for name, builder in sr.arms.BUILDERS.items() if hasattr(builder, "tips")]


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_has_rate_limits_a_source_and_its_name(name):
    robot = getattr(sr.arms, name)
    arm = robot()
    assert arm.name == name
    assert arm.n >= 7
    assert np.all(np.isfinite(arm.velocity_limits) & (arm.velocity_limits > 0))
    assert np.all(arm.position_limits[:, 0] < arm.position_limits[:, 1])
    assert robot.source in robot.__doc__
    assert all(tip in robot.__doc__ for tip in robot.tips)
    assert arm == sr.arms.by_name(name) == robot(tip=robot.tips[0]) == pickle.loads(pickle.dumps(arm))


@pytest.mark.parametrize(("tip", "end"), [("panda_link8", 0.333 + 0.316 + 0.384 - 0.107), ("panda_hand_tcp", 0.8226)])
def test_the_tip_is_the_tool(tip, end):
    """Stretched out at zero a Panda's flange points down, 88 mm in front of its base."""
    np.testing.assert_allclose(sr.arms.panda(tip=tip).forward(np.zeros(7))[:3, 3], [0.088, 0, end], atol=1e-12)


def test_rizon4_by_its_axes_at_zero():
    points = [(0, 0), (-0.03, 0.365), (-0.065, 0.57), (-0.035, 0.76), (-0.01, 0.955), (-0.04, 1.145), (-0.113, 1.255)]
    axes = [(0, 0, 1), (0, -1, 0), (0, 0, 1), (0, 1, 0), (0, 0, 1), (0, -1, 0), (1, 0, 0)]
    places = [(x, *point) for x, point in zip((0, 0, 0, 0.02, 0, 0, 0.015), points, strict=True)]
    tool = np.array([0.096, -0.113, 1.255])
    columns = [[*np.cross(axis, tool - place), *axis] for axis, place in zip(axes, places, strict=True)]
    arm = sr.arms.rizon4()
    np.testing.assert_allclose(arm.forward(np.zeros(7))[:3, 3], tool, atol=1e-15)
    np.testing.assert_allclose(arm.jacobian(np.zeros(7)), np.transpose(columns), atol=1e-15)


def test_panda_and_fr3_have_the_acceleration_limits_that_their_maker_publishes():
    assert sr.arms.panda().acceleration_limits.tolist() == [15, 7.5, 10, 12.5, 15, 20, 20]
    assert sr.arms.fr3().acceleration_limits.tolist() == [10] * 7
    assert np.all(np.isinf(sr.arms.xarm7().acceleration_limits))


@pytest.mark.parametrize("name", ["planar", "snake"])
def test_a_number_of_joints_is_part_of_the_name_or_stands_beside_it(name):
    arm = getattr(sr.arms, name)(4)
    assert arm == sr.arms.by_name(f"{name}4") == sr.arms.by_name(name, n=4) == sr.arms.by_name(arm.name)


def test_settings_reach_the_builder_and_none_is_not_given():
    assert sr.arms.by_name("nasa_modular", lengths=0.5, n=None, tip=None) == sr.arms.nasa_modular(0.5)
    assert sr.arms.by_name("panda", tip="panda_hand_tcp") == sr.arms.panda(tip="panda_hand_tcp")


@pytest.mark.parametrize(
    ("name", "settings", "message"),
    [
        ("pand", {}, r"arm: got 'pand', expected one of baxter, .*planarN.*\(did you mean 'panda'\?\)"),
        ("planar", {}, "n: got nothing, expected the number of joints, which planar needs, e.g. planar7"),
        ("planar3", {"n": 3}, "n: got 3, expected nothing beside planar3"),
        ("planar0", {}, "n: got 0, expected an integer of at least 1"),
        ("panda", {"n": 7}, "n: got the setting 'n', expected only tip beside panda"),
        ("panda7", {}, "arm: got 'panda7'"),
        ("panda", {"tip": "panda_hand"}, r"tip: got 'panda_hand', expected one of panda_link8, panda_hand_tcp \(did"),
        ("snake5", {"tip": "x"}, "tip: got the setting 'tip', expected only n beside snake"),
    ],
)
def test_what_cannot_be_made_is_refused_with_what_can(name, settings, message):
    with pytest.raises(sr.InputError, match=message):
        sr.arms.by_name(name, **settings)


def test_all_names_are_public():
    assert set(sr.arms.__all__) == {*sr.arms.BUILDERS, "by_name"}
    assert all(math.isfinite(sr.arms.by_name(name).reach) for name in ROBOTS)
