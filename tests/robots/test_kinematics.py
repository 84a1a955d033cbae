"""Pose and Jacobian of real robots: those of URDF files against Pinocchio, those of MJCF files against MuJoCo."""

import numpy as np
import pytest

import stillreach as sr
from tests.robots.catalogue import MJCF, ROBOTS, URDF
from tests.unit.arm import file_peer, mjcf_peer

CONFIGURATIONS = 100
CLOSE = 1e-10


def configurations(arm):
    """Random ones, all around and beyond the limits."""
    return np.random.default_rng(5).uniform(-np.pi, np.pi, (CONFIGURATIONS, arm.n))


def check(arm, peer, base, tip):
    """Poses and Jacobians for one configuration and for many at once are the peer's."""
    q = configurations(arm)
    expected = [peer.chain(base, tip, arm.joint_names, row) for row in q]
    poses, jacobians = (np.array(part) for part in zip(*expected, strict=True))
    assert np.max(np.abs(arm.forward(q) - poses)) <= CLOSE
    assert np.max(np.abs(arm.jacobian(q) - jacobians)) <= CLOSE
    assert np.ptp(poses[:, :3, 3], axis=0).min() > 0.1  # it moved


@pytest.mark.parametrize("name", ROBOTS)
def test_the_chain_is_the_one_asked_for(name):
    robot = ROBOTS[name]
    arm = robot.make()
    assert arm.n == robot.n
    assert np.count_nonzero(arm.kinds) == robot.slides
    assert len(arm.describe().splitlines()) == arm.n + len(robot.follows) + 3
    assert {follower.joint.name for follower in arm.followers} == set(robot.follows)
    assert not set(robot.held) & set(arm.joint_names)
    assert np.all(arm.position_limits[:, 0] < arm.position_limits[:, 1])
    assert np.all(arm.velocity_limits > 0.0)
    assert np.all(np.isinf(arm.velocity_limits)) == (name in MJCF)


@pytest.mark.parametrize("name", URDF)
def test_a_urdf_files_chain_is_pinocchios(name):
    robot = URDF[name]
    text = robot.file.read_text(encoding="utf-8")
    peer = file_peer.Peer(text, robot.follows, robot.held)
    check(robot.make(), peer, robot.base or root(text), robot.tip)


@pytest.mark.parametrize("name", MJCF)
def test_an_mjcf_files_chain_is_mujocos(name):
    robot = MJCF[name]
    check(robot.make(), mjcf_peer.Peer(robot.file), robot.base or "world", robot.tip)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_real_arm_written_as_urdf_and_read_back_is_the_same(name):
    arm = ROBOTS[name].make()
    again = sr.Arm.from_urdf(arm.to_urdf())
    q = configurations(arm)[:10]
    assert again.joint_names == arm.joint_names
    assert again.position_limits.tolist() == arm.position_limits.tolist()
    assert np.max(np.abs(again.jacobian(q) - arm.jacobian(q))) <= 1e-12


def root(text):
    """The link that is nobody's child, looked up in the text alone."""
    from xml.etree import ElementTree

    tree = ElementTree.fromstring(text.encode())
    children = {child.get("link") for child in tree.findall("joint/child")}
    (only,) = {link.get("name") for link in tree.findall("link")} - children
    return only
