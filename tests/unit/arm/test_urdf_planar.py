"""Planar joints of URDF files: two slides and a turn; and floating ones, which no chain can pass."""

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.file_peer import Peer
from tests.unit.arm.mjcf_peer import Peer as MujocoPeer
from tests.unit.arm.urdf_texts import joint, robot

BASE = ("base_TX", "base_TY", "base_RZ")
FOR_MUJOCO = '<mujoco><compiler boundmass="1" boundinertia="1" fusestatic="false"/></mujoco></robot>'


def mobile(axis, **settings):
    """A cart on a plane, an arm on it, a tip."""
    return robot(
        joint("base", "world", "cart", "planar", axis=axis, xyz="0.1 0.2 0.3", rpy="0.3 0.2 0.1", **settings),
        joint("j", "cart", "arm", axis="0 1 0", xyz="0 0 1"),
        joint("mount", "arm", "tip", "fixed", xyz="1 0 0"),
    )


@pytest.mark.parametrize("axis", ["0 0 1", "0 0 2"])
def test_a_planar_joint_is_pinocchios(axis):
    text = mobile(axis)
    arm, peer = sr.Arm.from_urdf(text), Peer(text)
    assert arm.joint_names == (*BASE, "j")
    assert arm.kinds.tolist() == [1, 1, 0, 0]
    assert np.isinf(arm.position_limits[:3]).all()
    for x, y, turn, bend in np.random.default_rng(2).uniform(-2, 2, (10, 4)):
        whole = peer.neutral()
        whole[:4] = x, y, np.cos(turn), np.sin(turn)
        whole[4] = bend
        assert arm.forward([x, y, turn, bend]) == pytest.approx(peer.pose("tip", whole), abs=1e-12)


@pytest.mark.parametrize(
    "axis",
    ["0 0 1", "0 0 -1", "1 0 0", "0 1 0", "1 1 1", "-0.3 0.2 -2", "1e-6 2e-6 -1", "1e-12 2e-12 -1", "0 1e-110 -1"],
)
@pytest.mark.parametrize(("base", "tip"), [("world", "tip"), ("tip", "world"), ("tip", "cart"), ("cart", "world")])
def test_a_planar_joint_about_any_axis_is_mujocos_in_both_directions(axis, base, tip):
    text = mobile(axis)
    arm, peer = sr.Arm.from_urdf(text, base=base, tip=tip), MujocoPeer(text.replace("</robot>", FOR_MUJOCO))
    assert set(arm.joint_names) <= {*BASE, "j"}
    for q in np.random.default_rng(5).uniform(-2, 2, (10, arm.n)):
        T, J = peer.chain(base, tip, arm.joint_names, q)
        assert arm.forward(q) == pytest.approx(T, abs=1e-8)  # MuJoCo's axes are of length 1 to 1e-9
        assert arm.jacobian(q) == pytest.approx(J, abs=1e-8)


def test_the_rates_of_a_planar_joint_are_limited_in_each_way():
    text = mobile("0 0 1", limit='velocity="0.5" acceleration="2"').replace("<robot ", '<robot version="1.2" ')
    arm = sr.Arm.from_urdf(text)
    assert arm.velocity_limits[:3].tolist() == [0.5, 0.5, 0.5]
    assert arm.acceleration_limits[:3].tolist() == [2.0, 2.0, 2.0]
    assert sr.Arm.from_urdf(mobile("0 0 1")).velocity_limits[:3].tolist() == [np.inf] * 3


def test_a_part_of_a_planar_joint_is_held_by_its_name():
    whole, held = sr.Arm.from_urdf(mobile("0 0 1")), sr.Arm.from_urdf(mobile("0 0 1"), fixed={"base_TY": 0.4})
    assert held.joint_names == ("base_TX", "base_RZ", "j")
    assert held.forward([0.1, 0.2, 0.3]) == pytest.approx(whole.forward([0.1, 0.4, 0.2, 0.3]), abs=1e-15)
    with pytest.raises(sr.errors.RobotFileError, match="a joint between base and tip: base_TX, base_TY, base_RZ, j"):
        sr.Arm.from_urdf(mobile("0 0 1"), fixed={"base": 0.4})


def test_an_arm_on_a_planar_base_comes_back_from_its_file():
    arm = sr.Arm.from_urdf(mobile("1 1 1"))
    q = [0.1, 0.2, 0.3, 0.4]
    assert sr.Arm.from_urdf(arm.to_urdf()).forward(q) == pytest.approx(arm.forward(q), abs=1e-14)


@pytest.mark.parametrize(
    ("asked", "argument", "advice", "links"),
    [
        ({"tip": "tip"}, "base", "base='cart' begins after it", {"base": "cart", "tip": "tip"}),
        ({"base": "tip", "tip": "world"}, "tip", "tip='cart' ends before it", {"base": "tip", "tip": "cart"}),
    ],
)
def test_a_floating_joint_is_answered_with_the_chain_beside_it(asked, argument, advice, links):
    text = mobile("0 0 1").replace('"planar"', '"floating"')
    with pytest.raises(sr.errors.RobotFileError) as caught:
        sr.Arm.from_urdf(text, **asked)
    assert (caught.value.argument, caught.value.choices) == (argument, ("cart",))
    assert advice in str(caught.value)
    assert sr.Arm.from_urdf(text, **links).joint_names == ("j",)
