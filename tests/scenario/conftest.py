from dataclasses import dataclass
from pathlib import Path

import pytest

from stillreach.paper import evidence
from tests.commands import run_command


@dataclass(frozen=True)
class Reproduction:
    """What one run of the command left."""

    folder: Path
    printed: str
    exit_code: int


@pytest.fixture(scope="session")
def reproduction(tmp_path_factory):
    """`stillreach paper` as a user runs it, once for all tests."""
    folder = tmp_path_factory.mktemp("out") / "paper"
    done = run_command("paper", "--out", folder)
    return Reproduction(folder, done.out + done.err, done.code)


@pytest.fixture(scope="session")
def saved(reproduction):
    """The runs that the command saved, read back."""
    return evidence.load(reproduction.folder, step=0.05)
