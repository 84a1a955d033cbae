"""Chains from MJCF files, against MuJoCo's own kinematics."""

import builtins
import io

import mujoco
import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.mjcf_peer import Peer

ODD = """
<mujoco model="odd">
  <compiler angle="radian" eulerseq="zyx"/>
  <asset><mesh name="gone" file="gone.stl"/></asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="cart" pos="0.1 0.2 0.3" euler="0.1 0.2 0.3">
      <joint name="x" type="slide" axis="1 0.2 0" pos="0.3 0 0" ref="0.5" range="-1 2"/>
      <joint name="turn" axis="0 1 3" pos="0.1 -0.2 0.4" ref="-0.7"/>
      <joint axis="1 0 0" pos="0 0.5 0"/>
      <geom type="mesh" mesh="gone"/>
      <body name="left" pos="0 0.5 0" quat="1 2 3 4">
        <joint name="left elbow" pos="0.2 0 0" axis="0 0 -1" range="-2 1"/>
        <geom size="0.1"/>
        <frame pos="0 0 1" euler="1 0 0">
          <body name="hand" pos="0 0 0.3">
            <joint name="grip" type="slide" axis="0 1 0"/>
            <site name="tcp" pos="0.1 0 0.1" euler="0.4 0.5 0.6"/>
            <geom size="0.1"/>
          </body>
        </frame>
      </body>
      <body name="right" pos="0 -0.5 0" axisangle="1 1 0 2">
        <joint name="right elbow" pos="0 0.2 0.1" axis="0 1 0" ref="0.3"/>
        <geom size="0.1"/>
        <body name="ball" pos="1 0 0"><joint name="socket" type="ball"/><geom size="0.1"/></body>
      </body>
    </body>
    <body name="box"><freejoint name="loose"/><geom size="0.1"/></body>
  </worldbody>
  <actuator><motor joint="x"/></actuator>
  <sensor><jointpos joint="turn"/></sensor>
  <contact><exclude body1="left" body2="right"/></contact>
  <keyframe><key qpos="0 0 0 0 0 0 1 0 0 0 0 0 0 1 0 0 0"/></keyframe>
</mujoco>
"""
WHOLE = ODD.replace('<mesh name="gone" file="gone.stl"/>', '<mesh name="gone" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>')
"""The same file, as MuJoCo alone needs it."""


@pytest.mark.parametrize(
    ("base", "tip", "joints"),
    [
        (None, "tcp", ("x", "turn", "cart joint 3", "left elbow", "grip")),
        ("world", "left", ("x", "turn", "cart joint 3", "left elbow")),
        ("cart", "hand", ("left elbow", "grip")),
        ("right", "tcp", ("right elbow", "left elbow", "grip")),
        ("hand", "right", ("grip", "left elbow", "right elbow")),
        ("right", "world", ("right elbow", "cart joint 3", "turn", "x")),
    ],
)
def test_any_chain_is_mujocos(base, tip, joints):
    arm = sr.Arm.from_mjcf(ODD, tip=tip, base=base)
    assert arm.joint_names == joints
    peer = Peer(WHOLE)
    for q in np.random.default_rng(4).uniform(-3, 3, (20, arm.n)):
        T, J = peer.chain(base or "world", tip, joints, q)
        assert np.max(np.abs(arm.forward(q) - T)) <= 1e-12
        assert np.max(np.abs(arm.jacobian(q) - J)) <= 1e-12


def test_limits_are_those_of_the_file_and_rates_are_free():
    arm = sr.Arm.from_mjcf(ODD, tip="left")
    inf = np.inf
    assert arm.position_limits.tolist() == [[-1.0, 2.0], [-inf, inf], [-inf, inf], [-2.0, 1.0]]
    assert arm.velocity_limits.tolist() == [inf] * 4
    assert arm.kinds.tolist() == [1, 0, 0, 0]
    assert arm.name == "odd"


def test_fixed_joints_stay_where_they_are_told():
    held = {"turn": 0.4, "x": -0.2}
    arm = sr.Arm.from_mjcf(ODD, tip="tcp", fixed=held)
    assert arm.joint_names == ("cart joint 3", "left elbow", "grip")
    peer = Peer(WHOLE)
    T, _ = peer.chain("world", "tcp", (*arm.joint_names, *held), [0.1, 0.2, 0.3, *held.values()])
    assert np.max(np.abs(arm.forward([0.1, 0.2, 0.3]) - T)) <= 1e-12


def test_a_joint_coupled_to_one_outside_stands_where_that_puts_it():
    text = ODD.replace(
        "<actuator>", '<equality><joint joint1="grip" joint2="right elbow" polycoef="0.2 3"/></equality><actuator>'
    )
    arm = sr.Arm.from_mjcf(text, tip="tcp", fixed={"right elbow": 0.5})
    assert "grip" not in arm.joint_names
    peer = Peer(WHOLE)
    q = np.arange(4) / 3.0
    T, _ = peer.chain("world", "tcp", (*arm.joint_names, "grip"), [*q, 0.2 + 3 * (0.5 - 0.3)])
    assert np.max(np.abs(arm.forward(q) - T)) <= 1e-12
    alone = ODD.replace("<actuator>", '<equality><joint joint1="grip" polycoef="0.2"/></equality><actuator>')
    arm = sr.Arm.from_mjcf(alone, tip="tcp")
    T, _ = peer.chain("world", "tcp", (*arm.joint_names, "grip"), [*q, 0.2])
    assert np.max(np.abs(arm.forward(q) - T)) <= 1e-12


MATERIALS = '<asset><texture name="wood" type="2d" file="gone.png"/><material name="red" texture="wood"/></asset>'
LOOKED_AT = {
    "a sensor": '<sensor><framepos objtype="body" objname="hand"/></sensor>',
    "an exclude": '<contact><exclude body1="arm" body2="hand"/></contact>',
    "a tuple": '<custom><tuple name="t"><element objtype="body" objname="hand"/></tuple></custom>',
    "nothing": "",
}
FUSED = """<mujoco><compiler fusestatic="true"/><worldbody>
  <body name="arm"><joint name="j" axis="0 0 1"/><geom size=".1"/>
    <body name="hand" pos=".2 0 0" euler="0 30 0"><geom size=".1"/><site name="tcp" pos="0 0 .1"/></body></body>
  </worldbody>{}</mujoco>"""


@pytest.mark.parametrize("what", LOOKED_AT)
def test_a_static_body_is_there_whatever_refers_to_it(what):
    text = FUSED.format(LOOKED_AT[what])
    peer = Peer(text.replace('fusestatic="true"', ""))
    for tip in ("hand", "tcp"):
        for source in (text, mujoco.MjSpec.from_string(text)):
            T, J = peer.chain("world", tip, ["j"], [0.4])
            arm = sr.Arm.from_mjcf(source, tip=tip)
            assert arm.forward([0.4]) == pytest.approx(T, abs=1e-12)
            assert arm.jacobian([0.4]) == pytest.approx(J, abs=1e-12)


SITES = {
    "its own": ("", '<site name="tcp" pos="0 0 1" material="red"/>'),
    "by the default": ('<default><site material="red"/></default>', '<site name="tcp" pos="0 0 1"/>'),
    "by a class": (
        '<default><default class="seen"><site material="red"/></default></default>',
        '<site name="tcp" pos="0 0 1" class="seen"/>',
    ),
    "another site's": ("", '<site name="tcp" pos="0 0 1"/><site name="goal" material="red"/>'),
}


@pytest.mark.parametrize("whose", SITES)
def test_a_material_of_a_site_does_not_matter(whose):
    default, site = SITES[whose]
    body = f'<body name="b"><joint name="j" axis="1 0 0"/><geom size=".1" material="red"/>{site}</body>'
    arm = sr.Arm.from_mjcf(f"<mujoco>{default}{MATERIALS}<worldbody>{body}</worldbody></mujoco>", tip="tcp")
    assert arm.forward([np.pi / 2])[:3, 3] == pytest.approx([0.0, -1.0, 0.0], abs=1e-12)


def test_a_spec_with_a_gripper_attached_is_read_and_left_as_it_is():
    gripper = mujoco.MjSpec.from_string(
        f'<mujoco model="g">{MATERIALS}<worldbody><body name="palm"><joint name="roll" axis="0 0 1"/><geom size=".1"/>'
        '<site name="tcp" pos=".1 0 .2" material="red"/></body></worldbody></mujoco>'
    )
    spec = mujoco.MjSpec.from_string(WHOLE)
    spec.site("tcp").attach_body(gripper.body("palm"), "g/", "")
    before = spec.geoms, spec.materials, spec.sites[-1].material
    arm = sr.Arm.from_mjcf(spec, tip="g/tcp", base="left")
    assert arm.joint_names == ("grip", "g/roll")
    alone = sr.Arm.from_mjcf(ODD, tip="tcp", base="left")
    turn = sr.Arm([sr.Joint(name="roll")], tool=[[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0.2], [0, 0, 0, 1]])
    assert arm.forward([0.3, 0.7]) == pytest.approx(alone.forward([0.3]) @ turn.forward([0.7]), abs=1e-12)
    after = spec.geoms, spec.materials, spec.sites[-1].material
    assert [len(items) for items in before[:2]] == [len(items) for items in after[:2]]
    assert before[2] == after[2]


@pytest.mark.parametrize("inertia", ["auto", "true"])
def test_a_model_attached_in_the_file_is_read(inertia, tmp_path):
    """Its compiler settings are its own."""
    (tmp_path / "hand.xml").write_text(
        f'<mujoco model="c"><compiler angle="radian" inertiafromgeom="{inertia}"/><worldbody><body name="palm">'
        '<inertial pos="0 0 0" mass="1" fullinertia="1 1 1 .1 .1 .1"/><joint name="roll" axis="0 0 1" range="-1 1"/>'
        '<geom size=".1"/><site name="tcp" pos=".1 0 .2"/></body></worldbody></mujoco>',
        encoding="utf-8",
    )
    scene = tmp_path / "scene.xml"
    scene.write_text(
        '<mujoco><asset><model name="c" file="hand.xml"/></asset><worldbody><body name="b"><joint name="j"/>'
        '<geom size=".1"/><frame pos="0 1 0"><attach model="c" body="palm" prefix="g/"/></frame></body>'
        "</worldbody></mujoco>",
        encoding="utf-8",
    )
    arm, peer = sr.Arm.from_mjcf(scene, tip="g/tcp"), Peer(scene)
    assert arm.position_limits[1].tolist() == [-1.0, 1.0]
    T, J = peer.chain("world", "g/tcp", ["j", "g/roll"], [0.3, 0.4])
    assert arm.forward([0.3, 0.4]) == pytest.approx(T, abs=1e-12)
    assert arm.jacobian([0.3, 0.4]) == pytest.approx(J, abs=1e-12)


def test_a_spec_that_mujoco_cannot_compile_is_told():
    spec = mujoco.MjSpec()
    spec.worldbody.add_body(name="a").add_joint(name="j", axis=[0, 0, 0])
    with pytest.raises(sr.errors.RobotFileError, match="<MjSpec>: got an error of MuJoCo"):
        sr.Arm.from_mjcf(spec, tip="a")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("name", ["scene.xml", "arm.mjcf", "scene"])
def test_an_included_file_is_found_beside_a_file_of_any_name_and_encoding(encoding, name, tmp_path):
    (tmp_path / "arm.xml").write_text(ODD, encoding="utf-8")
    (tmp_path / name).write_text('<mujoco model="odd"><include file="arm.xml"/></mujoco>', encoding=encoding)
    assert sr.Arm.from_mjcf(tmp_path / name, tip="tcp") == sr.Arm.from_mjcf(ODD, tip="tcp")


@pytest.mark.parametrize("stream", [io.StringIO(ODD), io.BytesIO(ODD.encode()), io.BytesIO(ODD.encode("utf-16"))])
def test_a_file_object_does_as_well(stream):
    assert sr.Arm.from_mjcf(stream, tip="tcp") == sr.Arm.from_mjcf(ODD, tip="tcp")


def test_a_model_and_a_file_do_as_well(tmp_path):
    path = tmp_path / "odd.xml"
    path.write_text(ODD, encoding="utf-8")
    arm = sr.Arm.from_mjcf(ODD, tip="tcp")
    assert sr.Arm.from_mjcf(path, tip="tcp") == arm
    again = sr.Arm.from_mjcf(Peer(WHOLE).model, tip="tcp")
    q = np.linspace(-1, 1, arm.n)
    assert np.max(np.abs(again.forward(q) - arm.forward(q))) <= 1e-15


@pytest.mark.parametrize(
    ("text", "asked", "part"),
    [
        (ODD, {"tip": "tpc"}, "did you mean 'tcp'?"),
        (ODD, {"tip": None}, "3 ends: hand, ball, box"),
        (ODD, {"tip": "hand", "base": "tcp"}, "base: got 'tcp', expected a body: world, cart, left"),
        (ODD, {"tip": "ball"}, "a ball joint between base and tip, in body 'ball'"),
        (ODD, {"tip": "ball"}, "base='ball' begins after it"),
        (ODD, {"tip": "box"}, "a free joint between base and tip, in body 'box'"),
        (ODD, {"base": "box", "tip": "left"}, "tip='box' ends before it"),
        (ODD, {"tip": "tcp", "fixed": {"right elbow": 0.0}}, "a joint between base and tip: x, turn, cart joint 3"),
        ("<robot name='a'/>", {"tip": "a"}, "Arm.from_urdf reads URDF"),
        ("<mujoco><worldbody><body><joint type='hin'/></body></worldbody></mujoco>", {"tip": "a"}, "error of MuJoCo"),
        ("<!DOCTYPE a><mujoco/>", {"tip": "a"}, "document type declaration"),
        ("<mujoco>", {"tip": "a"}, "no element found"),
        (
            ODD.replace(
                "<actuator>",
                '<equality><joint joint1="grip" joint2="x" polycoef="0 1 1"/></equality><actuator>',
            ),
            {"tip": "tcp"},
            "a polynomial of degree above 1",
        ),
    ],
)
def test_mistakes_name_the_place_and_the_choices(text, asked, part):
    with pytest.raises(sr.errors.RobotFileError) as caught:
        sr.Arm.from_mjcf(text, **asked)
    assert part in str(caught.value)


def test_what_mujoco_refuses_has_its_line():
    with pytest.raises(sr.errors.RobotFileError) as caught:
        sr.Arm.from_mjcf(ODD.replace('type="ball"', 'type="bal"'), tip="tcp")
    assert caught.value.line == 1 + ODD[: ODD.index('type="ball"')].count("\n")


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(sr.errors.RobotFileError, match="No such file"):
        sr.Arm.from_mjcf(tmp_path / "gone.xml", tip="a")
    with pytest.raises(
        sr.errors.RobotFileError, match=r"got 7, .* its text, a mujoco\.MjSpec, a mujoco\.MjModel or a file"
    ):
        sr.Arm.from_mjcf(7, tip="a")


def test_without_mujoco_the_extra_is_named(monkeypatch):
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name == "mujoco":
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(sr.errors.MissingExtraError, match=r"Arm.from_mjcf\(\) needs .*stillreach\[mujoco\]"):
        sr.Arm.from_mjcf(ODD, tip="tcp")
