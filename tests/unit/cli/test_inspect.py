"""What `stillreach inspect` prints of an arm."""

import io
import json
import os
import subprocess
import sys

import numpy as np
import pytest

import stillreach as sr
from tests.commands import run_command
from tests.unit.arm.test_losses import elbow_arm
from tests.unit.arm.urdf_texts import joint, robot


def test_the_verdict_names_the_joint_that_can_be_spared_least(stillreach, tmp_path):
    (tmp_path / "arm.urdf").write_text(elbow_arm(1.5708).to_urdf())
    printed = " ".join(stillreach("inspect", "arm.urdf").out.split())
    assert printed.endswith(
        "The most critical joint is j4: without it the tool loses a direction over most of the range."
    )
    found = json.loads(stillreach("inspect", "arm.urdf", "--json").out)
    assert found["least_spared"] == "j4"
    assert found["verdict"] in printed
    assert "Every joint is critical" in json.loads(stillreach("inspect", "planar3", "--json").out)["verdict"]
    spared = json.loads(stillreach("inspect", "arm.urdf", "--rows", "orientation", "--json").out)
    assert "the median remaining" in spared["verdict"]
    assert all(lock["lost_directions"] == [] for lock in spared["at"]["locked"])


def test_a_pose_in_which_joints_cannot_be_spared_is_told_beside_the_verdict(stillreach):
    folded = json.loads(stillreach("inspect", "canadarm2", "--q", "middle", "--json").out)
    lost = [lock["joint"] for lock in folded["at"]["locked"] if lock["lost_directions"]]
    assert lost == ["j2", "j6"]
    assert folded["verdict"].endswith(" Here the loss of j2 or j6 costs a direction.")


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


def test_sets_of_joints_on_request():
    answer = run_command("inspect", "nasa_modular", "--q", "zero", "--together", "2")
    assert "If up to 2 joints are locked there:" in answer.out
    found = json.loads(run_command("inspect", "panda", "--together", "2", "--json").out)["together"]
    arm = sr.arms.panda()
    q = json.loads(run_command("inspect", "panda", "--json").out)["at"]["q"]
    report = sr.tolerance.report(arm, q)
    assert [tuple(worst["joints"]) for worst in found["worst"]] == [report.worst(size)[0] for size in (1, 2)]
    assert found["worst"][0]["relative_manipulability"] == pytest.approx(report.relative[0].min())
    assert found["guaranteed_speed"] == pytest.approx(report.speed)
    assert run_command("inspect", "panda", "--together", "9").code == 2
