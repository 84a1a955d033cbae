"""`stillreach run` and `compare`: files, numbers, exit codes."""

import json
import re
import sys

import numpy as np
import pytest
from matplotlib import image

import stillreach as sr


def test_a_run_that_arrives_writes_its_record_picture_and_summary(stillreach, tmp_path):
    done = stillreach("run", "reach.toml")
    assert (done.code, done.err) == (0, "")
    folder = tmp_path / "out" / "reach"
    assert {path.name for path in folder.iterdir()} == {"run.nc", "run.png", "summary.json"}
    record = sr.Run.load(folder / "run.nc")
    same = sr.simulate(sr.Scenario.load(tmp_path / "reach.toml"))
    np.testing.assert_array_equal(record.q, same.q)
    pixels = image.imread(folder / "run.png")
    assert pixels.shape[0] > 600
    assert pixels.shape[1] > 1000
    assert np.ptp(pixels[..., :3]) == 1.0


def test_the_summary_says_what_the_record_holds(stillreach, tmp_path):
    found = json.loads(stillreach("run", "reach.toml", "--json", "--no-plot").out)
    record = sr.Run.load(tmp_path / "out" / "reach" / "run.nc")
    arm = sr.arms.nasa_modular()
    goal = arm.forward(record.q[0])[:3, 3] + [-0.2, 0.0, 0.0]
    off = np.linalg.norm(goal - arm.forward(record.q[-1])[:3, 3])
    assert found["goal_distance"] == pytest.approx(off, abs=1e-12)
    assert found["way"] == pytest.approx(0.2)
    assert found["turn"] == 0.0
    assert found["finished"] is True
    assert found["ticks"] == len(record) == 41
    largest = np.max(np.abs(record.rates)) / np.deg2rad(50.0)
    assert found["largest_rate"]["of_limit"] == pytest.approx(largest)
    assert found["faults"] == [{"joint": "j4", "kind": "locked", "at": 1.0, "until": None, "known_after": 0.0}]
    assert found["statuses"]["OK"] == np.mean(record.status == 0)


def test_an_arm_that_does_not_arrive_exits_with_1_and_says_so(stillreach):
    done = stillreach("run", "too-far.toml", "--no-plot")
    assert done.code == 1
    assert "NO, " in done.out
    assert json.loads(stillreach("run", "too-far.toml", "--no-plot", "--json").out)["finished"] is False


def test_rates_that_no_drive_follows_are_told_beside_the_verdict(stillreach):
    slow = ("--fail", "j2@1:derated=0.01", "--fail", "j8@1:derated=0.01", "--no-plot")
    done = stillreach("run", "reach.toml", "--law", "pseudoinverse", *slow)
    assert done.code == 0
    assert "but drives cannot follow" in " ".join(done.out.split())
    assert "cannot follow" not in stillreach("run", "reach.toml", *slow).out
    both = stillreach("compare", "reach.toml", "--laws", "least-error,pseudoinverse", *slow).out
    assert "above 100 %: drives cannot follow" in both
    assert "cannot follow" not in stillreach("compare", "reach.toml", "--laws", "least-error", *slow).out


def test_a_scenario_as_it_stands_is_told_in_its_own_words(stillreach, tmp_path):
    text = (tmp_path / "reach.toml").read_text()
    words = "What this\nshows, in two lines."
    (tmp_path / "told.toml").write_text(f'description = """\n{words}\n\nMore for readers."""\n{text}')
    out = stillreach("run", "told.toml", "--no-plot").out
    assert "\nWhat this shows, in two lines.\n\narrived" in out
    assert "More" not in out
    for change in (("--law", "keep-direction"), ("--fail", "j2@1"), ("--healthy",)):
        assert "What this" not in stillreach("run", "told.toml", "--no-plot", *change).out


def test_a_law_that_is_late_and_on_its_path_is_told_from_one_that_leaves_it(stillreach):
    slow = [f"--fail=j{k}@0.5:derated=0.02" for k in range(1, 12)]
    done = stillreach("compare", "reach.toml", "--no-plot", "--laws", "keep-direction,singularity-robust", *slow)
    assert "keep-direction falls behind, by up to" in done.out
    assert "singularity-robust falls behind" not in done.out
    assert "\noff its path     at most " in stillreach("run", "reach.toml", "--no-plot").out


def test_within_moves_the_line_between_arrived_and_not(stillreach):
    off = json.loads(stillreach("run", "too-far.toml", "--no-plot", "--json").out)
    wide = f"{1.01 * off['goal_distance']}m,{1.01 * off['goal_angle']}rad"
    narrow = f"{0.99 * off['goal_distance']}m,180deg"
    assert stillreach("run", "too-far.toml", "--no-plot", "--within", wide).code == 0
    assert stillreach("run", "too-far.toml", "--no-plot", "--within", narrow).code == 1


def test_json_is_all_that_stdout_holds_and_what_the_file_holds(stillreach, tmp_path):
    done = stillreach("run", "reach.toml", "--json")
    found = json.loads(done.out)
    files = found.pop("files")
    assert files == [f"out/reach/{name}" for name in ("run.nc", "summary.json", "run.png")]
    assert json.loads((tmp_path / "out" / "reach" / "summary.json").read_text()) == found


def test_options_change_law_and_faults(stillreach):
    found = json.loads(
        stillreach(
            *("run", "reach.toml", "--json", "--no-plot", "--healthy", "--law", "singularity-robust:norm=2"),
            *("--fail", "j2@0.5:derated=0.3", "--fail", "j11:runaway=2deg", "--fail", "j6"),
        ).out
    )
    assert (found["law"]["kind"], found["law"]["norm"]) == ("singularity-robust", "2")
    forever = {"until": None, "known_after": 0.0}
    assert found["faults"] == [
        {"joint": "j2", "kind": "derated", "fraction": 0.3, "at": 0.5, **forever},
        {"joint": "j11", "kind": "runaway", "rate": pytest.approx(np.deg2rad(2.0)), "at": 0.0, **forever},
        {"joint": "j6", "kind": "locked", "at": 0.0, **forever},
    ]


def test_the_law_of_an_option_keeps_the_weights_of_the_scenario(stillreach, tmp_path):
    weights = "task = { weights = { length = 0.5, angle = 2.0 } }\n"
    (tmp_path / "weighted.toml").write_text((tmp_path / "reach.toml").read_text() + weights)
    found = json.loads(stillreach("run", "weighted.toml", "--json", "--no-plot", "--law", "keep-direction").out)
    assert found["law"]["kind"] == "keep-direction"
    weights = sr.Scenario.load(tmp_path / "weighted.toml").task.weights
    assert (weights.length, weights.angle) != (1.0, 1.0)
    assert found["task"]["weights"] == {"length": weights.length, "angle": weights.angle, "task": None, "joints": None}


def test_a_law_of_the_scenarios_kind_keeps_its_settings_but_for_those_that_are_given(stillreach, tmp_path):
    text = (tmp_path / "reach.toml").read_text()
    (tmp_path / "gain.toml").write_text(text + 'law = { kind = "least-error", price = 55 }\n')
    laws = "least-error,least-error:price=3,least-error:rank_tolerance=1e-9,keep-direction"
    found = json.loads(stillreach("compare", "gain.toml", "--json", "--no-plot", "--laws", laws).out)["laws"]
    assert [law["law"].get("price") for law in found.values()] == [55.0, 3.0, 55.0, None]


def test_without_extras_the_run_is_kept_and_the_user_told(stillreach, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5netcdf", None)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    done = stillreach("run", "reach.toml")
    assert done.code == 0
    assert "pip install 'stillreach[netcdf]'" in done.err
    assert "pip install 'stillreach[plot]'" in done.err
    folder = tmp_path / "out" / "reach"
    assert {path.name for path in folder.iterdir()} == {"run.npz", "summary.json"}
    same = sr.simulate(sr.Scenario.load(tmp_path / "reach.toml"))
    with np.load(folder / "run.npz") as arrays:
        np.testing.assert_array_equal(arrays["rates"], same.rates)
        assert tuple(arrays["joint"]) == same.joint_names
    record = sr.Run.load(folder / "run.npz")
    for name, array in same.arrays().items():
        np.testing.assert_array_equal(getattr(record, name), array)


def test_files_of_an_earlier_run_do_not_stay_beside_those_of_this_one(stillreach, tmp_path, monkeypatch):
    folder = tmp_path / "out" / "reach"
    stillreach("run", "reach.toml")
    (folder / "notes.txt").write_text("mine")
    stillreach("run", "reach.toml", "--no-plot", "--law", "keep-direction")
    assert {path.name for path in folder.iterdir()} == {"notes.txt", "run.nc", "summary.json"}
    with monkeypatch.context() as without:
        without.setitem(sys.modules, "h5netcdf", None)
        stillreach("run", "reach.toml", "--no-plot")
        assert {path.name for path in folder.iterdir()} == {"notes.txt", "run.npz", "summary.json"}
    stillreach("run", "reach.toml", "--no-plot")
    assert {path.name for path in folder.iterdir()} == {"notes.txt", "run.nc", "summary.json"}


def test_a_picture_that_fails_leaves_no_older_one(stillreach, tmp_path, monkeypatch):
    stillreach("run", "reach.toml")
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert stillreach("run", "reach.toml", "--plot").code == 2
    assert not (tmp_path / "out" / "reach" / "run.png").exists()


def test_records_of_laws_of_an_earlier_comparison_do_not_stay(stillreach, tmp_path):
    folder = tmp_path / "out" / "reach"
    stillreach("compare", "reach.toml", "--laws", "least-error,pseudoinverse,singularity-robust:norm=2")
    (folder / "mine.nc").write_text("mine")
    stillreach("compare", "reach.toml", "--laws", "least-error", "--no-plot")
    assert {path.name for path in folder.iterdir()} == {"compare.json", "least-error.nc", "mine.nc"}
    (folder / "compare.json").write_text("[]")
    assert stillreach("compare", "reach.toml", "--laws", "least-error", "--no-plot").code == 0


def test_a_picture_that_was_asked_for_and_cannot_be_drawn_is_an_error(stillreach, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    done = stillreach("run", "reach.toml", "--plot")
    assert done.code == 2
    assert done.err == "stillreach: a picture of a run needs an optional part: pip install 'stillreach[plot]'\n"


def test_out_is_where_files_go(stillreach, tmp_path):
    assert stillreach("run", "reach.toml", "--no-plot", "--out", "a/b c").code == 0
    assert (tmp_path / "a" / "b c" / "run.nc").exists()


def test_compare_runs_every_law_and_draws_them_together(stillreach, tmp_path):
    laws = "least-error,pseudoinverse,singularity-robust:damping=closed-form"
    done = stillreach("compare", "too-far.toml", "--laws", laws, "--out", "c")
    assert done.code == 0
    assert {path.name for path in (tmp_path / "c").iterdir()} == {
        "compare.json",
        "compare.png",
        "least-error.nc",
        "pseudoinverse.nc",
        "singularity-robust-damping-closed-form.nc",
    }
    found = json.loads((tmp_path / "c" / "compare.json").read_text())["laws"]
    assert list(found) == laws.split(",")
    assert found["least-error"]["largest_rate"]["of_limit"] <= 1.0
    assert found["pseudoinverse"]["largest_rate"]["of_limit"] > 1.0
    assert image.imread(tmp_path / "c" / "compare.png").shape[1] > 1000
    for law in ("least-error", "pseudoinverse"):
        assert law in done.out


def test_compare_agrees_with_run(stillreach):
    alone = json.loads(stillreach("run", "reach.toml", "--json", "--no-plot", "--law", "keep-direction").out)
    both = json.loads(stillreach("compare", "reach.toml", "--json", "--no-plot", "--laws", "keep-direction").out)
    alone.pop("files")
    assert both["laws"]["keep-direction"] == alone


def test_what_is_printed_fits_80_columns_without_colours(stillreach):
    for command in (
        ("run", "reach.toml", "--no-plot", "--out", "o"),
        ("compare", "too-far.toml", "--no-plot", "--out", "o", *(f"--fail=j{k}@1.{k}" for k in range(1, 6))),
        ("inspect", "canadarm2"),
        ("inspect", "snake30"),
        ("arms",),
        ("doctor",),
    ):
        printed = stillreach(*command).out
        lines = [line for line in printed.splitlines() if not line.startswith("wrote ")]
        assert max(map(len, lines)) <= 80
        assert "\x1b" not in printed


@pytest.mark.parametrize("columns", ["20", "47"])
def test_a_narrow_terminal_breaks_lines_and_cuts_no_number_short(stillreach, monkeypatch, columns):
    commands = [("compare", "too-far.toml", "--no-plot", "--laws", "least-error,keep-direction")]
    for command in (*commands, ("inspect", "canadarm2"), ("doctor",), ("arms",)):
        monkeypatch.setenv("COLUMNS", "80")
        wide = stillreach(*command).out.split()
        monkeypatch.setenv("COLUMNS", columns)
        assert stillreach(*command).out.split() == wide
    narrow = stillreach("run", "reach.toml", "--no-plot").out
    monkeypatch.setenv("COLUMNS", "80")
    wide = stillreach("run", "reach.toml", "--no-plot").out
    assert sorted("".join(narrow.split())) == sorted("".join(wide.split()))


def test_a_scenario_without_a_name_is_called_after_its_file_and_an_arm_at_rest_has_limits(stillreach, tmp_path):
    text = (tmp_path / "reach.toml").read_text().replace('name = "reach"', "").replace("[-0.1, 0, 0", "[0, 0, 0")
    (tmp_path / "rest.toml").write_text(text)
    done = stillreach("run", "rest.toml", "--no-plot")
    assert done.out.startswith("rest\nnasa_modular, LeastError, ")
    assert "0 % of its limit" in done.out
    assert stillreach("compare", "rest.toml", "--no-plot").out.startswith("rest\nnasa_modular, ")


def test_a_run_that_does_not_arrive_says_why_and_never_that_nothing_is_in_the_way(stillreach):
    done = stillreach("run", "too-far.toml", "--no-plot")
    found = json.loads(stillreach("run", "too-far.toml", "--no-plot", "--json").out)
    said = " ".join(done.out.split())
    assert f"why {found['why']['sentence']}" in said
    assert re.match(r"from .* s (on|to) .*the arm", found["why"]["sentence"])
    assert "nothing" not in said
    for part in found["gave_way"]:
        assert f"{part} by " in said
    both = stillreach("compare", "too-far.toml", "--no-plot", "--laws", "least-error").out
    assert f"least-error: {found['why']['sentence']}" in " ".join(both.split())
