"""What URDF 1.1 and 1.2 add: quaternions, limits of the acceleration, ranges that must be there."""

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.file_peer import Peer
from tests.unit.arm.urdf_texts import joint, robot


def versioned(version, *joints):
    return robot(*joints).replace("<robot ", f'<robot version="{version}" ')


def limited(version, limit, kind="revolute"):
    return versioned(version, joint("j", "a", "b", kind, limit=limit))


def turned(quaternion):
    """A turned joint, and a tip 1 m along its x axis and 2 m along its y axis."""
    first = joint("j", "a", "b", xyz="0 0 1").replace('rpy="0 0 0"', f'quat_xyzw="{quaternion}"')
    return first, joint("tip_mount", "b", "tip", "fixed", xyz="1 2 0")


@pytest.mark.parametrize("version", ["1.1", "1.2"])
@pytest.mark.parametrize("quaternion", ["0 0.7071067811865476 0 0.7071067811865476", "1 2 -3 4", "0 0 -2e-5 1e-5"])
def test_a_quaternion_turns_a_joint_as_pinocchio_reads_it(version, quaternion):
    text = versioned(version, *turned(quaternion))
    arm, peer = sr.Arm.from_urdf(text), Peer(text)
    for q in ([0.0], [0.7]):
        T, J = peer.chain("a", "tip", ["j"], q)
        assert arm.forward(q) == pytest.approx(T, abs=1e-12)
        assert arm.jacobian(q) == pytest.approx(J, abs=1e-12)


@pytest.mark.parametrize("size", [1e-200, 1e200])
def test_a_quaternion_of_any_length_is_a_direction(size):
    arm = sr.Arm.from_urdf(versioned("1.1", *turned(f"0 {size} 0 {size}")))
    # a quarter turn about y takes x to -z: from z = 1 down to 0; y stays
    assert arm.forward([0.0])[:3, 3] == pytest.approx([0.0, 2.0, 0.0], abs=1e-12)


def test_a_quaternion_beside_angles_is_no_part_of_urdf_1_0():
    first, mount = turned("0 1 0 0")
    text = robot(first.replace("quat_xyzw", 'rpy="0 0 0.5" quat_xyzw'), mount)
    T, _ = Peer(text).chain("a", "tip", ["j"], [0.0])
    assert sr.Arm.from_urdf(text).forward([0.0]) == pytest.approx(T, abs=1e-12)


@pytest.mark.parametrize("version", ["1.0", " 1.0", "01.0"])
def test_other_spellings_of_a_version_are_read_as_pinocchio_does(version):
    text = limited(version, 'lower="-1" upper="1" velocity="1" effort="1"')
    assert Peer(text).model.nv == sr.Arm.from_urdf(text).n == 1


@pytest.mark.parametrize(
    ("rates", "acceleration"),
    [
        ('acceleration="5"', 5.0),
        ('acceleration="5" deceleration="6" jerk="7"', 5.0),
        ('acceleration="5" deceleration="3"', 3.0),
        ('deceleration="3"', 3.0),
        ('acceleration="0"', 0.0),
        ('acceleration="2e9"', np.inf),
        ("", np.inf),
    ],
)
def test_the_smaller_of_acceleration_and_deceleration_limits_both(rates, acceleration):
    limit = f'lower="-1" upper="1" velocity="2" {rates}'
    assert sr.Arm.from_urdf(limited("1.2", limit)).acceleration_limits.tolist() == [acceleration]
    assert sr.Arm.from_urdf(limited("1.1", limit)).acceleration_limits.tolist() == [np.inf]  # no part of it


def test_an_acceleration_limit_from_a_file_bounds_the_first_tick():
    arm = sr.Arm.from_urdf(limited("1.2", 'lower="-1" upper="1" velocity="2" acceleration="5"'))
    rates = sr.Controller(arm, period=0.01).step([0.0], [0, 0, 0, 0, 0, 1.0]).rates
    assert rates == pytest.approx([0.05], abs=1e-15)


def test_the_acceleration_of_a_follower_limits_its_leader():
    limit = 'lower="-1" upper="1" velocity="2" acceleration="{}"'
    follow = '<mimic joint="j" multiplier="-2"/>'
    text = versioned(
        "1.2",
        joint("j", "a", "b", limit=limit.format(5)),
        joint("k", "b", "c", limit=limit.format(4), extra=follow),
    )
    assert sr.Arm.from_urdf(text).acceleration_limits.tolist() == [2.0]


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("limit", ['velocity="2"', 'lower="-1" velocity="2"', 'upper="1" velocity="2"'])
def test_a_range_is_required_from_1_2_on_and_has_zeros_before(kind, limit):
    with pytest.raises(sr.errors.RobotFileError, match=r"which URDF 1\.2 requires"):
        sr.Arm.from_urdf(limited("1.2", limit, kind))
    text = limited("1.1", f'{limit} effort="1"', kind)
    model = Peer(text).model
    wanted = [[model.lowerPositionLimit[0], model.upperPositionLimit[0]]]
    assert sr.Arm.from_urdf(text).position_limits.tolist() == wanted


def test_a_continuous_joint_of_1_2_needs_no_range():
    arm = sr.Arm.from_urdf(limited("1.2", 'velocity="2" acceleration="3"', "continuous"))
    assert arm.position_limits.tolist() == [[-np.inf, np.inf]]
    assert (arm.velocity_limits.tolist(), arm.acceleration_limits.tolist()) == ([2.0], [3.0])
