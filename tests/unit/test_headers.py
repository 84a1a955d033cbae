"""The headers compile without a warning, all of them in one file, with a plain include path and nothing else."""

import shutil
import subprocess
from pathlib import Path

import pytest

INCLUDE = Path(__file__).parents[2] / "include"
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


def everything() -> str:
    """Includes of every header but those of ``CHOSEN`` and ``cuda.hpp``, which is for CUDA alone."""
    headers = [path for path in INCLUDE.rglob("*.hpp") if path.name not in CHOSEN | {"cuda.hpp"}]
    names = sorted(path.relative_to(INCLUDE).as_posix() for path in headers)
    return (
        "".join(f'#include "{name}"\n' for name in names) + "int main() { return !stillreach::make_kernel().solve; }\n"
    )


@pytest.mark.parametrize("instruction_set", SETS)
@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_all_headers_in_one_file_give_no_warning(compiler: str, instruction_set: str, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    source = tmp_path / "everything.cpp"
    source.write_text(everything())
    command = [compiler, "-std=c++17", "-fsyntax-only", f"-I{INCLUDE}", *WARNINGS, *SETS[instruction_set], str(source)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if instruction_set in ON_X86_ONLY and "unrecognized command-line option" in done.stderr:
        pytest.skip("another processor than x86-64")
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
