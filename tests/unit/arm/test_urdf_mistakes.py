"""URDF files that are wrong, hostile or unsuitable: one error, with file, line, element and choices."""

import os
import time

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.urdf_texts import joint, robot

GOOD = robot(joint("shoulder", "base", "upper"), joint("elbow", "upper", "hand"))
URDF_1_1, URDF_1_2 = (GOOD.replace("<robot ", f'<robot version="{version}" ') for version in ("1.1", "1.2"))


def refused(text, **asked):
    """The error, which came soon and can be shown in little room."""
    before = time.process_time()
    with pytest.raises(sr.errors.RobotFileError) as caught:
        sr.Arm.from_urdf(text, **asked)
    assert time.process_time() - before < 2.0  # on a busy machine
    assert len(str(caught.value)) < 3000
    return caught.value


MISTAKES = {
    # what is wrong: (text, line, element, part of the message)
    "no XML": ("<robot", 1, None, "unclosed token"),
    "not closed": ('<robot name="a">\n<link name="b">\n</robot>', 3, None, "mismatched tag"),
    "another root": ("<sdf/>", 1, None, "got <sdf>, expected <robot>"),
    "MJCF": ("<mujoco/>", 1, None, "Arm.from_mjcf"),
    "no link": ('<robot name="a"/>', 1, "<robot>", "at least one <link>"),
    "a link without a name": ("<robot>\n<link/></robot>", 2, "<link>", "no name"),
    "two links of one name": ('<robot><link name="a"/>\n<link name="a"/></robot>', 2, "link 'a'", "in line 1"),
    "two joints of one name": (GOOD.replace("elbow", "shoulder"), 7, "joint 'shoulder'", "in line 6"),
    "no parent": (GOOD.replace('<parent link="upper"/>', ""), 7, "joint 'elbow'", "no parent link"),
    "no child": (GOOD.replace('<child link="hand"/>', "<child/>"), 7, "joint 'elbow'", "no child link"),
    "two parent elements": (
        GOOD.replace('<parent link="upper"/>', '<parent link="upper"/><parent link="base"/>'),
        7,
        "joint 'elbow'",
        "2 <parent> that differ",
    ),
    "a link that is not there": (
        GOOD.replace('parent link="upper"', 'parent link="Uper"'),
        7,
        "joint 'elbow'",
        "'upper'?",
    ),
    "two parents": (robot(joint("j", "a", "c"), joint("k", "b", "c")), 7, "joint 'k'", "child of joint 'j'"),
    "a loop": (robot(joint("j", "a", "a")), 4, "joint 'j'", "a cycle"),
    "a cycle": (robot(joint("j", "a", "b"), joint("k", "b", "c"), joint("l", "c", "a")), 8, "joint 'l'", "a cycle"),
    "a cycle beside a tree": (
        robot(joint("j", "a", "b"), joint("k", "c", "d"), joint("l", "d", "c")),
        9,
        "joint 'l'",
        "a cycle",
    ),
    "two trees": (robot(joint("j", "a", "b"), joint("k", "c", "d")), None, None, "2 links without a parent: 'a', 'c'"),
    "a floating joint": (
        GOOD.replace('"revolute"', '"floating"', 1),
        6,
        "joint 'shoulder'",
        "base: got the type 'floating' between base and tip, expected a chain on one side of it: base='upper' begins",
    ),
    "an unknown type": (GOOD.replace('"revolute"', '"Revolut"'), 6, "joint 'shoulder'", "did you mean 'revolute'?"),
    "no type": (GOOD.replace('type="revolute"', ""), 6, "joint 'shoulder'", "got ''"),
    "no limit": (robot(joint("j", "a", "b", limit="").replace("<limit />", "")), 5, "joint 'j'", "type continuous"),
    "limits the wrong way round": (
        GOOD.replace('lower="-1"', 'lower="3"'),
        6,
        "joint 'shoulder' <limit>",
        "above upper",
    ),
    "a negative velocity": (
        GOOD.replace('velocity="3"', 'velocity="-3"'),
        6,
        "joint 'shoulder' <limit>",
        "velocity limit -3",
    ),
    "an axis of length 0": (
        GOOD.replace('axis xyz="0 0 1"', 'axis xyz="0 0 0"'),
        6,
        "joint 'shoulder' <axis>",
        "length 0",
    ),
    "an axis without xyz": (GOOD.replace('axis xyz="0 0 1"', "axis"), 6, "joint 'shoulder' <axis>", "no xyz"),
    "two numbers": (GOOD.replace('rpy="0 0 0"', 'rpy="0 0"'), 6, "joint 'shoulder' <origin>", "2 numbers in rpy='0 0'"),
    "four numbers": (GOOD.replace('xyz="0 0 0"', 'xyz="0 0 0 0"'), 6, "joint 'shoulder' <origin>", "4 numbers in xyz"),
    "no number": (GOOD.replace('xyz="0 0 0"', 'xyz="0 0 up"'), 6, "joint 'shoulder' <origin>", "xyz='up'"),
    "a number for Python alone": (GOOD.replace('lower="-1"', 'lower="-1_0"'), 6, "joint 'shoulder' <limit>", "'-1_0'"),
    "not a number": (GOOD.replace('xyz="0 0 0"', 'xyz="nan 0 0"'), 6, "joint 'shoulder' <origin>", "finite number"),
    "infinity": (GOOD.replace('upper="2"', 'upper="inf"'), 6, "joint 'shoulder' <limit>", "finite number"),
    "too large for a float": (
        GOOD.replace('xyz="0 0 0"', 'xyz="0 1e999 0"'),
        6,
        "joint 'shoulder' <origin>",
        "'1e999'",
    ),
    "too large for an arm": (GOOD.replace('xyz="0 0 0"', 'xyz="0 2e6 0"'), 6, "joint 'shoulder' <origin>", "1e+06"),
    "xacro that was not expanded": (
        GOOD.replace("</robot>", '<xacro:include xmlns:xacro="http://ros.org/wiki/xacro"/></robot>'),
        8,
        "<xacro:include>",
        "`xacro robot.urdf.xacro > robot.urdf`",
    ),
    "xacro by another prefix": (
        GOOD.replace("</robot>", '<x:if xmlns:x="http://ros.org/wiki/xacro"/></robot>'),
        8,
        "<x:if>",
        "expand xacro first",
    ),
    "a xacro call in a joint of the chain": (
        GOOD.replace("<axis ", "<xacro:limits/><axis ", 1),
        6,
        "joint 'shoulder' <xacro:limits>",
        "expand xacro first",
    ),
    "a xacro call that made a link": (
        GOOD.replace('<link name="upper"/>', "<xacro:upper/>"),
        6,
        "joint 'shoulder'",
        "<xacro:upper> in line 4 is not expanded",
    ),
    "a xacro expression": (
        GOOD.replace('xyz="0 0 0"', 'xyz="0 0 ${l / 2}"'),
        6,
        "joint 'shoulder' <origin>",
        "expand xacro",
    ),
    "a xacro limit": (GOOD.replace('lower="-1"', 'lower="${-pi}"'), 6, "joint 'shoulder' <limit>", "expand xacro"),
    "a document type": ("<!DOCTYPE robot>" + GOOD.split("\n", 1)[1], 1, None, "document type declaration"),
    "entities that expand without end": (
        '<!DOCTYPE r [<!ENTITY a "xxxxxxxxxx"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]><robot name="&b;"/>',
        1,
        None,
        "document type declaration",
    ),
    "an entity that names a file": (
        '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]><robot name="&a;"/>',
        1,
        None,
        "document type declaration",
    ),
    "an entity that nobody declared": ('<robot name="&a;"/>', 1, None, "undefined entity"),
    "a mountain of elements": ("<robot>" + "<a>" * 1000, 1, None, "nested 101 deep"),
    "a very long attribute": (GOOD.replace('xyz="0 0 0"', f'xyz="{"1" * 5000} 0 0"'), 6, "<origin>", "5004 characters"),
    "an unknown encoding": ('<?xml version="1.0" encoding="klingon"?><robot/>', 1, None, "expected"),
    "a leader that is not there": (
        robot(joint("j", "a", "b", extra='<mimic joint="k"/>')),
        5,
        "joint 'j'",
        "a joint to follow: j",
    ),
    "a leader without a name": (
        robot(joint("j", "a", "b", extra="<mimic/>")),
        5,
        "joint 'j' <mimic>",
        "a missing joint name",
    ),
    "joints that follow each other": (
        robot(joint("j", "a", "b", extra='<mimic joint="k"/>'), joint("k", "b", "c", extra='<mimic joint="j"/>')),
        None,
        "joint 'j'",
        "cycle",
    ),
    "a follower far away": (
        robot(joint("j", "a", "b"), joint("k", "b", "c", extra='<mimic joint="l" multiplier="9e5" offset="1"/>'))
        .replace("</robot>", joint("l", "a", "d", extra='<mimic joint="m" offset="9e5"/>') + "</robot>")
        .replace("</robot>", '<link name="d"/><link name="e"/>' + joint("m", "a", "e") + "</robot>"),
        None,
        "joint 'k'",
        "the position 8.1e+11",
    ),
    "followers that run away": (
        robot(
            joint("j", "a", "b"),
            joint("k", "b", "c", extra='<mimic joint="j" multiplier="1e4"/>'),
            joint("l", "c", "d", extra='<mimic joint="k" multiplier="1e4"/>'),
        ),
        None,
        "joint 'l'",
        "1e+08 times the motion of joint 'j'",
    ),
    "a version to come": (
        GOOD.replace("<robot ", '<robot version="1.3" '),
        2,
        "<robot>",
        "got version='1.3', expected 1.0, 1.1, 1.2",
    ),
    "a version without a point": (GOOD.replace("<robot ", '<robot version="1" '), 2, "<robot>", "got version='1'"),
    "an empty version": (GOOD.replace("<robot ", '<robot version="" '), 2, "<robot>", "got version=''"),
    "a quaternion in URDF 1.0": (
        GOOD.replace('rpy="0 0 0"', 'quat_xyzw="0 0 0 1"'),
        6,
        "joint 'shoulder' <origin>",
        "quat_xyzw in a file of URDF 1.0",
    ),
    "angles and a quaternion": (
        URDF_1_1.replace('rpy="0 0 0"', 'rpy="0 0 0" quat_xyzw="0 0 0 1"'),
        6,
        "joint 'shoulder' <origin>",
        "both rpy and quat_xyzw",
    ),
    "a quaternion of length 0": (
        URDF_1_1.replace('rpy="0 0 0"', 'quat_xyzw="0 0 0 0"'),
        6,
        "joint 'shoulder' <origin>",
        "a quaternion of length 0",
    ),
    "a quaternion of three numbers": (
        URDF_1_1.replace('rpy="0 0 0"', 'quat_xyzw="0 0 1"'),
        6,
        "joint 'shoulder' <origin>",
        "3 numbers in quat_xyzw='0 0 1', expected 4 numbers",
    ),
    "no lower limit in URDF 1.2": (
        URDF_1_2.replace('lower="-1"', ""),
        6,
        "joint 'shoulder' <limit>",
        "no lower in a revolute joint",
    ),
    "no upper limit in URDF 1.2": (
        URDF_1_2.replace('upper="2"', ""),
        6,
        "joint 'shoulder' <limit>",
        "no upper in a revolute joint",
    ),
    "a negative deceleration": (
        URDF_1_2.replace('velocity="3"', 'deceleration="-3"'),
        6,
        "joint 'shoulder' <limit>",
        "the deceleration limit -3",
    ),
    "a planar joint that follows": (
        robot(joint("j", "a", "b"), joint("p", "b", "c", "planar", extra='<mimic joint="j"/>')),
        7,
        "joint 'p' <mimic>",
        "a planar joint that follows",
    ),
    "a joint that follows a planar one": (
        robot(joint("p", "a", "b", "planar"), joint("j", "b", "c", extra='<mimic joint="p"/>')),
        7,
        "joint 'j'",
        "follows the planar joint 'p'",
    ),
    "a part of a planar joint with the name of another": (
        robot(joint("p", "a", "b", "planar"), joint("p_TX", "b", "c")),
        6,
        "joint 'p'",
        "'p_TX' has the name of another joint",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_the_file_is_told_with_its_place(mistake, tmp_path):
    text, line, element, part = MISTAKES[mistake]
    path = tmp_path / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    error = refused(path, tip="c" if mistake == "a follower far away" else None)
    assert part in str(error)
    assert str(error).startswith(str(path))
    assert error.file == str(path)
    assert (error.line, error.element) == (line, element)


@pytest.mark.parametrize(
    ("asked", "argument", "part"),
    [
        ({"tip": "hnd"}, "tip", "expected a link of the file: base, upper, hand (did you mean 'hand'?)"),
        ({"tip": 7}, "tip", "got 7, expected a link of the file: base, upper, hand"),
        ({"base": "root"}, "base", "base: got 'root'"),
        ({"tip": "base"}, "tip", "got no joint that moves between base and tip"),
        ({"fixed": {"elbw": 0.0}}, "fixed", "a joint between base and tip: shoulder, elbow (did you mean 'elbow'?)"),
        ({"fixed": {"elbow": 1e7}}, "path", "the position 1e+07"),
        ({"fixed": {"elbow": 0.0, "shoulder": 0.0}}, "tip", "no joint that moves"),
    ],
)
def test_a_wrong_question_is_answered_with_the_choices(asked, argument, part):
    error = refused(GOOD, **asked)
    assert error.argument == argument
    assert part in str(error)


@pytest.mark.parametrize("fixed", [["elbow"], "elbow", {"elbow": "0"}, {"elbow": float("nan")}, {"elbow": True}])
def test_positions_are_numbers_by_name(fixed):
    with pytest.raises(sr.InputError, match="fixed"):
        sr.Arm.from_urdf(GOOD, fixed=fixed)


def test_a_file_that_cannot_be_read_is_told(tmp_path):
    assert "No such file" in str(refused(tmp_path / "gone.urdf"))
    assert "not a regular file" in str(refused(tmp_path))
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert "not a regular file" in str(refused(pipe))
    assert "not a path" in str(refused("a\0b"))
    assert "got None, expected the path of a URDF file" in str(refused(None))
    assert "got b'x'" in str(refused(b"x"))
    large = tmp_path / "large.urdf"
    with large.open("wb") as file:
        file.truncate(16 * 2**20 + 1)
    assert "more than 16 MiB" in str(refused(large))


FAR = robot(
    joint("shoulder", "base", "upper", xyz="6e5 0 0"),
    joint("slide", "upper", "arm", "prismatic", axis="1 0 0"),
    joint("mount", "arm", "wrist", "fixed", xyz="6e5 0 0"),
    joint("elbow", "wrist", "hand", xyz="5e5 0 0"),
    joint("flange", "hand", "plate", "fixed", xyz="6e5 0 0"),
    joint("tool", "plate", "tip", "fixed", xyz="5e5 0 0"),
)


def test_placements_that_add_up_to_more_than_a_file_may_say_are_refused():
    """Else to_urdf writes what from_urdf refuses."""
    elbow = refused(FAR)
    assert (elbow.element, "1100000 m" in str(elbow)) == ("joint 'elbow'", True)
    tool = refused(FAR, tip="tip", base="wrist")
    assert (tool.element, "1100000 m" in str(tool)) == ("the tool", True)
    assert refused(FAR, tip="hand", base="base", fixed={"slide": 1e5}).element == "joint 'elbow'"
    near = sr.Arm.from_urdf(FAR.replace("6e5", "5e5"))
    q = [0.1, 0.2, 0.3]
    np.testing.assert_allclose(sr.Arm.from_urdf(near.to_urdf()).forward(q), near.forward(q), rtol=1e-15)


def long_chain(n, kind="fixed"):
    return robot(*(joint(f"j{i}", f"l{i}", f"l{i + 1}", kind) for i in range(n)))


def test_large_trees_take_no_long_time():
    assert "4000 joints between base and tip" in str(refused(long_chain(4000)))
    assert "and 3971 more" in str(refused(long_chain(4000), tip="l4000x"))
    assert "1001 moving joints" in str(refused(long_chain(1001, "continuous")))
    assert "more than 50000 elements" in str(refused(f"<robot>{'<a/>' * 50_000}</robot>"))


def test_a_long_arm_is_read():
    arm = sr.Arm.from_urdf(long_chain(300, "continuous"))
    assert arm.n == 300
    assert arm.forward([0.01] * 300)[:2, 0] == pytest.approx([np.cos(3.0), np.sin(3.0)])
