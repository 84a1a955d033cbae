"""Names and numbers that a user may type or a file may hold, and streams that are not there."""

import os
import subprocess
import sys

import pytest

from tests.unit.cli.conftest import REACH

NOTHING = ("--out", ".", "--no-plot")


@pytest.mark.parametrize("name", [r"a\u0000b"])
def test_a_name_that_no_file_holds_is_a_mistake_of_its_line(stillreach, tmp_path, name):
    (tmp_path / "bad.toml").write_text(REACH.replace('name = "reach"', f'name = "{name}"'), encoding="utf-8")
    answer = stillreach("run", "bad.toml", *NOTHING)
    assert answer.code == 2
    assert "line 2, name: got 'a\\x00b'" in answer.err


def test_a_name_with_markup_and_control_characters_is_printed_as_it_is(stillreach, tmp_path):
    (tmp_path / "odd.toml").write_text(REACH.replace('"reach"', r'"[/red] $x$ \u001b[2J"'), encoding="utf-8")
    answer = stillreach("run", "odd.toml", "--out", ".", "--plot")
    assert answer.code == 0
    assert r"[/red] $x$ \x1b[2J" in answer.out
    assert "\x1b" not in answer.out


def test_a_file_name_that_is_not_utf8_becomes_a_title(stillreach, tmp_path):
    name = os.fsdecode(b"a\xff.toml")
    (tmp_path / name).write_text(REACH.replace('name = "reach"', ""), encoding="utf-8")
    answer = stillreach("run", name, *NOTHING)
    assert answer.code == 0
    assert answer.out.startswith(r"a\udcff")


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "reach.toml", *NOTHING, "--fail", "9" * 5000),
        ("run", "reach.toml", *NOTHING, "--fail", "²"),
        ("run", "reach.toml", *NOTHING, "--fail", "j1@1e400"),
        ("inspect", "planar3", "--q", "1e400,0,0"),
        ("paper", "--lengths", "1e300,1,1,1,1,1", "--out", "paper"),
    ],
    ids=lambda arguments: arguments[-1][:10],
)
def test_numbers_that_are_none_are_mistakes_of_the_user(stillreach, arguments):
    answer = stillreach(*arguments)
    assert answer.code == 2
    assert "Traceback" not in answer.err


@pytest.mark.parametrize("file", ["run.nc", "summary.json", "run.png"])
def test_a_pipe_in_the_place_of_a_file_is_refused(stillreach, tmp_path, file):
    os.mkfifo(tmp_path / file)
    answer = stillreach("run", "reach.toml", "--out", ".", "--plot")
    assert answer.code == 2
    assert f"'{file}', which is a pipe" in answer.err


def test_a_command_without_any_stream_does_its_work(tmp_path):
    (tmp_path / "reach.toml").write_text(REACH, encoding="utf-8")
    code = "import sys\nfrom stillreach.cli import main\nsys.stdout = sys.stderr = None\nmain()"
    done = subprocess.run(
        [sys.executable, "-c", code, "run", "reach.toml", *NOTHING], cwd=tmp_path, timeout=60, check=False
    )
    assert done.returncode == 0
    assert (tmp_path / "run.nc").is_file()
