"""The plugin of `ros2/` is built with ament, loaded by pluginlib and called: its numbers are the Python package's.

ROS itself is not there: rclcpp and the base class are stubs (tests/ros2/stubs) with upstream's signatures.
"""

import os
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from cpp_build import ROOT, has_header
from scipy.spatial.transform import Rotation

import stillreach as sr
from tests.robots.catalogue import URDF
from tests.unit.arm.urdf_texts import joint, robot

PACKAGE = ROOT / "ros2" / "kinematics_interface_stillreach"
HERE = ROOT / "tests" / "ros2"
NAME = "kinematics_interface_stillreach/KinematicsInterfaceStillreach"
PLUGINLIB = Path("/usr/share/pluginlib/cmake/pluginlibConfig.cmake")
PERIOD = 0.01
CLOSE = {"rtol": 0.0, "atol": 1e-9}

pytestmark = [
    pytest.mark.timeout(300),
    pytest.mark.skipif(
        not (
            PLUGINLIB.exists() and shutil.which("g++") and has_header("tinyxml2.h") and has_header("eigen3/Eigen/Core")
        ),
        reason="apt-get install pluginlib-dev libroslib-dev libeigen3-dev libtinyxml2-dev",
    ),
]

MINIMAL = robot(
    joint("mount", "world", "base_link", "fixed"),
    joint("joint1", "base_link", "link1", xyz="0 0 0.2", rpy="-1.57079632679 0 0", axis="1 0 0"),
    joint("joint2", "link1", "link2", xyz="0 0 0.9", rpy="1.57079632679 0 0", axis="1 0 0"),
    joint("joint3", "link2", "link3", xyz="0 0 0.9", rpy="1.57079632679 0 0", axis="1 0 0"),
)
LATE_LEADER = robot(
    joint("follower", "a", "b", extra='<mimic joint="leader"/>'),
    joint("leader", "b", "c", xyz="1 0 0"),
    joint("last", "c", "d", xyz="1 0 0", axis="0 1 0"),
)
FAULTS = {
    "locked": sr.Locked(),
    "derated 0.3": sr.Derated(0.3),
    "runaway -0.05": sr.Runaway(-0.05),
    "confined -0.5 0.3": sr.Confined(-0.5, 0.3),
    "one-way -1": sr.OneWay(-1),
    "free-swinging": sr.FreeSwinging(),
}
LOST = ("locked", "runaway -0.05", "free-swinging")
"""Kinds that leave no rate to choose."""


class Answer(NamedTuple):
    """What a call returned, how often it took memory, and its numbers."""

    done: bool
    heap: int
    numbers: np.ndarray


class Plugin:
    """A program that loads the plugin; ``lines`` are what it is told."""

    def __init__(self, driver: Path, prefix: Path, text: str, folder: Path, **parameters) -> None:
        self.driver, self.prefix, self.file = driver, prefix, folder / "robot.urdf"
        self.file.write_text(text, encoding="utf-8")
        self.lines = [f"load\t{NAME}"]
        self.override(**{"tip": "link_eef", **parameters})

    def override(self, prefix: str = "", **parameters) -> None:
        """Parameters of the node's file."""
        self.lines += [f"override\t{prefix}{name}\t{typed(value)}" for name, value in parameters.items()]

    def initialize(self, namespace: str = "", file: bool = True) -> None:
        self.lines.append(f"initialize\t{self.file if file else ''}\t{namespace}")

    def set(self, name: str, *words: str) -> None:
        self.lines.append(f"set\t{name}\tstrings\t{','.join(words)}")

    def call(self, what: str, *arguments) -> None:
        """A call: link, positions, deltas and so on."""
        self.lines.append("\t".join([what, *(a if isinstance(a, str) else numbers(a) for a in arguments)]))

    def run(self) -> list[Answer | str]:
        """An answer for each line but the load; for ``set``, why it was refused."""
        environment = {**os.environ, "AMENT_PREFIX_PATH": str(self.prefix)}
        done = subprocess.run(
            [self.driver], input="\n".join(self.lines), capture_output=True, text=True, check=False, env=environment
        )
        assert done.returncode == 0, done.stderr
        self.messages = done.stderr
        answers = done.stdout.split("\n")[:-1]
        assert len(answers) == len(self.lines)
        return [parsed(*pair) for pair in zip(self.lines, answers, strict=True)][1:]


def typed(value) -> str:
    """A parameter's type and value, as the program reads them."""
    match value:
        case bool():
            return f"bool\t{str(value).lower()}"
        case float():
            return f"double\t{value!r}"
        case str():
            return f"string\t{value}"
    return f"strings\t{','.join(value)}"


def numbers(values) -> str:
    return " ".join(repr(float(value)) for value in np.ravel(values))


def parsed(line: str, answer: str) -> Answer | str:
    if line.startswith("set\t"):
        return answer
    done, heap, *rest = answer.split()
    return Answer(done == "1", int(heap), np.array([float(word) for word in rest]))


@pytest.fixture(scope="module")
def build(tmp_path_factory) -> tuple[Path, Path]:
    """The program, and the prefix where ament installed the plugin."""
    folder = tmp_path_factory.mktemp("ros2")
    prefix, stubs = folder / "install", HERE / "stubs"
    options = [
        *("-G", "Ninja", "-DCMAKE_BUILD_TYPE=None", "-DBUILD_TESTING=OFF", f"-DCMAKE_INSTALL_PREFIX={prefix}"),
        *(f"-Drclcpp_DIR={stubs}", f"-Dkinematics_interface_DIR={stubs}", "-DPython3_EXECUTABLE=/usr/bin/python3"),
    ]

    def both(*commands) -> None:
        running = [
            subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            for command in commands
        ]
        for process in running:
            output, _ = process.communicate()
            assert process.returncode == 0, output

    sources = {"plugin": PACKAGE, "driver": HERE}
    both(*(["cmake", "-S", source, "-B", folder / name, *options] for name, source in sources.items()))
    both(*(["cmake", "--build", folder / name] for name in sources))
    both(["cmake", "--install", folder / "plugin"])
    (prefix / "share/ament_index/resource_index/packages/kinematics_interface").touch()  # a package that ROS installs
    return folder / "driver" / "driver", prefix


@pytest.fixture
def plugin(build, tmp_path):
    """Makes a plugin for a URDF text and parameters."""
    return lambda text, **parameters: Plugin(*build, text, tmp_path, **parameters)


def xarm() -> str:
    return URDF["xArm7"].file.read_text(encoding="utf-8")


def configurations(arm: sr.Arm, count: int = 3) -> np.ndarray:
    return np.random.default_rng(11).uniform(-0.8, 0.8, (count, arm.n))


@pytest.mark.parametrize(
    ("name", "links"),
    [
        ("xArm7", ("link_base", "link1", "link4", "link_eef")),
        ("PR2, with a finger that follows another", ("base_link", "l_forearm_link", "l_gripper_l_finger_tip_link")),
    ],
)
def test_poses_and_jacobians_are_the_python_packages(plugin, name, links):
    one = URDF[name]
    text = one.file.read_text(encoding="utf-8")
    asked = plugin(text, tip=one.tip)
    asked.initialize()
    arm = sr.Arm.from_urdf(text, tip=one.tip)
    expected = []
    for q in configurations(arm):
        for link in links:
            for what in ("transform", "jacobian"):
                asked.call(what, link, q)
            asked.call("to_tool", link, q, np.linspace(-0.3, 0.4, arm.n))
            pose, J = np.eye(4), np.zeros((6, arm.n))
            try:
                part = sr.Arm.from_urdf(text, tip=link)
                pose, J[:, : part.n] = part.forward(q[: part.n]), part.jacobian(q[: part.n])
            except sr.errors.RobotFileError:  # before the first joint
                pose = None
            expected += [(pose, J, J @ np.linspace(-0.3, 0.4, arm.n))]
    _, initialized, *answers = asked.run()
    assert initialized.done
    assert all(answer.done and answer.heap == 0 for answer in answers)
    assert len(answers) == 3 * len(expected)
    for (pose, J, twist), *got in zip(expected, *[iter(answers)] * 3, strict=True):
        if pose is not None:
            np.testing.assert_allclose(got[0].numbers.reshape(4, 4).T, pose, **CLOSE)
        np.testing.assert_allclose(got[1].numbers.reshape(-1, 6).T, J, **CLOSE)
        np.testing.assert_allclose(got[2].numbers, twist, **CLOSE)


@pytest.mark.parametrize("kind", FAULTS)
def test_joint_deltas_are_the_default_laws_and_a_failed_joint_stays(plugin, kind):
    asked = plugin(xarm(), failed_joints=["joint4"], failed_kinds=[kind])
    asked.initialize()
    arm = sr.Arm.from_urdf(xarm(), tip="link_eef")
    twists = [[0.03, -0.02, 0.05, 0.1, 0.0, -0.1], [1.5, 0.5, -1.0, 0.0, 2.0, 0.0]]
    expected = []
    controller = sr.Controller(arm, period=PERIOD)
    controller.fail("joint4", FAULTS[kind])
    for q in configurations(arm):
        for twist in twists:
            asked.call("to_joints", "link_eef", q, np.multiply(twist, PERIOD))
            expected.append(PERIOD * controller.step(q, twist).rates)
    *_, initialized, a, b, c, d, e, f = asked.run()
    assert initialized.done
    for answer, deltas in zip((a, b, c, d, e, f), expected, strict=True):
        assert (answer.done, answer.heap) == (True, 0)
        np.testing.assert_allclose(answer.numbers, deltas, **CLOSE)
        assert np.all(np.abs(answer.numbers) <= PERIOD * arm.velocity_limits)
        if kind in ("locked", "free-swinging"):
            assert answer.numbers[3] == 0.0
    assert max(np.abs(deltas).max() for deltas in expected) > 0.9 * PERIOD * arm.velocity_limits.min()


@pytest.mark.parametrize("kind", [None, *FAULTS])
def test_the_inverse_is_that_of_the_working_joints(plugin, kind):
    given = {"failed_joints": ["joint2", "joint6"], "failed_kinds": [kind]} if kind else {}
    lost = [i for i, which in ((1, kind), (5, kind and "locked")) if which in LOST]
    asked = plugin(xarm(), **given)
    asked.initialize()
    arm = sr.Arm.from_urdf(xarm(), tip="link_eef")
    working = [i for i in range(arm.n) if i not in lost]
    q = configurations(arm)
    for row in q:
        asked.call("inverse", "link_eef", row)
    (*answers,) = (answer for answer in asked.run()[-len(q) :])
    for row, answer in zip(q, answers, strict=True):
        assert (answer.done, answer.heap) == (True, 0)
        inverse = answer.numbers.reshape(6, arm.n).T
        np.testing.assert_allclose(
            inverse[working], np.linalg.pinv(arm.jacobian(row)[:, working]), rtol=1e-9, atol=1e-9
        )
        assert np.all(inverse[lost] == 0.0)


def test_without_limits_deltas_are_linear(plugin):
    asked = plugin(xarm(), limits=False, failed_joints=["joint3"])
    asked.initialize()
    arm = sr.Arm.from_urdf(xarm(), tip="link_eef")
    q, delta = configurations(arm, 1)[0], np.array([3.0, -2.0, 1.0, 0.5, 0.0, 2.0])
    asked.call("to_joints", "link_eef", q, delta)
    asked.call("to_joints", "link_eef", q, 10.0 * delta)
    *_, once, tenfold = asked.run()
    working = [0, 1, 3, 4, 5, 6]
    np.testing.assert_allclose(once.numbers[working], np.linalg.solve(arm.jacobian(q)[:, working], delta), rtol=1e-9)
    np.testing.assert_allclose(tenfold.numbers, 10.0 * once.numbers, rtol=1e-12)
    assert once.numbers[2] == 0.0


def test_failed_joints_change_while_the_controller_runs(plugin):
    asked = plugin(xarm())
    asked.initialize("")
    arm = sr.Arm.from_urdf(xarm(), tip="link_eef")
    call = "to_joints", "link_eef", configurations(arm, 1)[0], [2e-4, 0.0, 1e-4, 0.0, 0.0, 0.0]
    asked.call(*call)
    asked.set("failed_joints", "joint3")
    asked.call(*call)
    asked.set("failed_joints", "joint3", "elbow")
    asked.set("failed_kinds", "wobbly")
    asked.set("failed_kinds", "derated 2")
    asked.set("failed_kinds", "one-way", "locked")
    asked.call(*call)
    asked.set("failed_kinds", "free-swinging")
    asked.set("other", "thing")
    asked.call(*call)
    asked.call("inverse", *call[1:3])
    asked.set("failed_kinds")
    asked.set("failed_joints")
    for _ in range(100):  # the law takes half a second to return to what it does with all joints
        asked.call(*call)
    _, _, healthy, first, locked, elbow, wobbly, derated, many, still, kind, other, swinging, inverse, *_, restored = (
        asked.run()
    )
    assert healthy.numbers[2] != 0.0
    assert first == kind == other == ""
    assert "got 'elbow', expected joints of the chain: joint1, joint2" in elbow
    assert "failed_kinds: got 'wobbly', expected one of locked" in wobbly
    assert "got 'derated 2'" in derated
    assert "failed_kinds: got 2, expected at most one for each of the 1 failed_joints" in many
    for answer in (locked, still, swinging):
        assert (answer.done, answer.heap, answer.numbers[2]) == (True, 0, 0.0)
        np.testing.assert_allclose(arm.jacobian(call[2]) @ answer.numbers, call[3], **CLOSE)
    working = [0, 1, 3, 4, 5, 6]
    exact = np.linalg.pinv(arm.jacobian(call[2])[:, working])
    np.testing.assert_allclose(inverse.numbers.reshape(6, 7).T[working], exact, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(restored.numbers, healthy.numbers, rtol=1e-9)


@pytest.mark.parametrize(
    ("parameters", "part"),
    [
        ({"tip": ""}, "tip: got none"),
        ({"tip": "unknown"}, "tip: got 'unknown', expected a link of the file: world, base_link"),
        ({"tip": "link2", "base": "unknown"}, "base: got 'unknown'"),
        ({"tip": "world"}, "no joint that moves"),
        ({"tip": "link3", "period": 0.0}, "period"),
        ({"tip": "link3", "period": "fast"}, "another type"),
        ({"tip": "link3", "failed_joints": ["joint9"]}, "failed_joints: got 'joint9'"),
        ({"tip": "link3", "failed_joints": ["joint1"], "failed_kinds": ["confined 1 0"]}, "got 'confined 1 0'"),
    ],
)
def test_wrong_parameters_are_refused_and_right_ones_taken_after(plugin, parameters, part):
    asked = plugin(MINIMAL, **parameters)
    asked.initialize()
    asked.call("transform", "link1", [0, 0, 0])
    asked.lines.append(f"load\t{NAME}")
    asked.override(tip="link1", base="link2")
    asked.initialize()
    asked.call("jacobian", "link1", [0.4])
    answers = asked.run()
    refused, call = answers[-7:-5]
    assert not refused.done
    assert not call.done
    assert part in asked.messages
    assert "initialize() was not called, or failed" in asked.messages
    expected = sr.Arm.from_urdf(MINIMAL, tip="link1", base="link2").jacobian([0.4])
    np.testing.assert_allclose(answers[-1].numbers, expected[:, 0], **CLOSE)


def test_the_description_and_the_namespace_are_parameters_of_the_node(plugin):
    asked = plugin(MINIMAL)
    asked.override("kinematics.", tip="link3", failed_joints=["joint1"])
    asked.initialize("kinematics")
    asked.call("inverse", "link3", [0.1, 0.2, 0.3])
    asked.initialize("kinematics", file=False)
    asked.call("inverse", "link3", [0.1, 0.2, 0.3])
    *_, first, inverse, without, after = asked.run()
    assert first.done
    assert np.all(inverse.numbers.reshape(6, 3)[:, 0] == 0.0)
    assert inverse.numbers.any()
    assert not without.done
    assert not after.done
    assert "robot_description: got none" in asked.messages


def test_wrong_sizes_links_and_numbers_are_refused(plugin):
    asked = plugin(MINIMAL, tip="link3")
    asked.initialize()
    q, delta, five = [0.1, 0.2, 0.3], [0, 0, 1e-4, 0, 0, 0], [0.0] * 5
    for what in ("transform", "jacobian", "inverse"):
        asked.call(what, "link3", five)
        asked.call(what, "link_not_in_model", q)
    for what in ("jacobian", "inverse"):
        asked.call(what, "link3", q, "", "5")
    asked.call("to_joints", "link3", five, delta)
    asked.call("to_joints", "link_not_in_model", q, delta)
    asked.call("to_joints", "link3", q, delta, "5")
    asked.call("to_tool", "link3", q, five)
    asked.call("to_tool", "link_not_in_model", q, q)
    asked.call("to_joints", "link3", [0.1, np.nan, 0.3], delta)
    asked.call("inverse", "link3", [0.1, np.inf, 0.3])
    asked.call("to_joints", "link3", q, [0, np.nan, 0, 0, 0, 0])
    for dt in ("-0.1", "0", "nan"):
        asked.call("differ", [*five, 0, 1], [*five, 0, 1], dt)
    asked.call("differ", [0.0] * 7, [*five, 0, 1], "1")
    asked.call("transform", "link3", q)
    _, initialized, *refused, last = asked.run()
    assert initialized.done
    assert not any(answer.done for answer in refused)
    braking = refused[len(refused) - 7]
    assert braking.numbers.tolist() == [0.0, 0.0, 0.0]
    assert last.done


def test_a_joint_that_follows_a_later_one_takes_the_links_between_from_the_model(plugin):
    asked = plugin(LATE_LEADER, tip="d")
    asked.initialize()
    asked.call("transform", "b", [0.3, 0.1])
    asked.call("jacobian", "c", [0.3, 0.1])
    _, initialized, between, behind = asked.run()
    assert initialized.done
    assert not between.done
    assert "link b is left out" in asked.messages
    expected = np.zeros((6, 2))
    expected[:, 0] = sr.Arm.from_urdf(LATE_LEADER, tip="c").jacobian([0.3])[:, 0]
    np.testing.assert_allclose(behind.numbers.reshape(2, 6).T, expected, **CLOSE)


def test_the_difference_of_frames_is_a_twist(plugin):
    asked = plugin(MINIMAL, tip="link3")
    rng = np.random.default_rng(3)
    expected = []
    pairs = [([0, 1, 0, 0, 0, 0, 1], [2, 3, 0, 0, 1, 0, 0], 1.0)]
    for _ in range(20):
        a, b = rng.normal(size=7), rng.normal(size=7)
        pairs += [(a, b, 0.25), (a, [*b[:3], *-a[3:]], 0.5)]
    for a, b, dt in pairs:
        asked.call("differ", a, b, repr(dt))
        turn = Rotation.from_quat(b[3:]) * Rotation.from_quat(a[3:]).inv()
        expected.append([*(np.subtract(b[:3], a[:3]) / dt), *(turn.as_rotvec() / dt)])
    for answer, twist in zip(asked.run()[1:], expected, strict=True):
        assert (answer.done, answer.heap) == (True, 0)
        np.testing.assert_allclose(answer.numbers, twist, rtol=0.0, atol=1e-7)


def test_the_package_names_what_it_holds():
    package = ET.parse(PACKAGE / "package.xml").getroot()
    assert package.findtext("name") == PACKAGE.name
    (plugin,) = ET.parse(PACKAGE / f"{PACKAGE.name}.xml").getroot().findall("class")
    assert (plugin.get("name"), plugin.get("type")) == (NAME, NAME.replace("/", "::"))
