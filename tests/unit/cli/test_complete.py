"""What a shell offers behind Tab, and how soon."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import stillreach as sr
from stillreach.cli._complete import complete_law, complete_laws, complete_robot, complete_scenario
from stillreach.cli._laws import law_texts, parse_law
from stillreach.laws import LAWS

COMMAND = Path(sys.executable).with_name("stillreach")


def offered(line: str, folder: Path) -> list[str]:
    """What bash would offer for a command line that ends in an unfinished word."""
    words = line.split(" ")
    variables = {
        "_STILLREACH_COMPLETE": "complete_bash",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
    }
    done = subprocess.run(
        [COMMAND], env={**os.environ, **variables}, cwd=folder, capture_output=True, text=True, check=True
    )
    return done.stdout.split()


def test_a_shell_is_offered_commands_scenarios_arms_and_laws(tmp_path):
    assert {"run", "compare", "inspect", "arms", "schema", "paper", "doctor"} <= set(offered("stillreach ", tmp_path))
    assert set(offered("stillreach run paper-", tmp_path)) == {n for n in sr.scenario_names() if n.startswith("paper-")}
    assert offered("stillreach inspect can", tmp_path) == ["canadarm2"]
    assert offered("stillreach run x --law keep", tmp_path) == ["keep-direction"]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_for_a_shell_is_printed(shell):
    done = subprocess.run([COMMAND, "--show-completion", shell], capture_output=True, text=True, check=True)
    assert "_STILLREACH_COMPLETE" in done.stdout


def test_completion_needs_no_numpy():
    program = (
        "import sys\n"
        "from stillreach.cli._app import app\n"
        "from stillreach.cli._complete import complete_robot, complete_scenario\n"
        "complete_robot(''), complete_scenario('')\n"
        "assert not {'numpy', 'pydantic', 'rich', 'stillreach._core'} & set(sys.modules), sorted(sys.modules)\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_files_and_folders_are_offered_by_kind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    for name in ("arm.urdf", "arm.xml", "arm.toml", ".hidden.toml", "sub/deep.toml"):
        (tmp_path / name).touch()
    assert complete_robot("a") == ["arm.urdf", "arm.xml"]
    assert complete_scenario("a") == ["arm.toml"]
    assert complete_scenario("s") == ["snake-loses-five", "sub/"]
    assert complete_scenario("sub/") == ["sub/deep.toml"]
    assert complete_scenario("nowhere/") == []


def test_a_list_of_laws_is_completed_behind_its_commas():
    assert complete_laws("least-error,p") == ["least-error,pseudoinverse"]
    assert "least-error,least-error" not in complete_laws("least-error,")
    assert len(complete_laws("least-error,")) == len(LAWS) - 1


def test_laws_with_settings_that_completion_offers_are_accepted():
    assert complete_law("least-error:price=") == ["least-error:price=none", "least-error:price=position-first"]
    names, variants = law_texts()
    assert [type(parse_law(name)) for name in names] == list(LAWS)
    assert len({repr(parse_law(text)) for text in variants} - {repr(law()) for law in LAWS}) == len(variants) - 2


@pytest.mark.parametrize(
    ("text", "price"),
    [
        ("55", 55.0),
        ("none", None),
        ("position-first", "position-first"),
        ("position=100+orientation=8", {"position": 100.0, "orientation": 8.0}),
        ("position=1e+2+wx wy=8+wz=1", {"position": 100.0, "wx wy": 8.0, "wz": 1.0}),
    ],
)
def test_every_price_can_be_given_on_the_command_line(text, price):
    assert parse_law(f"least-error:price={text}") == sr.LeastError(price=price)


def test_settings_of_a_law_are_given_behind_colons():
    assert parse_law("singularity-robust:damping=0.25:norm=2") == sr.SingularityRobust(damping=0.25, norm="2")
    assert parse_law("least-error:price=none:rank_tolerance=1e-8") == sr.LeastError(price=None, rank_tolerance=1e-8)
