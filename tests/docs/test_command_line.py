"""The commands of docs/command-line.md print what the page says, and --json has the keys that it lists."""

import json
import re
import shlex
from pathlib import Path

import pytest

from tests.commands import Answer, run_command
from tests.docs.pages import ROOT, blocks

PAGE = (ROOT / "docs" / "command-line.md").read_text(encoding="utf-8")
SHOWN = [block for block in blocks(PAGE, "sh") if block.output is not None]
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


@pytest.fixture(scope="module")
def desk(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("desk")


def shell(line: str, desk: Path) -> Answer:
    program, *arguments = shlex.split(line)
    assert program == "stillreach"
    return run_command(*arguments, folder=desk)


def words(text: str) -> list[str]:
    """A text without its numbers, and without what their widths change."""
    return re.sub(r"[─\s]+", " ", NUMBER.sub("#", text)).split()


def numbers(text: str) -> list[float]:
    return [float(number) for number in NUMBER.findall(text)]


def listed(text: str) -> set[str]:
    """Keys in the first column of the tables of a section."""
    rows = [line.split("|")[1] for line in text.splitlines() if line.startswith("| `")]
    return {key for row in rows for key in re.findall(r"`(\w+)`", row)}


def test_the_page_shows_every_step() -> None:
    assert [block.code.split()[1] for block in SHOWN] == ["inspect", "run", "run", "run", "compare", "run"]


@pytest.mark.parametrize("block", SHOWN, ids=lambda block: f"line-{block.line}")
def test_a_command_prints_what_the_page_shows(block, desk: Path) -> None:
    """Numbers to 3 %: a simulation's last digits depend on the processor."""
    done = shell(block.code, desk)
    printed = done.out + done.err
    assert words(printed) == words(block.output)
    assert numbers(printed) == pytest.approx(numbers(block.output), rel=0.03, abs=0.01)


README = [line for block in blocks((ROOT / "README.md").read_text(), "sh") for line in block.code.splitlines()]
IN_README = [line.partition("#")[0].strip() for line in README if line.startswith("stillreach ")]


def test_the_readme_shows_every_command_that_looks_at_a_robot_or_moves_it() -> None:
    assert {line.split()[1] for line in IN_README} == {"run", "compare", "inspect", "reach", "rehearse"}


@pytest.mark.parametrize("line", IN_README)
def test_a_shell_line_of_the_readme_works_as_it_is_printed(line: str, desk: Path) -> None:
    without_picture = " --no-plot" if line.split()[1] in ("run", "compare") else ""
    assert shell(line + without_picture, desk).code == 0


def test_the_keys_of_run_and_compare_are_those_of_the_page(desk: Path) -> None:
    section = PAGE.partition("## For machines")[2].partition("`compare` has")[0]
    found = json.loads(shell("stillreach run planar-runaway --json --no-plot", desk).out)
    assert set(found) == listed(section)
    both = json.loads(shell("stillreach compare planar-runaway --json --no-plot --laws least-error", desk).out)
    assert set(both) == {"scenario", "laws", "files"}
    assert set(both["laws"]["least-error"]) == listed(section) - {"files"}


def test_the_keys_of_inspect_are_those_of_the_page(desk: Path) -> None:
    section = PAGE.partition("`inspect`:")[2].partition("`reach`:")[0]
    found = json.loads(shell("stillreach inspect planar4 --json", desk).out)
    assert set(found) == listed(section)
    inner = {*found["joints"][0], *found["at"], *found["at"]["locked"][0]}
    assert inner <= set(re.findall(r"`(\w+)`", section))


def test_the_keys_of_reach_are_those_of_the_page(desk: Path) -> None:
    section = PAGE.partition("`reach`:")[2].partition("`survey`:")[0]
    found = json.loads(shell("stillreach reach planar4 --json --samples 5", desk).out)
    assert {*found, *found["joints"][0]} == set(re.findall(r"`(\w+)`", section)) - {"lost_lines"}  # of a file


def test_the_keys_of_survey_are_those_of_the_page(desk: Path) -> None:
    pytest.importorskip("zarr", reason="needs the extra survey")
    section = PAGE.partition("`survey`:")[2].partition("`arms --json`")[0]
    options = " ".join(f"--metric {name}" for name in ("relative", "speed", "depth", "reach", "positions"))
    found = json.loads(
        shell(f"stillreach survey planar4 --json --no-plot --samples 5 --rows vx,vy {options}", desk).out
    )
    others = {"reach", "positions", "unreached_lines"}
    assert {*found, *found["worst"][0]} == set(re.findall(r"`(\w+)`", section)) - others


def test_the_keys_of_arms_and_doctor_are_those_of_the_page(desk: Path) -> None:
    section = PAGE.partition("`arms --json` has")[2].partition("## In a shell")[0]
    arms, _, doctor = section.partition("`doctor --json` has")
    for command, text in (("arms", arms), ("doctor", doctor)):
        found = json.loads(shell(f"stillreach {command} --json", desk).out)
        assert set(found) == set(re.findall(r"`(\w+)`", text)) - {"null"}


def test_the_exit_codes_are_those_of_the_page() -> None:
    from stillreach.cli import _exit

    told = {int(code) for code in re.findall(r"^\| (\d+) \|", PAGE, re.MULTILINE)}
    assert told == {_exit.DONE, _exit.NOT_FINISHED, _exit.USER, _exit.BUG, _exit.CTRL_C, _exit.BROKEN_PIPE}
