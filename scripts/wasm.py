"""Compiles the controller to WebAssembly for the live page, and notes what it was made of. `make wasm` runs it."""

import hashlib
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
CORE = ROOT / "page" / "core"
WASM, MADE_OF = CORE / "controller.wasm", CORE / "made-of.sha256"
TARGET = ["-target", "wasm32-wasi", "-mexec-model=reactor", "-std=c++17", "-fno-exceptions", "-fno-rtti", "-s"]
SPEED = ["-O3", "-msimd128", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=off"]
STACK = ["-Wl,-z,stack-size=524288"]
FLAGS = [*TARGET, *SPEED, *STACK]


def made_of() -> str:
    """A hash of the flags and of every source that may be a part of it."""
    sources = [*sorted((ROOT / "include").rglob("*.hpp")), CORE / "controller.cpp"]
    found = hashlib.sha256(" ".join(FLAGS).encode())
    for path in sources:
        found.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return found.hexdigest()


def main() -> None:
    compiler = [sys.executable, "-m", "ziglang", "c++", *FLAGS, "-I", "include"]
    subprocess.run([*compiler, "page/core/controller.cpp", "-o", str(WASM)], cwd=ROOT, check=True)
    WASM.chmod(0o644)
    MADE_OF.write_text(made_of() + "\n", encoding="utf-8")
    print(f"{WASM.relative_to(ROOT)}: {WASM.stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
