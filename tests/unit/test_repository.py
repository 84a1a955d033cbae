"""What a stranger's clone must find: no trace of the machine it was made on, and one place for each fact."""

import re
import subprocess
import sysconfig
import tomllib
from functools import cache
from importlib import metadata
from pathlib import Path

import pytest

import stillreach

ROOT = Path(__file__).parents[2]
HOME_FOLDERS = re.compile(r"(?<![\w.>])/(?:home|root|work|Users|opt|tmp)/\w")
DOWNLOAD_HOSTS = re.compile(
    r"\b(?:pypi|pythonhosted|debian|ubuntu|npmjs|anaconda)\.(?:org|com)\b|--hash[=]|index-url\s+\S+:"
)


@cache
def repository_texts() -> dict[str, str]:
    """Text of every file that git knows or would add, by path."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=False, text=True)
    if listed.returncode != 0:
        pytest.skip("not a git repository, or git is missing: apt-get install git")
    texts = {}
    for name in listed.stdout.split("\0")[:-1]:
        path = ROOT / name
        if path.is_file() and b"\0" not in (data := path.read_bytes()):
            texts[name] = data.decode(errors="replace")
    return texts


@pytest.mark.parametrize("pattern", [HOME_FOLDERS, DOWNLOAD_HOSTS], ids=["machine path", "download host"])
def test_no_file_holds_a_trace_of_the_machine(pattern: re.Pattern[str]) -> None:
    found = [f"{name}: {match[0]}" for name, text in repository_texts().items() for match in pattern.finditer(text)]
    assert found == []


@pytest.mark.parametrize(
    ("pattern", "text"),
    [
        (HOME_FOLDERS, "read " + "/".join(("", "home", "someone", "arm.urdf"))),
        (HOME_FOLDERS, f'"{"/".join(("", "work", "main"))}"'),
        (DOWNLOAD_HOSTS, "from https://" + ".".join(("files", "pythonhosted", "org")) + "/packages"),
        (DOWNLOAD_HOSTS, "numpy==2.0.0 --" + "hash=sha256:00"),
    ],
)
def test_a_trace_of_the_machine_is_seen(pattern: re.Pattern[str], text: str) -> None:
    assert pattern.search(text)


def test_make_clean_keeps_the_runs_of_a_user() -> None:
    recipe = (ROOT / "Makefile").read_text().partition("\nclean:")[2].partition("\n\n")[0]
    removed = re.findall(r"\S+", " ".join(re.findall(r"rm -rf (.*)", recipe)))
    assert "out/paper" in removed  # what `make demo` wrote
    assert not {"out", "out/", "out/*"} & set(removed)


def test_the_version_is_written_once() -> None:
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    whole = re.compile(rf"(?<![\w.=]){re.escape(version)}(?![\w.])")
    others = ("CHANGELOG.md", "ros2/kinematics_interface_stillreach/package.xml")
    texts = {name: text for name, text in repository_texts().items() if name not in others}
    assert [name for name, text in texts.items() for _ in whole.finditer(text)] == ["pyproject.toml"]
    assert metadata.version("stillreach") == version
    assert f"<version>{version}</version>" in (ROOT / others[1]).read_text()


def test_the_tests_run_on_the_installed_wheel() -> None:
    installed = Path(stillreach.__file__).parent
    assert installed.parent in (Path(sysconfig.get_path("purelib")), Path(sysconfig.get_path("platlib")))
    assert {"_core.pyi", "py.typed"} <= {path.name for path in installed.iterdir()}


def test_the_wheel_holds_every_file_of_the_package() -> None:
    """The ready scenarios and their tables, too; a test run after an edit and before a build would see the old ones."""
    written = {
        name.removeprefix("src/stillreach/"): text
        for name, text in repository_texts().items()
        if "/stillreach/" in name
    }
    package = {name: text for name, text in written.items() if not name.startswith("include/")}
    installed = Path(stillreach.__file__).parent
    assert {Path(name).suffix for name in package} == {".py", ".toml", ".csv", ".html", ".css"}
    assert [name for name, text in package.items() if (installed / name).read_text(encoding="utf-8") != text] == []


def test_every_python_file_is_linted() -> None:
    linted = re.search(r"^LINTED := \$\(wildcard (.+)\)$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert linted
    folders = tuple(name if name.endswith(".py") else f"{name}/" for name in linted[1].split())
    assert [
        name for name in repository_texts() if name.endswith((".py", ".pyi")) and not name.startswith(folders)
    ] == []


def test_robot_files_of_others_are_not_shipped() -> None:
    """They have licences of their own, and come from the packages that tests and scenarios name."""
    robots = [
        name for name in repository_texts() if name.endswith((".urdf", ".xml", ".xacro", ".mjcf", ".dae", ".stl"))
    ]
    assert robots
    assert [name for name in robots if not name.startswith(("tests/fuzzing/corpus/", "ros2/"))] == []


def test_every_requirement_is_pinned() -> None:
    for path in (ROOT / "requirements").glob("*.txt"):
        lines = [line for line in path.read_text().splitlines() if line and not line.lstrip().startswith("#")]
        assert lines
        assert [line for line in lines if not re.match(r"[\w.-]+==[\w.]+\s*(#.*)?$", line)] == []
