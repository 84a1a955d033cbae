"""The folder of a survey: a kill changes nothing, and that of another survey is refused."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import stillreach as sr
from stillreach import InputError
from tests.unit.tolerance import killed_survey
from tests.unit.tolerance.test_survey import assert_same

ROOT = Path(__file__).parents[3]


def finished(folder):
    """Files of finished chunks, and when they were written."""
    if not (folder / "done").is_dir():
        return {}
    return {path.name: path.stat().st_mtime_ns for path in (folder / "done").iterdir() if path.name.isdecimal()}


@pytest.mark.parametrize(
    ("survey", "count", "word"), [(killed_survey.survey, 1600, []), (killed_survey.of_poses, 800, ["poses"])]
)
def test_a_killed_survey_goes_on_and_ends_as_one_that_ran_through(survey, count, word, tmp_path):
    folder = tmp_path / "killed"
    command = [sys.executable, "-m", "tests.unit.tolerance.killed_survey", str(folder), str(count), *word]
    process = subprocess.Popen(command, cwd=ROOT)
    while len(finished(folder)) < 3 and process.poll() is None:
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.wait()
    before = finished(folder)
    assert 3 <= len(before) < 16
    assert not sr.tolerance.Survey.load(folder).complete
    resumed = survey(folder, count)
    after = finished(folder)
    assert len(after) == 16
    assert {name: after[name] for name in before} == before  # none was computed again
    through = survey(tmp_path / "through", count)
    assert_same(resumed, through)
    files = [
        sorted(path.relative_to(top) for path in top.rglob("*") if path.is_file()) for top in (folder, through.path)
    ]
    assert [name for name in files[0] if not name.name.endswith(".partial")] == files[1]
    for name in files[1]:
        assert (folder / name).read_bytes() == (through.path / name).read_bytes(), name


def test_a_survey_that_is_done_is_only_read(tmp_path, monkeypatch):
    found = killed_survey.survey(tmp_path / "x", 100)
    monkeypatch.setattr("stillreach.tolerance.surveys.run.measured", None)
    assert_same(killed_survey.survey(tmp_path / "x", 100), found)
    with pytest.raises(
        InputError, match=r"out: got the folder .* of this survey, expected a new folder, or resume=True"
    ):
        killed_survey.survey(tmp_path / "x", 100, resume=False)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seed": 8}, "a survey with another seed"),
        ({"chunk": 30}, "another size of chunks"),
        ({"k": 1}, "other sets of joints"),
        ({"metrics": "relative"}, "other metrics"),
        ({"count": 101}, "other configurations"),
        ({"keep": "reduced"}, "another keep"),
        ({"task": sr.Task(rows="position")}, "another task"),
    ],
)
def test_the_folder_of_another_survey_is_refused(change, said, tmp_path):
    killed_survey.survey(tmp_path / "x", 100)
    settings = {"count": 100, **change}
    with pytest.raises(InputError, match=said):
        killed_survey.survey(tmp_path / "x", **settings)


def test_other_folders_are_refused(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "thesis.txt").write_text("x")
    for name in ("file", "folder"):
        with pytest.raises(InputError, match=r"out: got .*which is something else"):
            killed_survey.survey(tmp_path / name, 10)
    with pytest.raises(FileNotFoundError, match="no such folder"):
        sr.tolerance.Survey.load(tmp_path / "none")
    killed_survey.survey(tmp_path / "x", 10)
    other = sr.tolerance.survey
    with pytest.raises(InputError, match="another robot"):
        other(sr.arms.snake(11), tmp_path / "x", samples=10, **{**killed_survey.SETTINGS, "metrics": "relative"})
    attributes = json.loads((tmp_path / "x" / ".zattrs").read_text())
    (tmp_path / "x" / ".zattrs").write_text(json.dumps({**attributes, "build": '["0.0.1", "avx2", "x86_64"]'}))
    with pytest.raises(InputError, match=r"begun by stillreach 0\.0\.1 with avx2 on x86_64"):
        killed_survey.survey(tmp_path / "x", 10)
    (tmp_path / "x" / ".zattrs").write_text(json.dumps({**attributes, "format": 99}))
    with pytest.raises(InputError, match="a survey of format 99"):
        killed_survey.survey(tmp_path / "x", 10)
