"""Commands in a folder with two scenarios."""

from collections.abc import Callable
from functools import partial

import pytest

from tests.commands import Answer, run_command

REACH = """
name = "reach"
start = [0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0]
period = 0.05
loop = "closed"
units = { length = "m", angle = "deg" }
robot = { arm = "nasa_modular" }
motion = [{ kind = "twist", twist = [-0.1, 0, 0, 0, 0, 0], duration = 2 }]
faults = [{ joint = "j4", kind = "locked", at = 1 }]
"""
"""A short scenario that every law can do."""

TOO_FAR = REACH.replace("[-0.1, 0, 0", "[0, 0, 5").replace('"reach"', '"too far"')
"""One that no law can: 10 m up."""


@pytest.fixture
def stillreach(monkeypatch, tmp_path) -> Callable[..., Answer]:
    """Runs a command in an empty folder that holds reach.toml and too-far.toml."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    (tmp_path / "reach.toml").write_text(REACH, encoding="utf-8")
    (tmp_path / "too-far.toml").write_text(TOO_FAR, encoding="utf-8")
    return partial(run_command, columns=None)
