"""URDF files with leftovers that other readers skip, and in encodings that other programs write."""

import time

import pinocchio as pin
import pytest

import stillreach as sr
from tests.unit.arm.file_peer import Peer
from tests.unit.arm.urdf_texts import joint, robot

ARM = robot(joint("j", "a", "b", axis="0 1 0"), joint("mount", "b", "c", "fixed", xyz="1 0 0"))
SECOND = {
    "an equal <limit>": '<limit lower="-1" upper="2" velocity="3" effort="4"/>',
    "another <limit>": '<limit lower="-9" upper="9" velocity="9" effort="4"/>',
    "an <axis>": '<axis xyz="1 0 0"/>',
    "an <origin>": '<origin xyz="7 8 9"/>',
    "a <parent>": '<parent link="a"/>',
    "a <child>": '<child link="b"/>',
}


@pytest.mark.parametrize("what", SECOND)
def test_a_second_element_does_not_count_as_in_pinocchio(what):
    text = ARM.replace("</joint>", f"{SECOND[what]}</joint>", 1)
    model = Peer(text).model
    arm = sr.Arm.from_urdf(text)
    T, J = Peer(text).chain("a", "c", ["j"], [0.3])
    assert arm.forward([0.3]) == pytest.approx(T, abs=1e-12)
    assert arm.jacobian([0.3]) == pytest.approx(J, abs=1e-12)
    assert arm.position_limits.tolist() == [[model.lowerPositionLimit[0], model.upperPositionLimit[0]]]
    assert arm.velocity_limits.tolist() == [model.velocityLimit[0]]


@pytest.mark.parametrize("comment", ["<!-- a -- b -->", "<!-- a --->", "<!--\n<joint>\n-->", "<!---->"])
def test_comments_with_dashes_are_skipped_as_in_pinocchio(comment):
    text = ARM.replace("</joint>", f"{comment}</joint>", 1)
    assert Peer(text).model.nv == 1
    assert sr.Arm.from_urdf(text) == sr.Arm.from_urdf(ARM)
    with pytest.raises(sr.errors.RobotFileError) as caught:
        sr.Arm.from_urdf(text.replace('"fixed"', '"fixt"'))
    assert caught.value.line == 7 + comment.count("\n")


def test_what_looks_like_a_comment_in_other_text_hides_nothing():
    for text in ("<![CDATA[ <!-- ]]>", "<!-- <![CDATA[ -->"):
        arm = sr.Arm.from_urdf(
            ARM.replace("</robot>", f"<note>{text}</note></robot>").replace("<joint", f"{text}<joint", 1)
        )
        assert arm == sr.Arm.from_urdf(ARM)


@pytest.mark.parametrize("end", ["\0", "\0\0\n", "\n\0"])
def test_a_zero_after_the_end_is_skipped_as_in_pinocchio(end, tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_bytes((ARM + end).encode())
    assert pin.buildModelFromUrdf(str(path)).nv == 1
    assert sr.Arm.from_urdf(path) == sr.Arm.from_urdf(ARM)


def test_a_comment_that_does_not_end_is_told():
    with pytest.raises(sr.errors.RobotFileError, match="line 6"):
        sr.Arm.from_urdf(ARM.replace("<joint", "<!-- <joint", 1))


MUCH = {
    "spaces": " " * 500_000,
    "comments": "<!-- -->" * 60_000,
    "comments in a comment": "<!--" * 100_000,
    "every other comment open": "<!-- --><!--" * 50_000,
}


@pytest.mark.parametrize("start", MUCH)
@pytest.mark.parametrize("end", ["<robot>", '<?xml version="1.0"?><robot>'])
def test_much_white_space_and_many_comments_take_no_long_time(start, end):
    before = time.process_time()
    with pytest.raises(sr.errors.RobotFileError):
        sr.Arm.from_urdf(MUCH[start] + end)
    assert time.process_time() - before < 2.0


XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
CALLS = {
    "beside the joints": ARM.replace("</robot>", f'<xacro:imu {XACRO} name="imu"/></robot>'),
    "in a link": ARM.replace('<link name="c"/>', f'<link name="c"><xacro:inertia {XACRO} m="1"/></link>'),
    "by another prefix": ARM.replace("</robot>", '<x:imu xmlns:x="http://ros.org/wiki/xacro"><a/></x:imu></robot>'),
    "in gazebo's part": ARM.replace("</robot>", f"<gazebo><xacro:imu {XACRO}/></gazebo></robot>"),
    "in a joint beside the chain": ARM.replace(
        "</robot>",
        f'<link name="d"/><joint name="k" type="revolute"><parent link="a"/><child link="d"/><xacro:limit {XACRO}/>'
        '<limit lower="0" upper="1" velocity="1" effort="1"/></joint></robot>',
    ),
    "a constant": ARM.replace("</robot>", f'<xacro:property {XACRO} name="pi" value="3.14"/></robot>'),
}


@pytest.mark.parametrize("place", CALLS)
def test_a_xacro_call_that_nobody_expanded_is_skipped_beside_the_chain(place):
    T, _ = Peer(CALLS[place]).chain("a", "c", ["j"], [0.3])
    assert sr.Arm.from_urdf(CALLS[place], tip="c").forward([0.3]) == pytest.approx(T, abs=1e-12)


@pytest.mark.parametrize("before", ["\n", " \t", "\r\n\r\n  ", "\ufeff\n", "\ufeff", '<?xml version="1.0"?>\n'])
def test_white_space_before_the_declaration_is_skipped_and_lines_are_counted(before, tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_bytes((before + ARM).encode())
    expected = sr.Arm.from_urdf(ARM)
    assert sr.Arm.from_urdf(path) == sr.Arm.from_urdf(before + ARM) == expected
    for wrong in (ARM.replace('"revolute"', '"revolt"'), ARM.replace("</robot>", "</robo>")):
        with pytest.raises(sr.errors.RobotFileError) as caught:
            sr.Arm.from_urdf(before + wrong)
        with pytest.raises(sr.errors.RobotFileError) as plain:
            sr.Arm.from_urdf(wrong)
        assert caught.value.line == plain.value.line + before.count("\n")


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
@pytest.mark.parametrize("declared", ["", ' encoding="utf-8"', ' encoding="UTF-16"'])
def test_utf_16_as_powershell_writes_it_is_read_whatever_it_declares(encoding, declared, tmp_path):
    text = robot(joint("ölbogen", "a", "b")).replace("?>", f"{declared}?>").replace("\n", "\r\n")
    path = tmp_path / "arm.urdf"
    for mark in ("\ufeff", ""):
        path.write_bytes((mark + text).encode(encoding))
        assert sr.Arm.from_urdf(path).joint_names == ("ölbogen",)


def test_half_a_character_of_utf_16_is_told(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_bytes(("\ufeff" + ARM).encode("utf-16-le")[:-1])
    with pytest.raises(sr.errors.RobotFileError, match="bytes that are not UTF-16"):
        sr.Arm.from_urdf(path)
