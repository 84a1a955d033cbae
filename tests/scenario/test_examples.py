"""The numbered scripts run as they stand, and are short."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))


def test_there_are_scripts_and_they_are_numbered():
    assert [path.name[:2] for path in SCRIPTS] == [f"{k:02}" for k in range(1, len(SCRIPTS) + 1)]
    assert len(SCRIPTS) >= 3


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_a_script_runs_and_has_less_than_a_hundred_lines(script, tmp_path):
    assert len(script.read_text().splitlines()) < 100
    command = [sys.executable, "-W", "error", str(script), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout
