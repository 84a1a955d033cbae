"""What a page holds: arrays bit for bit, texts that stay texts, a size that a mail takes."""

import gzip
import json
import re
from base64 import b64decode
from dataclasses import replace

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError, page
from stillreach.errors import PageNotBuiltError
from stillreach.page.pack import pack
from stillreach.page.replay import MOST_NUMBERS, replay_of
from stillreach.page.task import task_of
from tests.commands import run_command

PANDA = sr.arms.panda()
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
HOSTILE = "</script><script>alert(1)</script>\u2028 & \"'"

try:
    PANDA.page(START)
    BUILT = True
except PageNotBuiltError:
    BUILT = False
needs_page = pytest.mark.skipif(not BUILT, reason="the page's program was not built: it needs Node.js")


def unpacked(document, block):
    """The inverse of pack, transcribed from its description."""
    raw = gzip.decompress(b64decode(block))

    def array(dtype, shape, offset):
        dtype, count = np.dtype(dtype), int(np.prod(shape))
        if dtype == np.int8:
            return np.frombuffer(raw, np.int8, count, offset).reshape(shape)
        planes = np.frombuffer(raw, np.uint8, count * dtype.itemsize, offset).reshape(dtype.itemsize, count)
        unsigned = np.ascontiguousarray(planes.T).view(f"u{dtype.itemsize}").ravel()
        one = unsigned.dtype.type(1)
        second = (unsigned >> one) ^ (-(unsigned & one).astype(f"i{dtype.itemsize}")).view(unsigned.dtype)
        columns = second.reshape(-1, shape[0]).T.copy()
        steps = np.concatenate([0 * columns[:1], np.cumsum(columns[1:], axis=0, dtype=unsigned.dtype)])
        whole = columns[:1] + np.cumsum(steps, axis=0, dtype=unsigned.dtype)
        return np.ascontiguousarray(whole).view(dtype).reshape(shape)

    return json.loads(document, object_hook=lambda d: array(*d["array"]) if "array" in d else d)


def test_arrays_come_back_to_the_last_bit():
    rng = np.random.default_rng(1)
    arrays = {
        "smooth": np.cumsum(rng.normal(size=(400, 3)), axis=0),
        "wild": rng.integers(0, 2**63, size=(50, 2), dtype=np.int64).view(np.float64),
        "odd": np.array([0.0, -0.0, np.inf, -np.inf, 5e-324, -1e308]),
        "single": rng.normal(size=(30, 4)).astype(np.float32),
        "codes": rng.integers(-(2**31), 2**31, size=40).astype(np.int32),
        "small": rng.integers(-128, 128, size=(9, 5)).astype(np.int8),
        "one": np.array([3.5]),
    }
    back = unpacked(*pack({"in": [arrays]}))["in"][0]
    for name, array in arrays.items():
        assert back[name].dtype == array.dtype
        assert back[name].tobytes() == array.tobytes(), name


def test_a_commanded_motion_packs_to_a_third():
    scenario = sr.Scenario.load("snake-loses-five")
    task, notes = task_of(scenario, planned=True)
    assert not notes
    raw = sum(part["twists"].nbytes + part["poses"].nbytes for part in task["parts"])
    assert len(b64decode(pack(task["parts"])[1])) < raw / 3


@needs_page
def test_texts_with_markup_are_texts():
    arm = sr.Arm([replace(joint, name=f"{HOSTILE}{k}") for k, joint in enumerate(PANDA.joints)], tool=PANDA.tool)
    text = arm.page(START).html
    document = re.search(r'id="stillreach-document">(.*?)</script>', text, re.DOTALL)[1]
    assert json.loads(document)["tasks"][0]["arm"]["joints"][0]["name"] == HOSTILE + "0"
    assert "alert(1)</script>" not in text
    named = replace(sr.Scenario.load("panda-elbow"), name=HOSTILE).page().html
    assert "<script>alert" not in named


@needs_page
def test_a_page_is_small_and_asks_for_nothing():
    text = PANDA.page().html
    assert len(text.encode()) < 1.2e6
    outside = re.sub(r'id="stillreach-(document|block|core)">.*?</script>', "", text, flags=re.DOTALL)
    assert not re.findall(r'(?:src|href)\s*=\s*"(?!data:)', outside)
    assert not re.search(r"\bfetch\(|XMLHttpRequest|import\(|@import|url\(", outside.replace("data:,", ""))


def test_a_long_run_is_thinned_and_says_so():
    scenario = sr.Scenario(arm=PANDA, start=START, motion=sr.ConstantTwist([0.01] * 6), duration=30.0, period=0.001)
    drawn, notes = replay_of(sr.simulate(scenario, progress=False), "long")
    assert len(drawn["tick"]) * (2 * 7 + 8) <= 1.3 * MOST_NUMBERS
    assert len(b64decode(pack(drawn)[1])) < 1e6
    assert re.fullmatch(r"long: [\d,]+ of its 30,001 ticks are drawn\.", notes[0])
    assert drawn["tick"][[0, -1]].tolist() == [0, 30_000]


def test_what_the_page_cannot_do_it_says():
    base = sr.Scenario.load("panda-elbow")
    too_long = replace(base, motion=sr.ConstantTwist([0.0] * 6), duration=200.0, period=0.001, faults=())
    task, notes = task_of(too_long, planned=True)
    assert task["parts"] == []
    assert notes == ["The page computes at most 100,000 ticks; this task has 200,000."]
    own = replace(base, null_motion=sr.null_motions.Gradient(gradient=lambda q: 0.0 * q))
    assert "Python function" in task_of(own, planned=True)[1][0]
    physical = replace(base, plant=sr.plants.MujocoPlant())
    assert "without inertia" in task_of(physical, planned=True)[1][0]


@needs_page
def test_runs_of_one_arm_alone_are_shown_together():
    run = sr.simulate(sr.Scenario.load("panda-elbow"), progress=False)
    other = sr.simulate(sr.Scenario.load("paper-example-1"), progress=False)
    with pytest.raises(InputError, match="runs: got different arms or tools, expected runs of one arm"):
        run.page(other)
    assert "<iframe srcdoc=" in run.page(run)._repr_html_()


@needs_page
def test_the_command_knows_what_it_is_given(tmp_path):
    run = sr.simulate(sr.Scenario.load("panda-elbow"), progress=False)
    run.save(tmp_path / "run.npz")
    for arguments in (["panda"], ["panda-elbow", "--fail", "panda_joint2@3"], [str(tmp_path / "run.npz")] * 2):
        found = run_command("view", *arguments, "--no-browser", "--out", str(tmp_path / "out"))
        assert found.code == 0, found.err
        assert (tmp_path / "out" / "view.html").stat().st_size > 500_000
    for arguments, message in (
        (["panda", "panda-elbow"], "WHAT: got 2 things, expected one, or several runs"),
        (["panda", "--law", "keep-direction"], "--law: got 'keep-direction', expected a scenario"),
        (["nosuch.urdf"], "ROBOT: got 'nosuch.urdf'"),
    ):
        found = run_command("view", *arguments, "--no-browser")
        assert found.code == 2
        assert message in found.err


def test_without_its_program_it_says_how_to_get_it(monkeypatch, tmp_path):
    monkeypatch.setattr(page.resources, "files", lambda package: tmp_path)
    with pytest.raises(PageNotBuiltError, match="run 'make page' in the sources"):
        PANDA.page(START)
