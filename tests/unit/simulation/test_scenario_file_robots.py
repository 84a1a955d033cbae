"""The arm of a scenario file: built in, from modules or rows, from a file beside it or in a package."""

import numpy as np
import pytest

import stillreach as sr

RAIL = """
[robot]
dh = [{ kind = "prismatic", name = "rail", alpha = 90 }, { a = 1000, theta = 30 }, { a = 500, d = 20, alpha = -90 }]
"""
WAIT = '[[motion]]\nkind = "wait"\nduration = 1\n'
MJCF = """
<mujoco><worldbody>
  <body name="link"><joint name="hinge" axis="0 1 0"/><geom size="0.1"/>
    <body name="hand" pos="0 0 0.5"><joint name="slide" type="slide" axis="1 0 0"/><geom size="0.1"/></body>
  </body>
</worldbody></mujoco>
"""


def test_an_arm_with_a_slide_takes_lengths_and_angles_each_in_its_unit(load):
    scenario = load(
        'start = [200, 90, 0]\nvelocity_limits = [500, 90, 90]\n[units]\nlength = "mm"\nangle = "deg"\n'
        + RAIL
        + WAIT
        + '[[faults]]\njoint = "rail"\nkind = "runaway"\nrate = 100\n'
    )
    rows = [
        sr.DHRow(kind="prismatic", name="rail", alpha=np.pi / 2),
        sr.DHRow(a=1.0, theta=np.deg2rad(30)),
        sr.DHRow(a=0.5, d=0.02, alpha=-np.pi / 2),
    ]
    q = [0.2, np.pi / 2, 0.0]
    np.testing.assert_allclose(scenario.start, q, rtol=1e-15)
    np.testing.assert_allclose(scenario.arm.forward(q), sr.Arm.from_dh(rows).forward(q), atol=1e-15)
    np.testing.assert_allclose(scenario.velocity_limits[:, 1], [0.5, np.pi / 2, np.pi / 2], rtol=1e-15)
    assert scenario.faults[0].kind == sr.Runaway(100 * 0.001)


@pytest.mark.parametrize("unit", ["m", "cm", "mm", "in", "ft"])
def test_the_same_lengths_in_another_unit_are_the_same_arm(load, unit):
    metre = {"m": 1, "cm": 100, "mm": 1000, "in": 1 / 0.0254, "ft": 1 / 0.3048}[unit]
    text = f'start = {{}}\n[units]\nlength = "{unit}"\n[robot]\nmodules = "PP"\nlengths = [{metre}, {metre}, {metre}]\n'
    arm = load(text + '[[motion]]\nkind = "wait"\nduration = 1\n').arm
    np.testing.assert_allclose(arm.forward([0, 0])[:3, 3], [0, 0, 3], rtol=1e-14)


def test_built_in_arms_take_their_parameters(load):
    motion = '[[motion]]\nkind = "wait"\nduration = 1\n'
    segments = "[1, 1, 1, 1, 1, 1]"
    arm = load(f'start = {{}}\n{motion}[robot]\narm = "nasa_modular"\nlengths = {segments}\n').arm
    assert arm.reach == pytest.approx(6.0)
    assert load(f'start = {{}}\n{motion}[robot]\narm = "snake"\nn = 7\n').arm.n == 7
    assert load(f'start = {{}}\n{motion}[robot]\narm = "canadarm2"\n').arm.name == "canadarm2"


def test_a_name_with_its_number_is_the_same_as_the_number_beside_it(load):
    text = f"start = {{}}\nallow_outside = true\n{WAIT}[robot]\narm = "
    assert load(f'{text}"snake7"\n').arm == load(f'{text}"snake"\nn = 7\n').arm == sr.arms.snake(7)
    hand = load(f'{text}"panda"\ntip = "panda_hand_tcp"\n').arm
    assert hand == sr.arms.panda(tip="panda_hand_tcp")
    with pytest.raises(sr.errors.ScenarioFileError, match=r"robot\.tip: got 'hand', expected one of panda_link8"):
        load(f'{text}"panda"\ntip = "hand"\n')


def test_a_urdf_is_found_beside_the_scenario_file(load, tmp_path):
    arm = sr.Arm.from_modules("RPRP", [0.3, 0.4, 0.5])
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "arm.urdf").write_text(arm.to_urdf())
    scenario = load(
        'start = { j2 = 30 }\n[units]\nangle = "deg"\n[robot]\nurdf = "robots/arm.urdf"\nfixed = { j3 = 90 }\n'
        '[[motion]]\nkind = "wait"\nduration = 1\n'
    )
    assert scenario.arm.joint_names == ("j1", "j2", "j4")
    q = np.deg2rad([0, 30, 90, 0])
    np.testing.assert_allclose(scenario.arm.forward(q[[0, 1, 3]]), arm.forward(q), atol=1e-12)


def test_a_file_in_a_package_is_found_by_the_packages_name(load, tmp_path, monkeypatch):
    folder = tmp_path / "site" / "robots_of_ours"
    folder.mkdir(parents=True)
    info = tmp_path / "site" / "robots_of_ours-1.0.dist-info"
    info.mkdir()
    (folder / "arm.urdf").write_text(sr.Arm.from_modules("RPRP", [0.3, 0.4, 0.5]).to_urdf())
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: robots-of-ours\nVersion: 1.0\n")
    (info / "RECORD").write_text("robots_of_ours/arm.urdf,,\nrobots_of_ours-1.0.dist-info/METADATA,,\n")
    monkeypatch.syspath_prepend(tmp_path / "site")
    text = 'start = {{}}\n[robot]\nurdf = "{}"\n[[motion]]\nkind = "wait"\nduration = 1\n'
    assert load(text.format("package:robots-of-ours/robots_of_ours/arm.urdf")).arm.n == 4
    assert load(text.format("package:robots-of-ours/arm.urdf")).arm.n == 4
    with pytest.raises(
        sr.errors.ScenarioFileError, match=r"robot\.urdf: got 'arn.urdf', which robots-of-ours 1\.0 does not"
    ):
        load(text.format("package:robots-of-ours/arn.urdf"))


def test_a_package_that_is_not_there_is_named_with_the_command_that_brings_it(load):
    text = 'start = {}\n[robot]\nurdf = "package:no-such-robots/x.urdf"\n[[motion]]\nkind = "wait"\nduration = 1\n'
    with pytest.raises(sr.errors.ScenarioFileError, match="pip install --no-deps no-such-robots") as caught:
        load(text)
    assert [mistake.place for mistake in caught.value.mistakes] == ["robot.urdf"]


def test_an_mjcf_is_found_beside_the_scenario_file(load, tmp_path):
    pytest.importorskip("mujoco", reason="pip install 'stillreach[mujoco]'")
    (tmp_path / "arm.xml").write_text(MJCF)
    units = '[units]\nlength = "cm"\nangle = "deg"\n'
    arm = load(f'start = [90, 20]\n{units}[robot]\nmjcf = "arm.xml"\ntip = "hand"\n{WAIT}')
    assert arm.arm.joint_names == ("hinge", "slide")
    np.testing.assert_allclose(arm.arm.forward(arm.start)[:3, 3], [0.5, 0.0, -0.2], atol=1e-12)


def test_a_fault_of_a_follower_is_a_mistake_that_names_its_leader(load, tmp_path):
    (tmp_path / "hand.urdf").write_text(
        '<robot name="hand"><link name="palm"/><link name="a"/><link name="b"/>'
        '<joint name="finger" type="continuous"><parent link="palm"/><child link="a"/><axis xyz="0 0 1"/></joint>'
        '<joint name="mimic" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
        '<mimic joint="finger"/></joint></robot>'
    )
    text = '[robot]\nurdf = "hand.urdf"\n[start]\nfinger = 0.1\n[[motion]]\nkind = "wait"\nduration = 1\n'
    with pytest.raises(sr.errors.ScenarioFileError, match=r"faults\[0\].joint: got 'mimic', which follows 'finger'"):
        load(text + '[[faults]]\njoint = "mimic"\nkind = "locked"\n')
