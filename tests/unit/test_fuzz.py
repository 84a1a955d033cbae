"""A few of the files that `python tests/fuzz.py` spoils, more with STILLREACH_FULL=1; it sees what it should see."""

import os
import random

import pytest

from tests.fuzzing import corpus, planted, spoil, toml
from tests.fuzzing.campaign import SOUND, Job, campaign
from tests.fuzzing.targets import KINDS, made, outcome

FILES = 1000 if os.environ.get("STILLREACH_FULL") else 400


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.timeout(600)
def test_spoiled_files_are_taken_or_refused(kind, tmp_path, capsys):
    tally = campaign(Job(kind, KINDS[kind], seed=1, save=tmp_path), FILES)
    with capsys.disabled():
        print(f"\n  {kind}: {dict(tally.outcomes)}, slowest {tally.slowest[0]:.2f} s", end="")
    assert tally.files == FILES
    assert [(index, what, told(tmp_path, index)) for index, what in tally.failures] == []
    assert min(tally.outcomes[what] for what in SOUND) >= FILES / 20


def told(folder, index):
    """What was saved beside a file that failed."""
    return "".join(path.read_text(encoding="utf-8") for path in folder.glob(f"*-{index}.txt"))


@pytest.mark.parametrize("kind", KINDS)
def test_the_files_that_are_spoiled_are_sound(kind, tmp_path):
    corpus.set_out(tmp_path)
    path = tmp_path / f"sound{KINDS[kind].suffix}"
    for data in KINDS[kind].files():
        path.write_bytes(data)
        assert outcome(KINDS[kind], path, random.Random(0))[:2] == ("accepted", None), data.decode()


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_is_the_same_in_every_run_and_unlike_the_others(kind):
    files = KINDS[kind].files()
    once, again = ([made(kind, KINDS[kind], files, 7, k)[0] for k in range(40)] for _ in range(2))
    assert once == again
    assert len(set(once)) >= 35
    assert sum(data in files for data in once) <= 5


def test_numbers_beyond_any_float_are_changed_like_others():
    content = {"a": 10**400, "b": -(10**400), "c": 1e308}
    changed = [toml.mutated(random.Random(k), toml.written(content).encode()) for k in range(400)]
    assert sum(data != toml.written(content).encode() for data in changed) > 300


def test_each_way_of_spoiling_bytes_changes_something():
    files = KINDS["urdf"].files()
    for way in set(spoil.WAYS):
        assert any(way(random.Random(k), files[0], files) != files[0] for k in range(20)), way.__name__


def planted_campaign(defect, often, folder, silence):
    """The tally of 24 files of which some meet the defect; each of those must have been saved."""
    tally = campaign(Job("planted", planted.kind(defect, often), seed=7, save=folder), 24, silence=silence)
    assert tally.files == 24 == tally.outcomes.total()
    assert set(SOUND) < set(tally.outcomes)
    for index, what in tally.failures:
        assert told(folder, index).startswith(what)
        assert (folder / f"planted-7-{index}.bin").exists()
    return tally


def test_errors_warnings_slow_files_and_hunger_for_memory_are_found(tmp_path):
    tally = planted_campaign(planted.errs, 0.5, tmp_path, 60.0)
    expected = {"raised KeyError", "raised RuntimeWarning", "raised MemoryError", "slow: over 1 s"}
    assert {what for _, what in tally.failures} == expected


@pytest.mark.parametrize(("defect", "what"), [(planted.crashes, "crash: exit code -11"), (planted.hangs, "hang")])
def test_a_crash_or_a_hang_is_found_and_the_rest_is_read(defect, what, tmp_path):
    tally = planted_campaign(defect, 0.06, tmp_path, 8.0)
    assert {what for _, what in tally.failures} == {what}
    stood = [told(tmp_path, index) for index, _ in tally.failures]
    assert all(("processor time" in text and "planted.py" in text) is (what == "hang") for text in stood)
