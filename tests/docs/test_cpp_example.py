"""The C++ programs in docs/cpp.md compile without a warning, run, and print what the page says."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.docs.pages import ROOT, blocks

PAGE = ROOT / "docs" / "cpp.md"
PROGRAMS = blocks(PAGE.read_text(encoding="utf-8"), "cpp")
COMPILER = shutil.which(os.environ.get("CXX", "g++"))
# -O0: the page asks for more, and the compiler for five times as long
FLAGS = ["-std=c++17", "-O0", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-Wno-psabi"]

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="apt-get install g++")


def built_and_run(code: str, folder: Path) -> str:
    """Output of a program; the compiler's messages where there are any."""
    source, program = folder / "example.cpp", folder / "example"
    source.write_text(code, encoding="utf-8")
    command = [str(COMPILER), *FLAGS, f"-I{ROOT / 'include'}", str(source), "-o", str(program)]
    compiled = subprocess.run(command, capture_output=True, text=True, check=False)
    assert compiled.returncode == 0, compiled.stderr
    return subprocess.run([program], capture_output=True, text=True, check=True).stdout


def test_the_page_has_programs_and_says_what_they_print() -> None:
    assert len(PROGRAMS) == 2
    assert all("int main()" in program.code and program.output for program in PROGRAMS)


@needs_compiler
@pytest.mark.timeout(600)
@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: f"line-{program.line}")
def test_a_program_prints_what_the_page_says(program, tmp_path: Path) -> None:
    assert built_and_run(program.code, tmp_path) == program.output


@needs_compiler
def test_a_program_that_does_not_compile_is_seen(tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match=re.compile("error")):
        built_and_run("int main() { return missing; }", tmp_path)
