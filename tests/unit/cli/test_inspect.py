"""What `stillreach inspect` tells of an arm, against plain linear algebra."""

import io
import json
import os
import subprocess
import sys

import numpy as np
import pytest

import stillreach as sr
from stillreach.cli._locks import Gauge, direction, insight, locks, survey
from tests.unit.arm.urdf_texts import joint, robot


def manipulability(J):
    return np.prod(np.linalg.svd(J, compute_uv=False))


@pytest.mark.parametrize("name", ["canadarm2", "nasa_modular", "snake9"])
def test_what_is_left_without_a_joint_is_the_ratio_of_manipulabilities(name):
    arm = sr.arms.by_name(name).with_limits(velocity=1.0)
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


def elbow_arm(right_angle=np.pi / 2):
    """Spherical shoulder, elbow, spherical wrist, with right angles as a file writes them."""
    shoulder = [sr.DHRow(alpha=-right_angle), sr.DHRow(alpha=right_angle), sr.DHRow(d=0.4, alpha=-right_angle)]
    wrist = [sr.DHRow(d=0.4, alpha=right_angle), sr.DHRow(alpha=-right_angle), sr.DHRow()]
    return sr.Arm.from_dh([*shoulder, sr.DHRow(alpha=right_angle), *wrist])


RIGHT_ANGLES = pytest.mark.parametrize("right_angle", [np.pi / 2, 1.5708, 1.571])
Q = [0.3, -0.9, 0.5, 1.4, -0.7, 1.1, 0.2]


@RIGHT_ANGLES
def test_an_arm_with_a_spherical_shoulder_and_wrist_never_has_its_elbow_to_spare(right_angle):
    left = survey(elbow_arm(right_angle)).typical
    assert left[3] == 0.0
    assert np.all(np.delete(left, 3) > 0.01)


@RIGHT_ANGLES
def test_rounding_in_a_file_is_not_motion(right_angle):
    """The direction is that of the exact arm: the forces through shoulder and wrist, along the line between them."""
    lost = locks(elbow_arm(right_angle), np.array(Q))[3].lost
    wrist = elbow_arm().forward(Q)[:3, 3]
    expected = np.concatenate([wrist / np.linalg.norm(wrist), np.zeros(3)])
    assert lost.shape == (1, 6)
    assert abs(lost[0] @ expected) == pytest.approx(1.0, abs=1e-4)


def test_what_counts_as_lost_is_what_full_rates_give():
    """Two slides along x: without the faster one the slower one is left."""
    slides = [
        sr.Joint(name="fast", kind="prismatic", axis=[1, 0, 0]),
        sr.Joint(name="slow", kind="prismatic", axis=[1, 0, 0]),
    ]
    for slow, lost in ((0.9e-3, 1), (1.1e-3, 0)):
        arm = sr.Arm(slides).with_limits(velocity=[0.5, slow])
        assert len(locks(arm, np.zeros(2))[0].lost) == lost
        assert len(locks(arm, np.zeros(2), Gauge(speed=slow / 2))[0].lost) == 0
        assert len(locks(arm, np.zeros(2), Gauge(speed=2 * slow))[0].lost) == 1
        assert len(locks(arm, np.zeros(2))[1].lost) == 0


@pytest.mark.parametrize(("limit", "lost"), [(0.09, 1), (0.11, 0), (np.inf, 0)])
def test_a_turn_counts_from_a_tenth_of_a_degree_a_second(limit, lost):
    turns = [sr.Joint(name="a", axis=[0, 0, 1]), sr.Joint(name="b", axis=[0, 0, 1])]
    arm = sr.Arm(turns).with_limits(velocity=[1.0, np.deg2rad(limit)])
    found = locks(arm, np.zeros(2), Gauge(task=sr.Task(rows="orientation")))
    assert [len(lock.lost) for lock in found] == [lost, 0]


def test_a_joint_that_cannot_move_takes_nothing_away():
    arm = sr.arms.planar(4).with_limits(velocity=[1.0, 1.0, 1.0, 0.0])
    task = Gauge(task=sr.Task(rows="position"))
    found = locks(arm, np.array([0.3, 0.8, -0.5, 0.9]), task)
    assert found[3].manipulability == pytest.approx(1.0)
    whole = locks(sr.arms.planar(4), np.array([0.3, 0.8, -0.5, 0.9]), task)
    assert found[0].manipulability < whole[0].manipulability


@pytest.mark.parametrize("frame", ["base", "tool"])
def test_a_task_of_fewer_rows_loses_less(frame):
    arm, q = sr.arms.canadarm2(), np.array([0.3, 0.8, -0.5, 0.9, 0.4, -0.7, 0.2])
    R = arm.forward(q)[:3, :3] if frame == "tool" else np.eye(3)
    J = (R.T @ arm.jacobian(q)[:3])[[0, 2]]
    gauge = Gauge(task=sr.Task(rows=[True, False, True, False, False, False], frame=frame))
    for i, lock in enumerate(locks(arm, q, gauge)):
        rest = np.delete(J, i, axis=1)
        assert lock.manipulability == pytest.approx(manipulability(rest) / manipulability(J), abs=1e-9)
        assert lock.rank == 2


def test_the_default_pose_is_the_most_dexterous_of_a_sample():
    arm = sr.arms.canadarm2()  # all joints have the same rate limit
    best = survey(arm).best
    lower, upper = arm.position_limits.T
    sample = np.random.default_rng(1994).uniform(lower, upper, (200, 7))
    np.testing.assert_array_equal(best, max(sample, key=lambda q: manipulability(arm.jacobian(q))))


def test_the_verdict_names_the_joint_that_can_be_spared_least(stillreach, tmp_path):
    (tmp_path / "arm.urdf").write_text(elbow_arm(1.5708).to_urdf())
    printed = " ".join(stillreach("inspect", "arm.urdf").out.split())
    assert printed.endswith(
        "What this arm can spare least is j4: without it the tool loses a direction over most of the range."
    )
    found = json.loads(stillreach("inspect", "arm.urdf", "--json").out)
    assert found["least_spared"] == "j4"
    assert found["verdict"] in printed
    assert " no joint" in json.loads(stillreach("inspect", "planar3", "--json").out)["verdict"]
    spared = json.loads(stillreach("inspect", "arm.urdf", "--rows", "orientation", "--json").out)
    assert "a median of " in spared["verdict"]
    assert all(lock["lost_directions"] == [] for lock in spared["at"]["locked"])


def test_a_pose_in_which_joints_cannot_be_spared_is_told_beside_the_verdict(stillreach):
    folded = json.loads(stillreach("inspect", "canadarm2", "--q", "middle", "--json").out)
    lost = [lock["joint"] for lock in folded["at"]["locked"] if lock["lost_directions"]]
    assert lost == ["j2", "j6"]
    assert folded["verdict"].endswith(" Here it cannot spare j2 or j6.")


def test_options_say_what_the_task_is_and_what_counts(stillreach):
    asked = ("inspect", "planar4", "--json", "--q", "middle")
    found = json.loads(stillreach(*asked, "--rows", "vx,vy,wz", "--lost-below", "2mm/s,1deg/s").out)
    assert found["task"] == {"rows": ["vx", "vy", "wz"], "frame": "base"}
    assert found["lost_below"] == pytest.approx([2e-3, np.deg2rad(1.0)])
    assert found["at"]["rank"] == 2  # stretched out along x
    turned = json.loads(stillreach(*asked, "--rows", "position", "--frame", "tool").out)
    assert turned["task"] == {"rows": ["vx", "vy", "vz"], "frame": "tool"}
    printed = stillreach("inspect", "planar4", "--rows", "position").out
    assert "The task is vx, vy, vz." in printed
    assert "can move in 2 of 3 directions" in printed


def test_a_little_that_is_left_is_not_called_nothing():
    """2 mm/s of 20 m/s: not lost, and not 0 %."""
    slides = [sr.Joint(name="fast", kind="prismatic", axis=[1, 0, 0]), sr.Joint(name="turn", axis=[0, 0, 1])]
    tool = np.eye(4)
    tool[1, 3] = 1e-3
    arm = sr.Arm(slides, tool=tool).with_limits(velocity=[20.0, 2.0])
    found = insight(arm, np.zeros(2), survey(arm), Gauge(task=sr.Task(rows=[True] + [False] * 5)))
    assert len(found.locks[0].lost) == 0
    assert 0.0 < found.locks[0].manipulability < 2e-3


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
    middle = json.loads(stillreach("inspect", "r.urdf", "--q", "middle", "--json").out)["at"]["q"]
    assert middle == pytest.approx([0.2, 1.5])
    named = json.loads(stillreach("inspect", "r.urdf", "--json", "--q", "slide=50mm").out)["at"]["q"]
    assert named == pytest.approx([0.05, 1.5])
    held = json.loads(stillreach("inspect", "r.urdf", "--json", "--fixed", "slide=0.3").out)
    assert [entry["name"] for entry in held["joints"]] == ["turn"]
    assert held["at"]["pose"][2][3] == pytest.approx(0.3)


def test_every_arm_of_the_catalogue_can_be_named(stillreach):
    found = json.loads(stillreach("arms", "--json").out)
    assert {arm["name"] for arm in found["arms"]} == set(sr.arms.BUILDERS)
    assert all(arm["joints"] == sr.arms.by_name(arm["name"]).n for arm in found["arms"] if not arm["sized"])
    assert tuple(scenario["name"] for scenario in found["scenarios"]) == sr.scenario_names()
    assert all(scenario["text"] for scenario in found["scenarios"])


def test_a_robot_by_name_needs_no_file(stillreach):
    hand = ("inspect", "panda", "--tip", "panda_hand_tcp", "--q", "zero", "--json")
    found = json.loads(stillreach(*hand).out)
    assert found["at"]["pose"][2][3] == pytest.approx(0.333 + 0.316 + 0.384 - 0.2104)
    assert [joint["name"] for joint in found["joints"]] == [f"panda_joint{k}" for k in range(1, 8)]
    assert "panda_joint4" in found["verdict"]
    done = stillreach("inspect", "panda", "--tip", "hand")
    assert done.code == 2
    assert "--tip: got 'hand', expected one of panda_link8, panda_hand_tcp" in done.err
    listed = stillreach("arms").out
    assert "Franka Emika" in listed
    assert "planarN" in listed


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


URDF = robot(joint("j", "a", "b"), joint("k", "b", "c", "continuous"))
MJCF = """<!-- <robot> --><mujoco model="m"><worldbody><body name="b"><joint name="j"/><geom size=".1"/></body>
</worldbody></mujoco>"""


def given(monkeypatch, data):
    """Bytes as standard input of this process."""
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))


def test_a_robot_comes_by_standard_input():
    command = [sys.executable, "-m", "stillreach", "inspect", "/dev/stdin", "--json"]
    done = subprocess.run(command, input=URDF.encode(), capture_output=True, check=True)
    assert [joint["name"] for joint in json.loads(done.stdout)["joints"]] == ["j", "k"]


@pytest.mark.parametrize("folder", ["/dev/fd", "/proc/self/fd"])
def test_a_robot_comes_by_a_pipe_that_the_shell_opened(stillreach, folder):
    read, write = os.pipe()
    os.write(write, URDF.encode())
    os.close(write)
    try:
        found = json.loads(stillreach("inspect", f"{folder}/{read}", "--json").out)
    finally:
        os.close(read)
    assert [joint["name"] for joint in found["joints"]] == ["j", "k"]


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_robot_is_told_by_what_is_in_it(stillreach, monkeypatch, encoding, tmp_path):
    for text, names in ((URDF, ["j", "k"]), (MJCF.replace("<robot>", ""), ["j"])):
        (tmp_path / "robot.xml").write_bytes(text.encode(encoding))
        given(monkeypatch, text.encode(encoding))
        for source in ("robot.xml", "-"):
            found = json.loads(stillreach("inspect", source, "--json").out)
            assert [joint["name"] for joint in found["joints"]] == names


@pytest.mark.parametrize(
    ("data", "part"),
    [
        (URDF.replace("revolute", "revolt").encode(), "<stdin>, line 6, joint 'j': got 'revolt'"),
        (b"", "<stdin>, line 1: got no element found"),
        (URDF.replace("revolute", "floating").encode(), "try --base b"),
    ],
)
def test_a_mistake_in_standard_input_is_told(stillreach, monkeypatch, data, part):
    given(monkeypatch, data)
    done = stillreach("inspect", "-")
    assert (done.code, done.out) == (2, "")
    assert part in done.err


def test_a_standard_input_that_is_closed_is_told(stillreach, monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)
    done = stillreach("inspect", "-")
    assert done.code == 2
    assert "'-', which cannot be read (it is closed)" in done.err
    assert "/dev/fd/99" in stillreach("inspect", "/dev/fd/99").err
