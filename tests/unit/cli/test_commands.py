"""What a shell sees of the commands: output, exit code, and the time that help costs."""

import resource
import signal
import subprocess
import sys
import time
from importlib import metadata
from pathlib import Path

import pytest

COMMAND = Path(sys.executable).with_name("stillreach")


def stillreach(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([COMMAND, *arguments], capture_output=True, text=True, check=False)


def test_the_version_is_the_installed_one() -> None:
    done = stillreach("--version")
    assert (done.returncode, done.stdout) == (0, f"stillreach {metadata.version('stillreach')}\n")


def test_help_names_every_command() -> None:
    done = stillreach("--help")
    assert done.returncode == 0
    assert all(command in done.stdout for command in ("paper", "doctor"))


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_an_answer_needs_no_heavy_import(option: str) -> None:
    command = [sys.executable, "-X", "importtime", "-m", "stillreach", option]
    times = []
    for _ in range(3):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        times.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    imported = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "stillreach.cli" in imported
    assert imported & {"numpy", "pydantic", "matplotlib", "xarray", "stillreach._core"} == set()
    assert min(times) < 0.4


@pytest.mark.parametrize("arguments", [["nonsense"], ["paper", "--step", "fast"], ["paper", "--lengths", "1,long"]])
def test_wrong_usage_exits_with_2(arguments: list[str]) -> None:
    done = stillreach(*arguments)
    assert done.returncode == 2
    assert "Usage:" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_refused_input_is_one_line(tmp_path: Path) -> None:
    done = stillreach("paper", "--out", tmp_path, "--step", "-1")
    assert done.returncode == 2
    assert done.stderr.startswith("stillreach: ")
    assert len(done.stderr.splitlines()) == 1
    assert "step" in done.stderr


def test_a_claim_that_fails_exits_with_1(tmp_path: Path) -> None:
    """In two seconds the arm cannot do what the paper states of twenty."""
    done = stillreach("paper", "--out", tmp_path, "--duration", "2")
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert (tmp_path / "claims.json").exists()


def test_the_doctor_finds_this_installation_complete() -> None:
    done = stillreach("doctor")
    assert done.returncode == 0
    assert "matplotlib" in done.stdout
    assert "pip install" not in done.stdout
    assert any(path in done.stdout for path in ("avx2", "baseline"))


def test_the_doctor_says_how_to_get_what_is_missing() -> None:
    """Metadata of one package is hidden from the process, as if it had never been installed."""
    program = (
        "from importlib import metadata; real = metadata.version\n"
        "def version(name):\n"
        "    if name == 'matplotlib': raise metadata.PackageNotFoundError(name)\n"
        "    return real(name)\n"
        "metadata.version = version\n"
        "import sys; sys.argv = ['stillreach', 'doctor']\n"
        "from stillreach.cli import main; main()\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert "pip install 'stillreach[plot]'" in done.stdout


def test_ctrl_c_exits_with_130(tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [COMMAND, "paper", "--out", out, "--step", "0.001"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    give_up = time.monotonic() + 60
    while not out.exists() and process.poll() is None and time.monotonic() < give_up:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, messages = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in messages
