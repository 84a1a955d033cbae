"""Arms written as URDF and read again, by us and by Pinocchio."""

import numpy as np
import pytest

import stillreach as sr
from stillreach._rotations import rpy
from tests.unit.arm.coupled_arms import coupled
from tests.unit.arm.file_peer import Peer
from tests.unit.arm.literal_kinematics import rotation
from tests.unit.arm.mjcf_peer import Peer as MujocoPeer
from tests.unit.arm.odd_arms import ODD_ARMS, configurations, scale


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(monkeypatch, tmp_path):
    """MuJoCo writes a log into the working directory when it warns, e.g. of a range of one point."""
    monkeypatch.chdir(tmp_path)


def dh_arm():
    """Four DH rows of both kinds, seen from a base that is turned."""
    rows = [
        sr.DHRow(a=0.4, alpha=np.pi / 2, d=0.1, theta=0.3),
        sr.DHRow(a=0.1, alpha=-0.7, d=0.2, theta=-2.0, kind="prismatic"),
        sr.DHRow(a=0.3, alpha=np.pi, theta=1.0, name="wrist"),
        sr.DHRow(d=-0.2, kind="prismatic"),
    ]
    return sr.Arm.from_dh(rows, "modified", base=sr.arms.snake(3).forward([0.3, 0.1, 0.2]), tool=np.eye(4))


ARMS = ODD_ARMS | {"from DH": dh_arm, "modules": lambda: sr.Arm.from_modules("RPRP", [0.1, 0.2, 0.3])}


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_read_back_is_the_same(name):
    arm = ARMS[name]()
    text = arm.to_urdf()
    again = sr.Arm.from_urdf(text)
    assert again.name == arm.name
    assert again.joint_names == arm.joint_names
    assert again.kinds.tolist() == arm.kinds.tolist()
    assert again.position_limits.tolist() == arm.position_limits.tolist()
    assert again.velocity_limits.tolist() == arm.velocity_limits.tolist()
    peer = Peer(text)
    for q in configurations(arm.n, seed=2):
        size = scale(arm, q)
        assert np.max(np.abs(again.forward(q) - arm.forward(q))) <= 1e-14 * size * arm.n
        assert np.max(np.abs(again.jacobian(q) - arm.jacobian(q))) <= 1e-14 * size * arm.n
        T, J = peer.chain("base_link", "tool", arm.joint_names, q)
        assert np.max(np.abs(T - arm.forward(q))) <= 1e-12 * size
        assert np.max(np.abs(J - arm.jacobian(q))) <= 1e-12 * size


@pytest.mark.parametrize("pitch", [0.0, 0.5, np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9, np.pi / 2 - 1e-16, 3.0])
def test_three_angles_explain_any_rotation(pitch):
    x, y, z = np.eye(3)
    for roll, yaw in np.random.default_rng(6).uniform(-np.pi, np.pi, (20, 2)):
        T = np.eye(4)
        T[:3, :3] = rotation(z, yaw) @ rotation(y, pitch) @ rotation(x, roll)
        again = rpy(T[:3, :3])
        R = rotation(z, again[2]) @ rotation(y, again[1]) @ rotation(x, again[0])
        assert np.max(np.abs(R - T[:3, :3])) <= 1e-15


def test_limits_of_every_kind_come_back_and_mujoco_reads_them():
    inf = np.inf
    limits = [(-inf, inf), (-1.0, inf), (-inf, 2.0), (0.1, 0.1)]
    joints = [sr.Joint(kind=kind, position_limits=pair) for kind in ("revolute", "prismatic") for pair in limits]
    arm = sr.Arm(joints).with_limits(velocity=[inf, 0.0, 1e-300, 1e8, inf, 1.0, 2.0, 3.0])
    again = sr.Arm.from_urdf(arm.to_urdf())
    assert again.position_limits.tolist() == arm.position_limits.tolist()
    assert again.velocity_limits.tolist() == arm.velocity_limits.tolist()
    assert MujocoPeer(arm.to_urdf()).model.nv == 8


def test_acceleration_limits_come_back():
    limits = [np.inf, 0.0, 1e-300, 5.0]
    arm = sr.arms.planar(4).with_limits(acceleration=limits, velocity=2.0)
    assert sr.Arm.from_urdf(arm.to_urdf()).acceleration_limits.tolist() == limits
    assert Peer(arm.to_urdf()).model.nv == 4


def test_without_them_the_file_is_urdf_1_0_which_every_reader_takes():
    assert "version=" not in sr.arms.planar(4).to_urdf().split("?>")[1]


@pytest.mark.parametrize("name", ARMS)
def test_mujoco_reads_an_arm_and_keeps_its_tool(name):
    arm = ARMS[name]()
    peer = MujocoPeer(arm.to_urdf())
    assert list(peer.joints) == list(arm.joint_names)
    assert peer.model.body(peer.model.nbody - 1).name == "tool"
    for q in configurations(arm.n, seed=3):
        T, J = peer.chain("base_link", "tool", arm.joint_names, q)
        size = scale(arm, q)
        assert np.max(np.abs(T - arm.forward(q))) <= 1e-10 * size
        assert np.max(np.abs(J - arm.jacobian(q))) <= 1e-10 * size


def test_mujoco_couples_the_followers_of_an_arm():
    arm = coupled()
    peer = MujocoPeer(arm.to_urdf())
    couplings = {
        peer.model.joint(peer.model.eq_obj1id[i]).name: (
            peer.model.joint(peer.model.eq_obj2id[i]).name,
            *peer.model.eq_data[i, 1::-1],
        )
        for i in range(peer.model.neq)
    }
    assert couplings == {f.joint.name: (f.leader, f.multiplier, f.offset) for f in arm.followers}


def test_names_that_mean_something_in_xml_come_back():
    names = ['<a & "b">', "it's", "base", "base_link", "tool", "tool_mount", "a\nb\tc", "ö"]
    arm = sr.Arm([sr.Joint(name=name) for name in names], name="<&>")
    again = sr.Arm.from_urdf(arm.to_urdf())
    assert again.joint_names == tuple(names)
    assert again.name == "<&>"


@pytest.mark.parametrize("name", ["a\0b", "\x1b[31m", "\ud800", "\ufffe"])
def test_names_that_xml_cannot_hold_are_refused(name):
    with pytest.raises(sr.InputError, match="XML"):
        sr.Arm([sr.Joint(name=name)]).to_urdf()


def test_a_name_as_long_as_the_reader_takes_comes_back():
    name = "j" * 1000
    arm = sr.Arm([sr.Joint(name=name, kind="revolute", axis=(0.0, 0.0, 1.0))])
    assert sr.Arm.from_urdf(arm.to_urdf()).joint_names == (name,)


def test_a_file_is_written(tmp_path):
    arm = sr.arms.canadarm2()
    path = tmp_path / "canadarm2.urdf"
    assert arm.to_urdf(path) == path.read_text(encoding="utf-8")
    assert sr.Arm.from_urdf(path).joint_names == arm.joint_names
    with pytest.raises(OSError, match="gone"):
        arm.to_urdf(tmp_path / "gone" / "arm.urdf")
    with pytest.raises(sr.InputError, match="the name of a file"):
        arm.to_urdf(7)
