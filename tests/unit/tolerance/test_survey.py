"""Surveys: what they count and keep, and the command."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError
from stillreach.arm.limits import sampling_range
from stillreach.errors import MissingExtraError, UnknownJointError
from stillreach.show.style import wrapped
from stillreach.tolerance.surveys import store
from stillreach.tolerance.surveys.arrays import EDGES, SPEEDS, quantile
from tests.commands import run_command

zarr = pytest.importorskip("zarr", reason="needs the extra survey")
ROOT = Path(__file__).parents[3]
PANDA = sr.arms.panda()
PLANE = sr.Task(rows=(True, True, False, False, False, False))
ALL = ("relative", "speed", "depth", "reach")
FULL = bool(os.environ.get("STILLREACH_FULL"))


def opened(path):
    return zarr.open_group(str(path), mode="r", zarr_format=2)


def arrays(found):
    """By name, read with Zarr alone, which starts ten times faster than xarray."""
    return {name: array[...] for name, array in opened(found.path).arrays()}


def assert_same(one, other):
    """Every array and attribute, bit for bit."""
    first, second = opened(one.path), opened(other.path)
    assert dict(first.attrs) == dict(second.attrs)
    names = sorted(name for name, _ in first.arrays())
    assert names == sorted(name for name, _ in second.arrays())
    for name in names:
        assert dict(first[name].attrs) == dict(second[name].attrs)
        assert first[name].dtype == second[name].dtype
        assert first[name][...].tobytes() == second[name][...].tobytes(), name


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A survey of a Panda that keeps all."""
    folder = tmp_path_factory.mktemp("survey") / "panda"
    return sr.tolerance.survey(PANDA, folder, samples=150, k=2, chunk=64, seed=5, metrics=ALL[:3], keep="all")


def test_configurations_are_within_the_limits_and_each_is_counted_once(whole):
    q = arrays(whole)["q"]
    low, high = sampling_range(PANDA.kinds, *PANDA.position_limits.T)
    assert q.shape == (150, 7)
    assert np.all((q >= low) & (q <= high))
    assert np.all(q.max(axis=0) - q.min(axis=0) > 0.9 * (high - low))
    assert len(np.unique(q[:, 0])) == 150
    assert whole.configurations == 150
    assert whole.complete
    assert arrays(whole)["configurations"].tolist() == [64, 64, 22]


def test_its_values_are_those_of_the_report_of_each_configuration(whole):
    data = arrays(whole)
    assert data["set"].tolist()[7] == "panda_joint1+panda_joint2"
    for place in (0, 63, 64, 149):
        report = sr.tolerance.report(PANDA, data["q"][place], k=2)
        expected = np.concatenate(report.relative)
        np.testing.assert_allclose(data["every_relative"][place], expected, atol=1e-13)
        assert float(data["every_speed"][place]) == pytest.approx(report.speed, rel=1e-9)
        np.testing.assert_allclose(data["every_speed_after"][place], np.concatenate(report.speeds), atol=1e-10)
        assert int(data["every_depth"][place]) <= report.depth


def test_what_is_reduced_is_what_is_kept(whole):
    data, names = arrays(whole), np.array(["+".join(joints) for joints in whole.sets])
    np.testing.assert_array_equal(data["set"], names)
    every, speed = data["every_relative"], data["every_speed_after"]
    sizes = data["set_size"]
    for joint in range(7):
        counts = np.histogram(np.sqrt(np.sqrt(every[:, joint])), bins=len(EDGES) - 1, range=(0.0, 1.0))[0]
        np.testing.assert_array_equal(whole.total("relative")[joint], counts)
        inner = np.histogram(speed[:, joint], bins=[0.0, *SPEEDS, np.inf])[0]
        np.testing.assert_array_equal(whole.total("speed_joint")[joint], inner)
        assert whole.remaining()[joint] == pytest.approx(np.median(every[:, joint]), rel=0.08, abs=1e-6)
    for size in (1, 2):
        own = every[:, sizes == size]
        worst = own.min(axis=1)
        joints, left, q = whole.weakest(size)
        assert left == worst.min()
        place = int(np.argmin(worst))
        np.testing.assert_array_equal(q, data["q"][place])
        assert "+".join(joints) == names[sizes == size][np.argmin(own[place])]
        assert whole.strongest(size)[1] == worst.max()
        usual = np.bincount(np.argmin(own, axis=1), minlength=own.shape[1])
        np.testing.assert_array_equal(whole.total("worst_set")[sizes == size], usual)
    depth = np.bincount(data["every_depth"] + 1, minlength=4)
    np.testing.assert_array_equal(whole.total("depth"), depth)
    points = PANDA.forward(data["q"])[:, :3, 3]
    edges = np.linspace(-PANDA.reach, PANDA.reach, 49)
    for plane, (across, up) in enumerate(((0, 1), (0, 2))):
        counts = np.histogram2d(points[:, up], points[:, across], bins=[edges, edges])[0]
        np.testing.assert_array_equal(whole.total("map_count")[plane], counts)
        sums = np.histogram2d(points[:, up], points[:, across], bins=[edges, edges], weights=every[:, :7].min(axis=1))
        np.testing.assert_allclose(whole.total("map_sum")[plane], sums[0], atol=1e-12)
    assert whole.total("map_best").max() == whole.strongest(1)[1]


def test_a_survey_does_not_depend_on_threads(whole, tmp_path):
    again = sr.tolerance.survey(
        PANDA, tmp_path / "x", samples=150, k=2, chunk=64, seed=5, metrics=ALL[:3], keep="all", threads=1
    )
    assert_same(whole, again)
    loaded = sr.tolerance.Survey.load(tmp_path / "x")
    assert str(loaded) == str(whole)
    assert loaded.facts() == whole.facts()


def test_other_seeds_give_other_configurations(tmp_path):
    settings = {"samples": 40, "chunk": 20, "keep": "all", "k": 1, "metrics": "depth"}
    q = [arrays(sr.tolerance.survey(PANDA, tmp_path / str(seed), seed=seed, **settings))["q"] for seed in (1, 2)]
    assert len(np.unique(np.concatenate(q)[:, 0])) == 80


def test_named_sets_are_those_of_all(whole, tmp_path):
    sets = [["panda_joint3", "panda_joint1"], "panda_joint4", 1]
    settings = {"samples": 150, "chunk": 64, "seed": 5, "metrics": ("relative", "speed"), "failures": sets}
    found = sr.tolerance.survey(PANDA, tmp_path / "x", **settings)
    assert found.sets == (("panda_joint2",), ("panda_joint4",), ("panda_joint1", "panda_joint3"))
    every, speed = (arrays(whole)[name] for name in ("every_relative", "every_speed_after"))
    names = arrays(whole)["set"].tolist()
    single, pair = every[:, [1, 3]], every[:, names.index("panda_joint1+panda_joint3")]
    assert found.weakest(1)[1] == single.min()
    assert found.strongest(1)[1] == single.min(axis=1).max()
    assert found.weakest(2)[1] == pair.min()
    np.testing.assert_array_equal(found.total("worst_set"), [*np.bincount(np.argmin(single, axis=1)), 150])
    counts = np.histogram(speed[:, [1, 3]].min(axis=1), bins=[0.0, *SPEEDS, np.inf])[0]
    np.testing.assert_array_equal(found.total("speed_worst")[0], counts)


def test_a_grid_goes_over_the_limits(tmp_path):
    limits = np.array([[-np.inf, np.inf], [-1.0, 2.0], [0.5, 0.5]])
    arm = sr.arms.planar(3).with_limits(position=limits, velocity=1.0)
    found = sr.tolerance.survey(arm, tmp_path / "x", grid=(4, 3, 1), k=1, task=PLANE, keep="all", chunk=5)
    q = arrays(found)["q"]
    assert len(q) == 12
    np.testing.assert_allclose(np.unique(q[:, 0]), np.pi * np.array([-1.0, -0.5, 0.0, 0.5]))  # a turn has no two ends
    np.testing.assert_allclose(np.unique(q[:, 1]), [-1.0, 0.5, 2.0])
    np.testing.assert_allclose(q[:, 2], 0.5)
    assert len(np.unique(q, axis=0)) == 12


def test_the_reach_of_a_planar_arm_is_that_which_is_known(tmp_path):
    """Unit links, no limits: with a joint locked two links of known lengths are left, which reach a ring."""
    arm = sr.arms.planar(3)
    found = sr.tolerance.survey(arm, tmp_path / "x", samples=400, k=1, metrics="reach", task=PLANE, keep="all", seed=2)
    q, goal = (arrays(found)[name] for name in ("q", "goal"))
    turns = np.exp(1j * np.cumsum(goal, axis=1)).sum(axis=1)
    first = np.exp(1j * q[:, 0])
    second, third = np.abs(1.0 + np.exp(1j * q[:, 1])), np.abs(1.0 + np.exp(1j * q[:, 2]))
    distance = [np.abs(turns - first), np.abs(turns), np.abs(turns)]
    rings = [
        (0.0 * second, 2.0 + 0.0 * second),
        (np.abs(second - 1.0), second + 1.0),
        (np.abs(third - 1.0), third + 1.0),
    ]
    after = arrays(found)["every_reach_after"]
    for joint, (low, high) in enumerate(rings):
        clear = np.minimum(np.abs(distance[joint] - low), np.abs(distance[joint] - high)) > 1e-3
        assert clear.sum() > 350
        expected = (distance[joint] > low) & (distance[joint] < high)
        np.testing.assert_array_equal(after[clear, joint], expected[clear])
    assert arrays(found)["every_reach_before"].all()
    np.testing.assert_array_equal(found.total("reach_after"), after.sum(axis=0))
    np.testing.assert_allclose(found.reached, after.mean(axis=0))
    assert found.ranking[0] == int(np.argmin(after.mean(axis=0)))


def test_the_baseline_is_computed_whatever_this_process_has(tmp_path):
    settings = {"samples": 500, "k": 1, "chunk": 250}
    found = sr.tolerance.survey(PANDA, tmp_path / "x", baseline=True, **settings)
    assert opened(found.path).attrs["instruction_set"] == "baseline"
    assert found.complete
    if store.Build.here().instructions == "baseline":
        return
    usual = sr.tolerance.survey(PANDA, tmp_path / "y", **settings)
    np.testing.assert_allclose(found.total("weakest"), usual.total("weakest"), rtol=1e-6, atol=1e-12)
    assert opened(usual.path).attrs["instruction_set"] != "baseline"
    with pytest.raises(InputError, match=r"begun by .* with baseline"):
        sr.tolerance.survey(PANDA, tmp_path / "x", **settings)


def test_memory_does_not_grow_with_the_configurations(tmp_path):
    """10 million with STILLREACH_FULL=1."""
    if not Path("/proc/self/status").exists():
        pytest.skip("needs /proc")
    count = 10_000_000 if FULL else 300_000
    command = [sys.executable, "-m", "tests.unit.tolerance.killed_survey", str(tmp_path / "x"), str(count), "measure"]
    done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    assert float(done.stdout) < 1000.0
    assert sr.tolerance.Survey.load(tmp_path / "x").configurations == count


def test_keeping_all_says_first_how_much_that_is(tmp_path, capsys):
    sr.tolerance.survey(PANDA, tmp_path / "x", samples=1000, k=1, metrics="relative", keep="all")
    said = capsys.readouterr().err
    assert "3 arrays of every configuration, 0 MB before compression" in said
    sr.tolerance.survey(PANDA, tmp_path / "x", samples=1000, k=1, metrics="relative", keep="all")
    assert capsys.readouterr().err == ""


def test_a_part_of_a_histogram_lies_below_a_quantile():
    edges = np.arange(11.0)
    counts = np.array([0, 0, 4, 0, 4, 0, 0, 0, 0, 2])
    assert quantile(counts, edges, 0.2) == 2.5
    assert quantile(counts, edges, 0.5) == pytest.approx(4.25)
    assert quantile(counts, edges, 1.0) == 10.0
    assert np.isnan(quantile(0 * counts, edges, 0.5))
    assert quantile(counts + np.eye(10)[0] * 20, edges, 0.5) == 0.0  # too small to be told from 0


def test_a_picture_has_a_panel_for_each_finding(tmp_path):
    pytest.importorskip("matplotlib").use("agg")
    found = sr.tolerance.survey(PANDA, tmp_path / "x", samples=60, k=1, metrics=ALL, starts=3)
    figure = found.plot()
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert sum(title.startswith("what the worst joint leaves, from") for title in titles) == 2
    first, second = (axes.collections[0] for axes in figure.axes if axes.get_ylabel() in ("y [m]", "z [m]"))
    assert first.get_clim() == second.get_clim()
    counts, sums = found.total("map_count")[0], found.total("map_sum")[0]
    np.testing.assert_allclose(first.get_array().compressed(), 100 * sums[counts > 0] / counts[counts > 0])
    assert sum(title == "without each joint: median, and 5 to 95 %" for title in titles) == 2
    ranking = next(axes for axes in figure.axes if "remaining" in axes.get_xlabel())
    assert [label.get_text() for label in ranking.get_yticklabels()] == [PANDA.joint_names[j] for j in found.ranking]
    depth = next(axes for axes in figure.axes if axes.get_ylabel() == "configurations [%]")
    heights = [bar.get_height() for bar in depth.patches]
    np.testing.assert_allclose(heights, found.total("depth") / 0.6)
    reach = next(axes for axes in figure.axes if axes.get_xlabel() == "poses reached [%]")
    widths = [bar.get_width() for bar in reach.patches]
    np.testing.assert_allclose(widths[1:], np.sort(100 * found.reached))
    alone = sr.tolerance.survey(PANDA, tmp_path / "y", samples=60, k=1, metrics="depth")
    assert len(alone.plot().axes) == 1
    pairs = sr.tolerance.survey(PANDA, tmp_path / "z", samples=2, k=2, metrics="reach", starts=1)
    labels = [label.get_text() for label in pairs.plot().axes[0].get_yticklabels()]
    assert sorted(labels) == ["all joints", *PANDA.joint_names]


def test_shares_near_nothing_are_not_told_apart(tmp_path):
    """With its second joint near zero a Panda loses nearly all with some of its joints."""
    q = np.tile([0.3, 1e-9, 0.4, -1.5, 0.2, 1.5, 0.1], (4, 1))
    cells = [row[1] for row in sr.tolerance.survey(PANDA, tmp_path / "x", q=q, k=1, metrics="relative").table()]
    assert "<0.01 %" in cells
    assert not any("e-" in cell for cell in cells)


def test_a_line_of_a_picture_does_not_begin_with_a_per_cent_sign():
    text = "It reaches 100 % of the positions and 7 % of the poses"
    for width in range(12, 40):
        lines = wrapped(text, width)
        assert len(lines) > 1
        assert not any(line.startswith("%") for line in lines)
        assert " ".join(lines).replace("\N{NO-BREAK SPACE}", " ") == text


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"arm": 3}, "arm: got 3"),
        ({"samples": 0}, "samples: got 0"),
        ({"grid": 2}, "grid: got a value beside samples"),
        ({"samples": None, "grid": (2, 2)}, "grid: got 2 numbers, expected a number of steps, or 7"),
        ({"samples": None, "grid": 2.5}, "grid: got 2.5"),
        ({"failures": [2.5]}, "joint: got 2.5"),
        ({"client": 3}, "client: got 3"),
        ({"samples": None, "grid": 10**3}, "grid: got 1000000000000000000000 configurations"),
        ({"samples": None, "poses": [[1.0]]}, "poses: got"),
        ({"k": 8}, "k: got 8, expected at most the 7 joints"),
        ({"failures": ["panda_joint1"], "k": 1}, "k: got 1, expected None beside failures"),
        ({"failures": "panda_joint1"}, "failures: got"),
        ({"failures": []}, "failures: got 0 sets"),
        ({"metrics": "speeds"}, "metrics: got 'speeds'"),
        ({"metrics": ()}, "metrics: got"),
        ({"keep": "some"}, "keep: got 'some'"),
        ({"chunk": 0}, "chunk: got 0"),
        ({"seed": -1}, "seed: got -1"),
        ({"threads": 0}, "threads: got 0"),
        ({"task": 3}, "task: got 3"),
        ({"samples": None, "q": [[1.0]]}, "q: got .*, expected configurations"),
        ({"q": np.zeros((2, 7))}, "q: got a value beside samples, expected one of samples, grid, poses, q"),
    ],
)
def test_mistakes(options, said, tmp_path):
    with pytest.raises(InputError, match=said):
        sr.tolerance.survey(**{"arm": PANDA, "out": tmp_path / "x", "samples": 10, **options})
    assert list(tmp_path.iterdir()) == []


def test_other_mistakes(whole, tmp_path, monkeypatch):
    with pytest.raises(UnknownJointError):
        sr.tolerance.survey(PANDA, tmp_path / "x", failures=["j99"])
    with pytest.raises(InputError, match="name: got 'reach_after'"):
        whole.total("reach_after")
    with pytest.raises(InputError, match="size: got 3, expected the size of a set"):
        whole.weakest(3)
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(MissingExtraError, match=r"a survey needs .*stillreach\[survey\]"):
        sr.tolerance.survey(PANDA, tmp_path / "x", samples=10)


def test_the_command(tmp_path):
    options = ["--samples", "300", "-k", "1", "--metric", "relative", "--metric", "depth", "--seed", "3"]
    done = run_command("survey", "panda", *options, "--json", folder=tmp_path)
    facts = json.loads(done.out)
    own = sr.tolerance.survey(PANDA, tmp_path / "own", samples=300, k=1, metrics=("relative", "depth"), seed=3)
    assert facts["ranking"] == own.facts()["ranking"]
    assert facts["depth"] == own.facts()["depth"]
    assert [Path(file).name for file in facts["files"]][:2] == ["survey.zarr", "survey.json"]
    assert all((tmp_path / file).exists() for file in facts["files"])
    printed = " ".join(run_command("survey", "panda", *options, "--no-plot", folder=tmp_path).out.split())
    assert own.verdict in printed
    assert printed.startswith("300 configurations of panda:")
    other = run_command("survey", "panda", *options, "--seed", "4", folder=tmp_path)
    assert other.code == 2
    assert "a survey with another seed" in other.err
    for wrong, said in (
        (["--grid", "2,x"], "--grid: got '2,x'"),
        (["--lose", "j9"], "'j9'"),
        (["--metric", "x"], "metrics: got 'x'"),
        (["--scheduler", "nonsense://1"], "--scheduler: got 'nonsense://1'"),
    ):
        refused = run_command("survey", "panda", *wrong, "--out", "new", folder=tmp_path)
        assert refused.code == 2, refused
        assert said in refused.err


def test_xarray_reads_it_with_labels(whole):
    pytest.importorskip("xarray")
    data = whole.dataset
    assert data["relative"].dims == ("chunk", "joint", "bin")
    assert data["relative"].dtype == np.int64
    assert data["q"].attrs["long_name"] == "joint positions"
    own = data["weakest_q"].sel(size=1, joint="panda_joint4").min()
    assert float(own) == data["weakest_q"].to_numpy()[:, 0, 3].min()
    assert data.attrs["title"] == "survey of panda"
