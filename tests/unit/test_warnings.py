"""The headers, all of them in one file with a plain include path, and the bindings compile without a warning."""

import shutil
import subprocess
import sysconfig
from pathlib import Path

import nanobind
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
INCLUDE = ROOT / "include"
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Wsign-conversion", "-Wno-psabi", "-Werror"]
CHOSEN = {"portable_pack.hpp", "wide.hpp"}
"""Included by scalar.hpp and lanes.hpp where they are wanted."""
SETS = {
    "baseline": [],
    "avx2": ["-mavx2", "-mfma"],
    "avx512": ["-mavx2", "-mfma", "-mavx512f", "-mavx512dq"],
    "portable": ["-DSTILLREACH_PORTABLE_PACK"],
}
ON_X86_ONLY = {"avx2", "avx512"}
BINDINGS = sorted((ROOT / "bindings").glob("*.cpp"))


def compiled(compiler: str, source: Path, *options: str) -> tuple[int, str]:
    """Exit code and messages of a compiler that only looks at a file."""
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    command = [compiler, "-std=c++17", "-fsyntax-only", "-fvisibility=hidden", f"-I{INCLUDE}", *options, *WARNINGS]
    done = subprocess.run([*command, str(source)], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def everything() -> str:
    """Includes of every header but those of ``CHOSEN`` and ``cuda.hpp``, which is for CUDA alone.

    ``urdf.hpp`` and what it includes are left out where tinyxml2 is missing.
    """
    headers = [path for path in INCLUDE.rglob("*.hpp") if path.name not in CHOSEN | {"cuda.hpp"}]
    names = sorted(path.relative_to(INCLUDE).as_posix() for path in headers)
    main = "int main() { return stillreach::make_kernel().solve == nullptr; }\n"
    urdf = [name for name in names if name.startswith("urdf")]
    lines = "".join(f'#include "{name}"\n' for name in names if name not in urdf)
    optional = "".join(f'#include "{name}"\n' for name in urdf)
    return f"{lines}#if __has_include(<tinyxml2.h>)\n{optional}#endif\n{main}"


@pytest.mark.parametrize("instruction_set", SETS)
@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_all_headers_in_one_file_give_no_warning(compiler: str, instruction_set: str, tmp_path: Path) -> None:
    source = tmp_path / "everything.cpp"
    source.write_text(everything())
    code, messages = compiled(compiler, source, *SETS[instruction_set])
    if instruction_set in ON_X86_ONLY and "unrecognized command-line option" in messages:
        pytest.skip("another processor than x86-64")
    assert (code, messages) == (0, "")


@pytest.mark.parametrize("source", BINDINGS, ids=lambda path: path.stem)
def test_the_bindings_give_no_warning(source: Path) -> None:
    foreign = [nanobind.include_dir(), np.get_include(), sysconfig.get_paths()["include"]]
    options = [option for folder in foreign for option in ("-isystem", folder)]
    assert compiled("g++", source, "-DSTILLREACH_DISPATCH", *options) == (0, "")


def test_a_conversion_that_changes_a_sign_is_seen(tmp_path: Path) -> None:
    source = tmp_path / "signs.cpp"
    source.write_text("unsigned from(int a) { return a; }\n")
    code, messages = compiled("g++", source)
    assert code != 0
    assert "sign-conversion" in messages
