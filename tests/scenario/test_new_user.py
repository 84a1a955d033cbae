"""A new user's path: look at a robot that nobody here wrote, let its elbow fail, compare laws, read what comes out."""

import json
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image

import stillreach as sr
from tests.commands import Answer, run_command

pytestmark = pytest.mark.xdist_group("new user")  # one test goes on where another stopped

PANDA = "cmeel.prefix/share/example-robot-data/robots/panda_description/urdf/panda.urdf"
ELBOW = "panda_joint4"


@pytest.fixture(scope="module")
def desk(tmp_path_factory) -> Path:
    """A folder with panda.urdf in it, as a user has one."""
    folder = tmp_path_factory.mktemp("desk")
    file = distribution("example-robot-data").locate_file(PANDA)
    (folder / "panda.urdf").write_text(Path(str(file)).read_text(encoding="utf-8"), encoding="utf-8")
    return folder


def shell(desk: Path, *arguments: str) -> Answer:
    return run_command(*arguments, folder=desk)


def pixels(file: Path) -> np.ndarray:
    """(height, width, 3) a picture."""
    return image.imread(file)[..., :3]


def shows(picture: np.ndarray, colour: tuple[int, int, int]) -> bool:
    """Whether a patch of a colour is in a picture."""
    return int(np.sum(np.all(np.abs(255 * picture - colour) < 3.0, axis=-1))) > 200


def test_first_the_user_looks_at_the_robot(desk):
    asked = shell(desk, "inspect", "panda.urdf")
    assert asked.code == 2  # two fingers and a tool point: which is the tool?
    assert "try --tip panda_hand_tcp" in asked.err
    done = shell(desk, "inspect", "panda.urdf", "--tip", "panda_hand_tcp")
    assert (done.code, done.err) == (0, "")
    for joint in range(1, 8):
        assert done.out.count(f"panda_joint{joint} ") == 2  # its limits; what is lost with it
    for words in ("7 revolute joints", "-166 … 166 deg", "125 deg/s", "Singular values", "smallest σ", "If one joint"):
        assert words in done.out


def test_the_elbow_is_what_this_robot_can_spare_least(desk):
    done = shell(desk, "inspect", "panda.urdf", "--tip", "panda_hand_tcp", "--json")
    left = {joint["name"]: joint["typical_manipulability_left"] for joint in json.loads(done.out)["joints"]}
    assert min(left, key=left.__getitem__) == ELBOW
    assert left[ELBOW] < 0.1


def test_then_the_elbow_fails(desk):
    done = shell(desk, "run", "panda-elbow")
    assert (done.code, done.err) == (0, "")  # the arm finishes its work
    folder = desk / "out" / "panda-elbow"
    found = json.loads((folder / "summary.json").read_text())
    assert [fault["joint"] for fault in found["faults"]] == [ELBOW]
    assert found["finished"]
    assert found["goal_distance"] < 1e-3
    assert "\narrived          yes, " in done.out
    assert f"{ELBOW} locked from {found['faults'][0]['at']:g} s on" in done.out
    for row in ("arrived", "gave way", "farthest off", "largest rate", "status", "limited by", "lost at the end"):
        assert f"\n{row}" in done.out
    run = sr.Run.load(folder / "run.nc")
    after = run.time > found["faults"][0]["at"]
    assert np.ptp(run.q[after, run.joint_names.index(ELBOW)]) == 0.0
    assert found["largest_rate"]["of_limit"] <= 1.0
    picture = pixels(folder / "run.png")
    assert shows(picture, (0xB3, 0x26, 0x1E))  # the bar of the locked joint


def test_then_laws_are_compared(desk):
    done = shell(desk, "compare", "panda-elbow", "--laws", "least-error,keep-direction,pseudoinverse")
    assert (done.code, done.err) == (0, "")
    folder = desk / "out" / "panda-elbow"
    found = json.loads((folder / "compare.json").read_text())["laws"]
    rows = [line.split()[:2] for line in done.out.splitlines()]
    for law, told in found.items():
        assert [law, "yes" if told["finished"] else "NO"] in rows
    assert found["least-error"] == json.loads((folder / "summary.json").read_text())
    picture = pixels(folder / "compare.png")
    for colour in ((0x1B, 0x4F, 0x8A), (0xC8, 0x50, 0x1E), (0x2F, 0x7D, 0x4F)):
        assert shows(picture, colour)


def test_then_the_wrist_gets_hot_too(desk):
    laws = "least-error,keep-direction,pseudoinverse"
    hot = ("compare", "panda-elbow", "--laws", laws, "--fail", "panda_joint6@2:derated=0.1", "--no-plot")
    done = shell(desk, *hot, "--out", "out/hot")
    found = json.loads((desk / "out" / "hot" / "compare.json").read_text())["laws"]
    for law in ("least-error", "keep-direction"):
        assert found[law]["largest_rate"]["of_limit"] <= 1.0
    assert found["pseudoinverse"]["largest_rate"]["of_limit"] > 1.5  # why one does not use it
    assert "above 100 %: drives cannot follow" in done.out


def test_then_the_user_breaks_another_joint_of_their_own_choice(desk):
    done = shell(desk, "run", "panda-elbow", "--healthy", "--fail", "panda_joint2@1", "--json", "--no-plot")
    found = json.loads(done.out)
    assert [(fault["joint"], fault["at"]) for fault in found["faults"]] == [("panda_joint2", 1.0)]
    healthy = json.loads(shell(desk, "run", "panda-elbow", "--healthy", "--json", "--no-plot").out)
    assert healthy["finished"]
    assert healthy["faults"] == []


def test_what_is_printed_fits_a_terminal_and_a_pipe(desk):
    for arguments in (("inspect", "panda.urdf", "--tip", "panda_hand_tcp"), ("run", "panda-elbow", "--no-plot")):
        lines = shell(desk, *arguments).out.splitlines()
        assert all(len(line) <= 80 for line in lines if not line.startswith("wrote "))
        assert all("\x1b" not in line for line in lines)
