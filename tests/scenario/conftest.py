import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from stillreach.paper import evidence


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
    command = [sys.executable, "-W", "error", "-m", "stillreach", "paper", "--out", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    return Reproduction(folder, done.stdout + done.stderr, done.returncode)


@pytest.fixture(scope="session")
def saved(reproduction):
    """The runs that the command saved, read back."""
    return evidence.load(reproduction.folder, step=0.05)
