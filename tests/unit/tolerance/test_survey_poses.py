"""Surveys of poses, of given configurations, and of arms of many joints."""

import json
from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError
from tests.commands import run_command

zarr = pytest.importorskip("zarr", reason="needs the extra survey")
PANDA = sr.arms.panda()
ALL = ("relative", "speed", "depth", "reach")


def opened(path):
    return zarr.open_group(str(path), mode="r", zarr_format=2)


def arrays(found):
    return {name: array[...] for name, array in opened(found.path).arrays()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A survey of a Panda that keeps all."""
    folder = tmp_path_factory.mktemp("survey") / "panda"
    return sr.tolerance.survey(PANDA, folder, samples=90, k=2, chunk=64, seed=5, metrics=ALL[:3], keep="all")


def test_poses_are_surveyed_where_they_are_reached(tmp_path):
    q = np.random.default_rng(1).uniform(
        *(0.5 * PANDA.position_limits.T + 0.5 * PANDA.position_limits.mean(axis=1)), (20, 7)
    )
    poses = PANDA.forward(q)
    poses[[3, 17], :3, 3] *= 10.0
    found = sr.tolerance.survey(PANDA, tmp_path / "x", poses=poses, chunk=8, k=1, metrics="relative", keep="all")
    data = arrays(found)
    counts = data["counts"]
    assert np.flatnonzero(~counts).tolist() == [3, 17]
    assert found.configurations == 18
    assert int(found.total("unreached")) == 2
    np.testing.assert_allclose(PANDA.forward(data["q"][counts]), poses[counts], atol=1e-5)
    assert np.isnan(data["every_relative"][3]).all()
    assert found.unreached.tolist() == [3, 17]
    assert found.verdict.startswith(
        "2 of 20 poses are not reached and are left out. At the median of 18 configurations"
    )
    reduced = sr.tolerance.survey(PANDA, tmp_path / "y", poses=poses, chunk=8, k=1, metrics="relative")
    assert reduced.unreached.tolist() == [3, 17]
    assert reduced.facts()["unreached"] == 2


def test_poses_of_which_none_is_reached(tmp_path):
    pytest.importorskip("matplotlib").use("agg")
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, 0, 3] = 9.0
    arm = sr.arms.planar(3)  # whose plane lies between the middles of the cells: no position is reached, too
    found = sr.tolerance.survey(arm, tmp_path / "x", poses=poses, k=1, metrics=(*ALL, "positions"), starts=2)
    assert found.verdict == "None of the 3 poses is reached."
    assert (found.configurations, found.complete) == (0, True)
    assert found.unreached.tolist() == [0, 1, 2]
    json.dumps(found.facts(), allow_nan=False)
    for figure in (found.plot(), found.plot("slice"), found.plot("cloud")):
        assert figure.axes
    assert str(found).count("-") > 3


def test_given_configurations_are_surveyed_as_they_are(whole, tmp_path):
    data = arrays(whole)
    settings = {"k": 2, "chunk": 64, "metrics": ALL[:3], "keep": "all"}
    found = sr.tolerance.survey(PANDA, tmp_path / "x", q=data["q"], **settings)
    for name in ("q", "every_relative", "every_speed", "every_depth", "worst", "map_sum"):
        np.testing.assert_array_equal(arrays(found)[name], data[name])
    assert found.unreached.tolist() == []
    with pytest.raises(InputError, match="other configurations"):
        sr.tolerance.survey(PANDA, tmp_path / "x", q=data["q"] + 1e-12, **settings)


def test_an_arm_of_many_joints_says_what_is_left_out(tmp_path):
    """Up to 31 joints all is computed; beyond, what has no limit."""
    long = sr.tolerance.survey(sr.arms.snake(32), tmp_path / "x", samples=20, k=1)
    assert long.metrics == ("relative",)
    assert long.verdict.endswith(
        "Speed and depth are left out: with 32 joints each configuration has 201,376 facets to look at."
    )
    shorter = sr.tolerance.survey(sr.arms.snake(18), tmp_path / "y", samples=20, k=1)
    assert shorter.metrics == ALL[:3]
    assert "left out" not in shorter.verdict
    with pytest.raises(InputError, match="201,376 facets a configuration, expected at most 200,000"):
        sr.tolerance.survey(sr.arms.snake(32), tmp_path / "z", samples=20, k=1, metrics="depth")


POSES = """x [mm]; y [mm]; z; roll [deg]; pitch [deg]; yaw [deg]
400; 0; 0,4; 180; 0; 0

500; 100; 0,3; 180; 0; 90
5000; 0; 0,3; 180; 0; 0
9000; 0; 0,3; 180; 0; 0
"""


def test_the_command_takes_poses_of_a_file(tmp_path):
    (tmp_path / "own.csv").write_text(POSES, encoding="utf-8")
    some = ["survey", "panda", "--poses", "own.csv", "-k", "1", "--no-plot", "--metric", "relative", "--keep", "all"]
    answer = run_command(*some, folder=tmp_path)
    assert "2 of 4 poses are not reached and are left out." in " ".join(answer.out.split())
    assert "not reached: line 5-6" in answer.out
    facts = json.loads(run_command(*some, "--json", folder=tmp_path).out)  # goes on with the same folder
    assert (facts["configurations"], facts["unreached"], facts["unreached_lines"]) == (2, 2, [5, 6])
    turned = np.array([[1.0, 0, 0, 0.4], [0, -1, 0, 0], [0, 0, -1, 0.4], [0, 0, 0, 1]])
    other = np.array([[0.0, 1, 0, 0.5], [1, 0, 0, 0.1], [0, 0, -1, 0.3], [0, 0, 0, 1]])
    q = opened(tmp_path / "out" / "panda" / "survey.zarr")["q"][:2]
    np.testing.assert_allclose(PANDA.forward(q), [turned, other], atol=1e-5)
    (tmp_path / "places.csv").write_text("x,y,z\n0.4,0,0\n", encoding="utf-8")
    places = ["survey", "planar3", "--poses", "places.csv", "-k", "1", "--out", "places", "--metric", "positions"]
    done = json.loads(run_command(*places, "--starts", "3", "--json", folder=tmp_path).out)
    pictures = ["survey.zarr", "survey.json", "survey.png", "survey-slice.png", "survey-cloud.png"]
    assert [Path(file).name for file in done["files"]] == pictures[: len(done["files"])]
    assert sr.tolerance.Survey.load(tmp_path / "places" / "survey.zarr").task.indices == (0, 1, 2)  # no attitudes
    for wrong, said in (
        (["--poses", "none.csv"], "none.csv"),
        (["--poses", "own.csv", "--samples", "5"], "poses: got a value beside samples"),
        (["--length", "mm"], "--length: got 'mm', expected a file of poses with it"),
    ):
        refused = run_command("survey", "panda", *wrong, "--out", "new", folder=tmp_path)
        assert refused.code == 2, refused
        assert said in " ".join(refused.err.split())
