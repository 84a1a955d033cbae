"""A user's mistake is one message with advice and exit code 2; a mistake of stillreach has a traceback and code 3."""

import json

import numpy as np
import pytest

import stillreach as sr
from stillreach.simulation import summary

MISTAKES = {
    "no such scenario": (("run", "paper-exampel-2"), "paper-example-2"),
    "no such file": (("run", "nowhere/reach.toml"), "nowhere/reach.toml"),
    "a file that is called otherwise": (
        ("run", "raech.toml"),
        "stillreach: raech.toml: no such file, expected a scenario file (TOML, UTF-8) (did you mean 'reach.toml'?)",
    ),
    "no such law": (("run", "reach.toml", "--law", "last-error"), "did you mean 'least-error'?"),
    "no such setting": (("run", "reach.toml", "--law", "least-error:gain=2"), "price"),
    "a setting twice": (("run", "reach.toml", "--law", "least-error:price=2:price=3"), "once"),
    "a setting out of range": (("run", "reach.toml", "--law", "least-error:price=-1"), "above 0"),
    "a price that is another word": (
        ("run", "reach.toml", "--law", "least-error:price=position"),
        "'position-first' or prices by rows",
    ),
    "a price of rows that do not exist": (
        ("run", "reach.toml", "--law", "least-error:price=position=1+tilt=2"),
        "names of rows (vx vy vz wx wy wz)",
    ),
    "a price of rows twice": (
        ("run", "reach.toml", "--law", "least-error:price=position=1+position=2"),
        "each name once",
    ),
    "a price of a row that is negative": (
        ("run", "reach.toml", "--law", "least-error:price=position=-1+orientation=2"),
        "above 0",
    ),
    "a row without a price": (
        ("run", "reach.toml", "--law", "least-error:price=orientation=8"),
        "no price for the row v",
    ),
    "a law twice": (("compare", "reach.toml", "--laws", "least-error,least-error"), "once"),
    "no such joint": (("run", "reach.toml", "--fail", "j12"), "j1 … j11"),
    "no such kind of fault": (("run", "reach.toml", "--fail", "j2:hot"), "derated=FRACTION"),
    "a fault without time": (("run", "reach.toml", "--fail", "j2@"), "JOINT@SECONDS"),
    "a fault before the start": (("run", "reach.toml", "--fail", "j2@-1"), "0 s or later"),
    "a fraction that is no number": (("run", "reach.toml", "--fail", "j2:derated=x"), "got 'x', expected a number"),
    "a held joint that is no number": (
        ("inspect", "canadarm2", "--fixed", "a=x"),
        "expected a number, bare or with rad or deg or m or cm or mm or in or ft\n",
    ),
    "a fraction above one": (("run", "reach.toml", "--fail", "j2:derated=2"), "0 to 1"),
    "another unit": (("run", "reach.toml", "--within", "5s"), "mm"),
    "too many tolerances": (("run", "reach.toml", "--within", "5mm,1deg,1"), "5mm,1deg"),
    "a negative tolerance": (("run", "reach.toml", "--within", "-5mm"), "at least 0"),
    "no such arm": (("inspect", "canadarm"), "did you mean 'canadarm2'?"),
    "an arm without its size": (("inspect", "planar"), "planar7"),
    "a tip of a built-in arm": (("inspect", "canadarm2", "--tip", "hand"), "--tip"),
    "another number of values": (("inspect", "canadarm2", "--q", "1,2"), "7 numbers"),
    "no such joint in values": (("inspect", "canadarm2", "--q", "j8=1"), "j1 … j7"),
    "a pair without a value": (("inspect", "canadarm2", "--q", "j2=1,5"), "joint=value"),
    "a value that is no number": (("inspect", "canadarm2", "--q", "j2=much"), "deg"),
    "a file that is no robot": (("inspect", "reach.toml"), "reach.toml"),
    "an index for a joint": (
        ("run", "reach.toml", "--fail", "4"),
        "the name of a joint: j1 … j11 (did you mean 'j4'?)",
    ),
    "an index for a joint in values": (("inspect", "canadarm2", "--q", "2=0.1"), "did you mean 'j2'?"),
    "an index that ends no name": (("run", "reach.toml", "--fail", "12@1"), "the name of a joint: j1 … j11\n"),
    "a tolerance without unit": (("run", "reach.toml", "--within", "5"), "a number with a unit: m, cm, mm, in"),
    "an angle without unit": (("run", "reach.toml", "--within", "5mm,1"), "a number with a unit: rad, deg"),
    "degrees taken for radians": (
        ("inspect", "canadarm2", "--q", "j2=-45"),
        (
            "--q: got j2 at -45 rad (-2578 deg), expected a value within its position limits, -4.712 … 4.712 rad "
            "(-270 … 270 deg); a bare number is in rad or m, as in files without [units]: -45deg, 50mm; --outside "
        ),
    ),
    "several joints outside": (("inspect", "canadarm2", "--q", "5,6,7,8,0,0,0"), "j1 at 5 rad (286.5 deg) and j2 at "),
    "no such rows": (("inspect", "canadarm2", "--rows", "positions"), "pose, position, orientation"),
    "a row twice": (("inspect", "canadarm2", "--rows", "vx,vx"), "vx,vy,wz"),
    "no such frame": (("inspect", "canadarm2", "--frame", "world"), "base or tool"),
    "a least speed of 0": (("inspect", "canadarm2", "--lost-below", "0"), "above 0"),
    "a least speed without unit": (("inspect", "canadarm2", "--lost-below", "1"), "mm"),
    "a folder that cannot be made": (("run", "reach.toml", "--out", "reach.toml/out"), "reach.toml"),
    "a paper's step": (("paper", "--step", "-1", "--out", "p"), "step"),
}


@pytest.mark.parametrize(("arguments", "advice"), MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_of_the_user_is_told_in_a_message_with_advice(stillreach, arguments, advice):
    done = stillreach(*arguments)
    assert done.code == 2
    assert done.out == ""
    assert done.err.startswith("stillreach: ")
    assert advice in done.err
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
