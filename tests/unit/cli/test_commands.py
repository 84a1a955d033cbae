"""What a shell sees of the commands: output, exit code, and the time that help costs."""

import os
import signal
import subprocess
import sys
import time
from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
from tests.commands import run_command

LONG = """
start = [0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0]
period = 0.0001
units = { length = "m", angle = "deg" }
robot = { arm = "nasa_modular" }
motion = [{ kind = "twist", twist = [-0.001, 0, 0, 0, 0, 0], duration = 200 }]
"""
"""Two million ticks."""

COMMAND = Path(sys.executable).with_name("stillreach")


def test_the_version_is_the_installed_one() -> None:
    done = subprocess.run([COMMAND, "--version"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, f"stillreach {metadata.version('stillreach')}\n")


def test_help_names_every_command() -> None:
    done = run_command("--help", columns=None)
    assert done.code == 0
    commands = ("run", "compare", "inspect", "arms", "schema", "paper", "doctor")
    assert all(f"\n  {command} " in done.out for command in commands)
    assert max(map(len, done.out.splitlines())) <= 80
    assert "..." not in done.out.partition("Commands:")[2]  # every line of the list is whole


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["run", "--help"], ["inspect", "--help"]])
def test_an_answer_needs_no_heavy_import(arguments: list[str]) -> None:
    """What takes its time to import, and would make help slow."""
    command = [sys.executable, "-X", "importtime", "-m", "stillreach", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "stillreach.cli" in imported
    heavy = {"numpy", "rich", "matplotlib", "xarray", "mujoco", "stillreach._core"}
    if len(arguments) == 1:
        heavy.add("pydantic")  # typer itself imports it for a command's own help
    assert imported & heavy == set()


@pytest.mark.parametrize("arguments", [["nonsense"], ["paper", "--step", "fast"], ["paper", "--lengths", "1,long"]])
def test_wrong_usage_exits_with_2(arguments: list[str]) -> None:
    done = run_command(*arguments)
    assert done.code == 2
    assert "Usage:" in done.err
    assert "Traceback" not in done.err


def test_the_doctor_finds_this_installation_complete() -> None:
    done = run_command("doctor")
    assert done.code == 0
    assert "matplotlib" in done.out
    assert "pip install" not in done.out
    assert any(path in done.out for path in ("avx512", "avx2", "baseline"))


def test_the_doctor_says_how_to_get_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Metadata of one package is hidden, as if it had never been installed."""
    installed = metadata.version

    def version(name: str) -> str:
        if name == "matplotlib":
            raise metadata.PackageNotFoundError(name)
        return installed(name)

    monkeypatch.setattr(metadata, "version", version)
    done = run_command("doctor")
    assert done.code == 0
    assert "pip install 'stillreach[plot]'" in done.out


def interrupted(arguments: list[str | Path], out: Path) -> tuple[int, str, str]:
    """Exit code, output and messages of a command that gets Ctrl-C a moment after its folder is there."""
    process = subprocess.Popen(
        [COMMAND, *arguments, "--out", out], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    give_up = time.monotonic() + 60
    while not out.exists() and process.poll() is None and time.monotonic() < give_up:
        time.sleep(0.02)
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    output, messages = process.communicate(timeout=60)
    return process.returncode, output, messages


def test_ctrl_c_exits_with_130(tmp_path: Path) -> None:
    code, _, messages = interrupted(["paper", "--step", "0.001"], tmp_path / "out")
    assert code == 130
    assert messages == f"interrupted; the files that were finished stay in {tmp_path / 'out'}\n"


@pytest.mark.parametrize("command", ["run", "compare"])
def test_ctrl_c_keeps_what_was_computed(tmp_path: Path, command: str) -> None:
    scenario = tmp_path / "long.toml"
    scenario.write_text(LONG, encoding="utf-8")
    code, output, messages = interrupted([command, scenario, "--no-plot"], tmp_path / "out")
    assert code == 130
    assert "what was computed is kept" in messages
    assert "Traceback" not in messages
    records = list((tmp_path / "out").glob("*.nc"))
    assert len(records) == 1
    kept = sr.Run.load(records[0])
    assert kept.interrupted
    assert 0 < len(kept) < 2_000_001
    assert np.all(np.isfinite(kept.q))
    assert "interrupted" in output or "broken off" in output


@pytest.mark.parametrize("arguments", [["run", "jammed-rail", "--no-plot"], ["schema"], ["arms"]])
def test_output_that_nobody_reads_is_no_failure_of_the_arm(arguments, tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "stillreach", *arguments]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, cwd=tmp_path, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, "")
