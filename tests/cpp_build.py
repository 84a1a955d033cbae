"""The folder that `make cpp-test` builds in, for Python tests that look at what the C++ compiler made."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
BUILD = ROOT / "build" / "cpp"


def run(*command: str | Path) -> str:
    """Output of a command that must succeed."""
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, f"{command} ended with {done.returncode}:\n{done.stdout}{done.stderr}"
    return done.stdout


def has_header(name: str, compiler: str = "g++") -> bool:
    """Whether a compiler finds a header."""
    if shutil.which(compiler) is None:
        return False
    command = [compiler, "-std=c++17", "-fsyntax-only", "-xc++", "-"]
    done = subprocess.run(command, input=f"#include <{name}>\n", capture_output=True, text=True, check=False)
    return done.returncode == 0


def build_targets(*targets: str, build: Path = BUILD) -> Path:
    """Brings targets up to date (after `make cpp-test` they are) and returns the build folder."""
    run("cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DSTILLREACH_TESTS=ON")
    run("cmake", "--build", build, "--parallel", "2", "--target", *targets)
    return build
