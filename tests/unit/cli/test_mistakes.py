"""A user's mistake is one message with advice and exit code 2; a mistake of stillreach has a traceback and code 3."""

import json

import numpy as np
import pytest

import stillreach as sr
from stillreach.simulation import summary

MISTAKES = {
    "no such scenario": ("run", "paper-exampel-2"),
    "no such file": ("run", "nowhere/reach.toml"),
    "a file that is called otherwise": ("run", "raech.toml"),
    "no such law": ("run", "reach.toml", "--law", "last-error"),
    "no such setting": ("run", "reach.toml", "--law", "least-error:gain=2"),
    "a setting twice": ("run", "reach.toml", "--law", "least-error:price=2:price=3"),
    "a setting out of range": ("run", "reach.toml", "--law", "least-error:price=-1"),
    "a price that is another word": ("run", "reach.toml", "--law", "least-error:price=position"),
    "a price of rows that do not exist": ("run", "reach.toml", "--law", "least-error:price=position=1+tilt=2"),
    "a price of rows twice": ("run", "reach.toml", "--law", "least-error:price=position=1+position=2"),
    "a price of a row that is negative": ("run", "reach.toml", "--law", "least-error:price=position=-1+orientation=2"),
    "a row without a price": ("run", "reach.toml", "--law", "least-error:price=orientation=8"),
    "a law twice": ("compare", "reach.toml", "--laws", "least-error,least-error"),
    "no such joint": ("run", "reach.toml", "--fail", "j12"),
    "no such kind of fault": ("run", "reach.toml", "--fail", "j2:hot"),
    "a fault without time": ("run", "reach.toml", "--fail", "j2@"),
    "a fault before the start": ("run", "reach.toml", "--fail", "j2@-1"),
    "a fraction that is no number": ("run", "reach.toml", "--fail", "j2:derated=x"),
    "a held joint that is no number": ("inspect", "canadarm2", "--fixed", "a=x"),
    "a fraction above one": ("run", "reach.toml", "--fail", "j2:derated=2"),
    "another unit": ("run", "reach.toml", "--within", "5s"),
    "too many tolerances": ("run", "reach.toml", "--within", "5mm,1deg,1"),
    "a negative tolerance": ("run", "reach.toml", "--within", "-5mm"),
    "no such arm": ("inspect", "canadarm"),
    "an arm without its size": ("inspect", "planar"),
    "a tip of a built-in arm": ("inspect", "canadarm2", "--tip", "hand"),
    "another number of values": ("inspect", "canadarm2", "--q", "1,2"),
    "no such joint in values": ("inspect", "canadarm2", "--q", "j8=1"),
    "a pair without a value": ("inspect", "canadarm2", "--q", "j2=1,5"),
    "a value that is no number": ("inspect", "canadarm2", "--q", "j2=much"),
    "a file that is no robot": ("inspect", "reach.toml"),
    "an index for a joint": ("run", "reach.toml", "--fail", "4"),
    "an index for a joint in values": ("inspect", "canadarm2", "--q", "2=0.1"),
    "an index that ends no name": ("run", "reach.toml", "--fail", "12@1"),
    "a tolerance without unit": ("run", "reach.toml", "--within", "5"),
    "an angle without unit": ("run", "reach.toml", "--within", "5mm,1"),
    "degrees taken for radians": ("inspect", "canadarm2", "--q", "j2=-45"),
    "several joints outside": ("inspect", "canadarm2", "--q", "5,6,7,8,0,0,0"),
    "no such rows": ("inspect", "canadarm2", "--rows", "positions"),
    "a row twice": ("inspect", "canadarm2", "--rows", "vx,vx"),
    "no such frame": ("inspect", "canadarm2", "--frame", "world"),
    "a least speed of 0": ("inspect", "canadarm2", "--lost-below", "0"),
    "a least speed without unit": ("inspect", "canadarm2", "--lost-below", "1"),
    "a folder that cannot be made": ("run", "reach.toml", "--out", "reach.toml/out"),
    "no such poses": ("reach", "panda", "nowhere.csv"),
    "poses that are no table": ("reach", "panda", "reach.toml"),
    "poses and random ones": ("reach", "panda", "poses.csv", "--samples", "5"),
    "a unit without poses": ("reach", "panda", "--angle", "deg"),
    "a unit that does not exist": ("reach", "panda", "poses.csv", "--length", "mile"),
    "a paper's step": ("paper", "--step", "-1", "--out", "p"),
}
"""Arguments of commands; what they say is in tests/golden/messages.txt."""


@pytest.mark.parametrize("arguments", MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_of_the_user_is_one_message_and_exit_code_2(stillreach, arguments):
    done = stillreach(*arguments)
    assert done.code == 2
    assert done.out == ""
    assert done.err.startswith("stillreach: ")
    assert "Traceback" not in done.err


def test_debug_shows_where_it_was_found_wherever_it_stands(stillreach):
    for arguments in (
        ("--debug", "run", "reach.toml", "--fail", "j12"),
        ("run", "reach.toml", "--fail", "j12", "--debug"),
    ):
        done = stillreach(*arguments)
        assert done.code == 2
        assert "Traceback" in done.err
        assert "\nstillreach: --fail" in done.err


def test_every_mistake_in_a_file_is_told(stillreach, tmp_path):
    (tmp_path / "bad.toml").write_text('start = [0]\nrobot = { arm = "nasa" }\nmotion = []\nperiods = 1\n')
    done = stillreach("run", "bad.toml")
    assert done.code == 2
    for place in ("periods", "robot.arm", "motion"):
        assert place in done.err


def test_a_robot_file_with_several_ends_names_the_option(stillreach, tmp_path):
    joint = '<joint name="j{0}" type="revolute"><parent link="a"/><child link="{0}"/><limit velocity="1"/></joint>'
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    (tmp_path / "two.urdf").write_text(f'<robot name="r">{links}{joint.format("b")}{joint.format("c")}</robot>')
    done = stillreach("inspect", "two.urdf")
    assert done.code == 2
    assert "try --tip b" in done.err
    unknown = stillreach("inspect", "two.urdf", "--tip", "cc")
    assert "did you mean 'c'?" in unknown.err
    assert "try" not in unknown.err


def test_the_tip_that_is_suggested_carries_the_tool_and_no_camera(stillreach, tmp_path):
    """The ends of Baxter's tree begin with a plate on its torso."""
    joint = '<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{0}_end"/><limit velocity="1"/></joint>'
    chains = [("plate", "fixed", "base"), ("pan", "revolute", "base"), ("camera", "fixed", "pan_end")]
    chains += [(f"s{k}", "revolute", f"s{k - 1}_end" if k else "base") for k in range(3)]
    chains += [("left_gripper", "fixed", "s2_end"), ("left_gripper_finger", "revolute", "s2_end")]
    links = "".join(f'<link name="{name}"/>' for name in ("base", *(f"{entry[0]}_end" for entry in chains)))
    joints = "".join(joint.format(*entry) for entry in chains)
    (tmp_path / "tree.urdf").write_text(f'<robot name="r">{links}{joints}</robot>')
    assert "try --tip left_gripper_end\n" in stillreach("inspect", "tree.urdf").err
    (tmp_path / "tree.urdf").write_text(f'<robot name="r">{links}{joints}</robot>'.replace("gripper", "thing"))
    assert "try --tip left_thing_finger_end\n" in stillreach("inspect", "tree.urdf").err


def test_a_joint_may_be_called_by_a_number(stillreach, tmp_path):
    (tmp_path / "arm.urdf").write_text(sr.arms.planar(3).to_urdf().replace('"j3"', '"1"'))
    found = json.loads(stillreach("inspect", "arm.urdf", "--q", "1=30deg", "--json").out)
    assert found["at"]["q"] == pytest.approx([0.0, 0.0, np.deg2rad(30.0)])


def test_values_outside_the_limits_are_taken_where_that_is_meant(stillreach):
    asked = ("inspect", "canadarm2", "--q", "j2=-300deg", "--json")
    assert stillreach(*asked).code == 2
    assert json.loads(stillreach(*asked, "--outside").out)["at"]["q"][1] == pytest.approx(np.deg2rad(-300.0))


def test_a_start_in_degrees_without_units_is_told_with_its_line(stillreach, tmp_path):
    text = (tmp_path / "reach.toml").read_text()
    (tmp_path / "degrees.toml").write_text(
        text.replace('angle = "deg"', 'angle = "rad"') + "position_limits = [-3, 3]\n"
    )
    done = stillreach("run", "degrees.toml")
    assert done.code == 2
    assert "line 3, start[1]: got j2 at -50 rad (-2865 deg), expected a value within its position limits" in done.err
    assert "[units]" in done.err


def test_a_folder_is_called_a_folder(stillreach, tmp_path):
    for name in ("arm.urdf", "arm.toml", "taken/run.nc"):
        (tmp_path / name).mkdir(parents=True)
    robot = stillreach("inspect", "arm.urdf").err
    assert "'arm.urdf', which is a folder" in robot
    assert "did you mean" not in robot
    assert "arm.toml: got a folder" in stillreach("run", "arm.toml").err
    assert (
        stillreach("run", "reach.toml", "--no-plot", "--out", "taken").err
        == "stillreach: taken/run.nc: Is a directory\n"
    )


def test_a_mistake_of_stillreach_keeps_its_traceback(stillreach, monkeypatch):
    monkeypatch.setattr(summary, "status_shares", lambda run: 1 / 0)
    done = stillreach("run", "reach.toml", "--no-plot")
    assert done.code == 3
    assert "ZeroDivisionError" in done.err
    assert "please report it" in done.err


def test_no_memory_is_no_mistake_of_stillreach(stillreach, monkeypatch):
    def refuse(run):
        raise MemoryError("Unable to allocate 1.00 TiB")

    monkeypatch.setattr(summary, "status_shares", refuse)
    done = stillreach("run", "reach.toml", "--no-plot")
    assert done.code == 2
    assert "1.00 TiB" in done.err
    assert "Traceback" not in done.err
