"""The numbered scripts run as they stand, and are short."""

import os
import runpy
import sys
import time
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))
FULL = bool(os.environ.get("STILLREACH_FULL"))


def test_there_are_scripts_and_they_are_numbered():
    assert [path.name[:2] for path in SCRIPTS] == [f"{k:02}" for k in range(1, len(SCRIPTS) + 1)]
    assert len(SCRIPTS) >= 3


@pytest.mark.timeout(10_800 if FULL else 120)  # the longest takes half an hour on two free cores
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_runs_and_has_less_than_a_hundred_lines(script, tmp_path, monkeypatch, capsys):
    text = script.read_text()
    assert len(text.splitlines()) < 100
    if "permutations" in text and not FULL:
        pytest.skip("computes 2,520 workspaces, half an hour: with STILLREACH_FULL=1")
    if "import viser" in text:
        pytest.importorskip("viser", reason="viser is not installed (it wants an older rich than the newest)")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(time, "sleep", lambda seconds: None)  # a loop in real time
    monkeypatch.setattr(sys, "argv", [str(script), str(tmp_path)])
    runpy.run_path(str(script), run_name="__main__")
    assert capsys.readouterr().out
