"""What `stillreach inspect` tells of an arm, against plain linear algebra."""

import json

import numpy as np
import pytest

import stillreach as sr
from stillreach.cli._locks import direction, locks, survey
from stillreach.cli._robots import BUILT_IN, built_in


def manipulability(J):
    return np.prod(np.linalg.svd(J, compute_uv=False))


@pytest.mark.parametrize("name", ["canadarm2", "nasa_modular", "snake9"])
def test_what_is_left_without_a_joint_is_the_ratio_of_manipulabilities(name):
    arm = built_in(name)
    for q in np.random.default_rng(3).uniform(-2.0, 2.0, (20, arm.n)):
        J = arm.jacobian(q)
        for i, lock in enumerate(locks(arm, q)):
            rest = np.delete(J, i, axis=1)
            assert lock.manipulability == pytest.approx(manipulability(rest) / manipulability(J), abs=1e-9)
            np.testing.assert_allclose(lock.singular_values, np.linalg.svd(rest, compute_uv=False), atol=1e-12)
            assert len(lock.lost) == 0


def test_a_planar_arm_of_three_joints_loses_a_direction_with_each():
    arm = sr.arms.planar(3)
    q = np.deg2rad([10.0, 60.0, 120.0])
    J = arm.jacobian(q)
    for i, lock in enumerate(locks(arm, q)):
        assert lock.manipulability == 0.0
        assert lock.lost.shape == (1, 6)
        lost = lock.lost[0]
        assert np.linalg.norm(lost) == pytest.approx(1.0)
        np.testing.assert_allclose(lost @ np.delete(J, i, axis=1), 0.0, atol=1e-12)
        assert abs(lost @ J[:, i]) > 1e-3  # the whole arm served it


def test_an_arm_with_a_spherical_shoulder_and_wrist_never_has_its_elbow_to_spare():
    shoulder = [sr.DHRow(alpha=-np.pi / 2), sr.DHRow(alpha=np.pi / 2), sr.DHRow(d=0.4, alpha=-np.pi / 2)]
    wrist = [sr.DHRow(d=0.4, alpha=np.pi / 2), sr.DHRow(alpha=-np.pi / 2), sr.DHRow()]
    arm = sr.Arm.from_dh([*shoulder, sr.DHRow(alpha=np.pi / 2), *wrist])
    left = survey(arm).typical
    assert left[3] == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.delete(left, 3) > 0.01)


def test_a_direction_in_words():
    assert direction(np.array([0, 0, -1.0, 0, 0, 0.01])) == "vz"
    assert direction(np.array([-0.6, 0, 0, 0, 0.8, 0])) == "0.60 vx - 0.80 wy"
    assert direction(np.array([0.0, 1.0]), rows=(0, 5)) == "wz"


def test_json_holds_the_arm_and_its_singular_values(stillreach):
    found = json.loads(stillreach("inspect", "canadarm2", "--q", "10deg,20deg,0.3,-40deg,0,0.1,0", "--json").out)
    arm = sr.arms.canadarm2()
    q = [np.deg2rad(10), np.deg2rad(20), 0.3, np.deg2rad(-40), 0.0, 0.1, 0.0]
    np.testing.assert_allclose(found["at"]["q"], q, rtol=1e-15)
    np.testing.assert_allclose(found["at"]["singular_values"], np.linalg.svd(arm.jacobian(q), compute_uv=False))
    np.testing.assert_allclose(found["at"]["pose"], arm.forward(q))
    assert [joint["name"] for joint in found["joints"]] == list(arm.joint_names)
    assert found["joints"][0]["velocity_limit"] == pytest.approx(np.deg2rad(4.0))
    assert found["joints"][0]["position_limits"] == pytest.approx([-np.deg2rad(270), np.deg2rad(270)])
    assert json.loads(stillreach("inspect", "planar3", "--json").out)["joints"][0]["position_limits"] == [None, None]


def test_values_by_name_leave_the_others_in_the_middle_of_their_limits(stillreach, tmp_path):
    joint = (
        '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>'
        '<axis xyz="0 0 1"/><limit lower="{4}" upper="{5}" velocity="1"/></joint>'
    )
    slide = joint.format("slide", "prismatic", "a", "b", -0.1, 0.5)
    turn = joint.format("turn", "revolute", "b", "c", 1, 2)
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{links}{slide}{turn}</robot>')
    middle = json.loads(stillreach("inspect", "r.urdf", "--json").out)["at"]["q"]
    assert middle == pytest.approx([0.2, 1.5])
    named = json.loads(stillreach("inspect", "r.urdf", "--json", "--q", "slide=50mm").out)["at"]["q"]
    assert named == pytest.approx([0.05, 1.5])
    held = json.loads(stillreach("inspect", "r.urdf", "--json", "--fixed", "slide=0.3").out)
    assert [entry["name"] for entry in held["joints"]] == ["turn"]
    assert held["at"]["pose"][2][3] == pytest.approx(0.3)


def test_every_arm_of_the_catalogue_can_be_named(stillreach):
    assert {arm.name for arm in BUILT_IN} == set(sr.arms.__all__)
    found = json.loads(stillreach("arms", "--json").out)
    assert {arm["name"] for arm in found["arms"]} == set(sr.arms.__all__)
    assert tuple(scenario["name"] for scenario in found["scenarios"]) == sr.scenario_names()
    assert all(scenario["text"] for scenario in found["scenarios"])


def test_a_joint_with_a_long_name_takes_no_room_from_the_numbers(stillreach, tmp_path):
    (tmp_path / "long.urdf").write_text(sr.arms.canadarm2().to_urdf().replace('"j4"', f'"{"joint_of_an_arm_" * 5}"'))
    done = stillreach("inspect", "long.urdf")
    assert done.out.count(" 4 deg/s\n") == 7
    assert max(map(len, done.out.splitlines())) <= 80


def test_held_joints_are_told_one_by_one_or_with_commas(stillreach, tmp_path):
    (tmp_path / "arm.urdf").write_text(sr.arms.canadarm2().to_urdf())
    one = stillreach("inspect", "arm.urdf", "--json", "--fixed", "j1=90deg", "--fixed", "j3=0.2").out
    other = stillreach("inspect", "arm.urdf", "--json", "--fixed", "j1=90deg, j3=0.2").out
    assert json.loads(one) == json.loads(other)
    assert [joint["name"] for joint in json.loads(one)["joints"]] == ["j2", "j4", "j5", "j6", "j7"]
