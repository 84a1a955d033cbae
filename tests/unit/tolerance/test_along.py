"""A survey of the configurations along a task, and the section of the page that shows it."""

import json
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError
from tests.commands import run_command

zarr = pytest.importorskip("zarr", reason="needs the extra survey")
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
TIME = np.linspace(0.0, 2.0, 41)
DRIVE = sr.Recording(sr.arms.panda(), TIME, START + 0.25 * np.sin(np.outer(TIME, [0.5, 0.7, 0.3, 0.6, 0.4, 0.8, 0.2])))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    rehearsal = sr.tolerance.rehearse(DRIVE, onsets=4)
    sr.tolerance.survey_along(rehearsal, tmp_path_factory.mktemp("along") / "x", count=60)
    return rehearsal


def test_its_configurations_are_those_of_the_task(tmp_path):
    rehearsal = sr.tolerance.rehearse(DRIVE, onsets=4)
    run = sr.simulate(rehearsal.scenario, progress=False)
    made = sr.tolerance.survey_along(rehearsal, tmp_path / "x", count=5)
    assert rehearsal.survey is made
    low, left, q = made.weakest(1)
    ticks = np.linspace(0, len(run) - 1, 5).round().astype(int)
    apart = np.abs(run.q[ticks] - q).max(axis=1)
    assert apart.min() < 2e-3  # between ticks
    report = sr.tolerance.report(sr.arms.panda(), q, k=1, task=rehearsal.scenario.task)
    assert left == pytest.approx(report.worst(1)[1], rel=1e-9)
    assert low == report.worst(1)[0]
    assert made.metrics == ("relative", "depth", "reach", "positions")
    assert rehearsal.facts()["survey"] == made.facts()


def test_poses_are_still_reached_as_inverse_kinematics_says(found):
    """Another count of the same: random poses, joint 4 locked at a place of the task."""
    arm, random = sr.arms.panda(), np.random.default_rng(8)
    low, high = arm.position_limits.T
    poses = arm.forward(random.uniform(low, high, (300, 7)))
    run = sr.simulate(found.scenario, progress=False)
    at = run.q[random.integers(0, len(run), 300)]
    for joint in (3, 4):
        share = arm.inverse(poses, at, locked=[joint], task=found.scenario.task).share
        assert found.survey.reached[joint] == pytest.approx(share, abs=0.2)  # 60 against 300


def section(html):
    return html.partition("<h2>Where it can still go</h2>")[2].partition("<h2>")[0]


def test_the_page_gains_a_section(found):
    pytest.importorskip("jinja2")
    text, survey = section(found.html()), found.survey
    drawings = [ET.fromstring(svg) for svg in re.findall(r"<svg.*?</svg>", text, re.DOTALL)]
    ranking, plane, depth = drawings
    words = [[element.text for element in drawing.iter("text")] for drawing in drawings]
    order = np.argsort(survey.reached)
    names = [name for name in words[0] if name in survey.arm.joint_names]
    assert [survey.reached[survey.arm.joint_index(name)] for name in names] == [survey.reached[j] for j in order]
    assert f"The loss of {names[0]} costs most: {100 * survey.reached[order[0]]:.0f} % of the poses" in text
    bars = [float(bar.get("width")) for bar in ranking.iter("rect") if bar.get("class") == "bar"]
    track = next(float(bar.get("width")) for bar in ranking.iter("rect") if bar.get("class") == "track")
    places = [survey.arm.joint_index(name) for name in names]
    expected = np.concatenate([values[places] for values in (survey.reached, survey.positions, survey.remaining())])
    np.testing.assert_allclose(np.array(bars) / track, expected, atol=1e-3)
    panels = [text for text in words[1] if text.startswith(("all joints", "panda_joint"))]
    assert len(panels) == 8
    assert sum("fill: var(--always)" in path.get("style", "") for path in plane.iter("path")) >= 1
    heights = [float(bar.get("height")) for bar in depth.iter("rect")]
    np.testing.assert_allclose(np.array(heights) / 110.0, survey.total("depth") / 60.0, atol=1e-3)
    assert words[2][1] == "already singular"
    assert "[m]" in text
    assert "[%]" in text
    assert "http" not in text


def test_a_page_without_a_survey_has_no_such_section():
    pytest.importorskip("jinja2")
    rehearsal = sr.tolerance.rehearse(DRIVE, onsets=2)
    assert section(rehearsal.html()) == ""
    assert rehearsal.facts()["survey"] is None


def test_tasks_without_a_plane_and_faults_of_their_own(tmp_path):
    pytest.importorskip("jinja2")
    task = sr.Task(rows="orientation")
    scenario = sr.Scenario(
        arm=sr.arms.panda(),
        start=START,
        motion=sr.ConstantTwist([0.0, 0.0, 0.0, 0.1, 0.0, 0.0], duration=0.3),
        task=task,
        faults=[sr.Fault(0, at=0.1)],
    )
    rehearsal = sr.tolerance.rehearse(scenario, onsets=2)
    made = sr.tolerance.survey_along(rehearsal, tmp_path / "x", count=20)
    assert made.metrics == ("relative", "depth", "reach")
    text = section(rehearsal.html())
    assert "The faults of the task itself are left out here." in text
    assert "plane" not in text
    assert "4 or more" not in text
    assert "1 or more" in text  # four of seven joints could


def test_mistakes(found, tmp_path):
    with pytest.raises(InputError, match="rehearsal: got 3"):
        sr.tolerance.survey_along(3, tmp_path / "x")
    with pytest.raises(InputError, match="count: got 0"):
        sr.tolerance.survey_along(found, tmp_path / "x", count=0)
    with pytest.raises(InputError, match="other configurations"):
        sr.tolerance.survey_along(found, found.survey.path, count=61)


def test_the_command_adds_it(tmp_path):
    pytest.importorskip("jinja2")
    some = ["rehearse", "panda-elbow", "--healthy", "--onsets", "1", "--no-plot"]
    answer = run_command(*some, "--survey", "12", folder=tmp_path)
    assert answer.code == 0, answer.err
    folder = tmp_path / "out" / "panda-elbow"
    kept = sr.tolerance.Survey.load(folder / "rehearsal.zarr")
    assert kept.configurations == 12
    facts = json.loads((folder / "rehearsal.json").read_text())
    assert facts["survey"] == json.loads(json.dumps(kept.facts()))
    assert kept.verdict in " ".join(answer.out.split())
    assert section((folder / "rehearsal.html").read_text())
    some.append("--no-page")
    again = run_command(*some, "--survey", "13", "--json", folder=tmp_path)  # another one takes its place
    assert json.loads(again.out)["survey"]["configurations"] == 13
    assert json.loads(again.out)["files"][-1].endswith("rehearsal.zarr")
    (folder / "rehearsal.zarr" / ".zattrs").write_text("{}")
    refused = run_command(*some, "--survey", "14", folder=tmp_path)
    assert refused.code == 2
    assert "which is something else" in " ".join(refused.err.split())
