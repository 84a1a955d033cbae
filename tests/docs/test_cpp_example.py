"""The C++ programs in docs/cpp.md compile without a warning, run, and print what the page says."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from cpp_build import has_header

from tests.docs.pages import ROOT, blocks

PAGE = ROOT / "docs" / "cpp.md"
PROGRAMS = blocks(PAGE.read_text(encoding="utf-8"), "cpp")
COMPILERS = {name: shutil.which(name) for name in (os.environ.get("CXX", "g++"), "clang++")}
# -O0: the page asks for more, and the compiler for five times as long
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Wsign-conversion", "-Werror", "-Wno-psabi"]
FLAGS = ["-std=c++17", "-O0", "-ffp-contract=off", *WARNINGS]


@pytest.fixture(params=COMPILERS)
def compiler(request) -> str:
    """Each compiler of this machine."""
    return COMPILERS[request.param] or pytest.skip(f"no {request.param}")


def built_and_run(code: str, folder: Path, compiler: str) -> str:
    """Output of a program; the compiler's messages where there are any."""
    source, program = folder / "example.cpp", folder / "example"
    source.write_text(code, encoding="utf-8")
    command = [compiler, *FLAGS, f"-I{ROOT / 'include'}", str(source), "-o", str(program)]
    if "urdf.hpp" in code:
        if not has_header("tinyxml2.h", compiler):
            pytest.skip("apt-get install libtinyxml2-dev")
        command.append("-ltinyxml2")
    compiled = subprocess.run(command, capture_output=True, text=True, check=False)
    assert compiled.returncode == 0, compiled.stderr
    return subprocess.run([program], capture_output=True, text=True, check=True).stdout


def test_the_page_has_programs_and_says_what_they_print() -> None:
    assert len(PROGRAMS) == 4
    assert all("int main()" in program.code and program.output for program in PROGRAMS)


@pytest.mark.timeout(600)
@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: f"line-{program.line}")
def test_a_program_prints_what_the_page_says(program, tmp_path: Path, compiler: str) -> None:
    assert built_and_run(program.code, tmp_path, compiler) == program.output


@pytest.mark.parametrize("program", PROGRAMS[:2], ids=lambda program: f"line-{program.line}")
def test_a_loop_with_a_fault_is_short(program) -> None:
    code = [line for line in program.code.splitlines() if line.strip() and not line.strip().startswith("//")]
    assert len(code) <= 25
    assert "controller.fail(" in program.code


def test_a_program_that_does_not_compile_is_seen(tmp_path: Path, compiler: str) -> None:
    with pytest.raises(AssertionError, match=re.compile("error")):
        built_and_run("int main() { return missing; }", tmp_path, compiler)
