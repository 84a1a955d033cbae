"""Builds the wheels for Linux on x86-64 and puts each through its gates; ends with a table. `make wheels` runs it.

One wheel for Python 3.11, one with the stable ABI for 3.12 and newer, for glibc 2.17. The compiler is the one of the
package ziglang, so that no container is needed; but GCC compiles the kernels, which call next to nothing of the C
library: its code is up to 16 % faster. Exit code 1: a gate was not passed.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[1]
WORK = ROOT / "build" / "wheels"
PYTHONS = ["3.11", "3.12", "3.13"]
BUILT_WITH = {"cp311": "3.11", "cp312": "3.12"}
PLATFORM = "manylinux_2_17_x86_64"
COMPILER = """#!/bin/sh
case "$*" in *"-c "*dispatch/kernel.cpp) exec g++ "$@" ;; esac
exec "{python}" -m ziglang {name} -target x86_64-linux-gnu.2.17 "$@"
"""
SETS = ["baseline", "avx2", "avx512"]
SLOWER = 1.10
"""How much slower than the wheel that GCC builds on this machine a tick may be."""
PATIENCE = 4
"""So many times the rounds are repeated until a wheel is fast enough."""
SAMPLE = ["tests/unit/control", "tests/unit/laws", "tests/unit/test_inverse.py", "tests/unit/simulation/test_run.py"]
SAMPLE_NEEDS = [
    "daqp",
    "h5netcdf",
    "h5py",
    "hypothesis",
    "jsonschema",
    "matplotlib",
    "numpy",
    "pytest",
    "pytest-timeout",
    "pytest-xdist",
]
SAMPLE_NEEDS += ["scipy", "xarray"]


class Failed(Exception):
    """A gate that was not passed, with the reason."""


@dataclass
class Gates:
    """The lines of the table."""

    lines: list[tuple[str, bool, str]] = field(default_factory=list)

    def hold(self, name: str, check: Callable[[], str]) -> None:
        print(f"{name} ...", flush=True)
        try:
            self.lines.append((name, True, check()))
        except (Failed, OSError, subprocess.CalledProcessError) as error:
            said = (getattr(error, "stdout", None) or "") + (getattr(error, "stderr", None) or "")
            self.lines.append((name, False, " ".join(f"{error} {said[-2000:]}".split())))
        print(f"    {self.lines[-1][2]}", flush=True)

    def table(self) -> str:
        width = max(len(name) for name, _, _ in self.lines)
        return "\n".join(f"{name:<{width}}  {'yes' if good else 'NO '}  {said}" for name, good, said in self.lines)


def run(*command: str | Path, more: dict[str, str] | None = None, alone: bool = False) -> str:
    """What a command prints. alone: without a compiler and without this project's folder on the path."""
    environment = os.environ | (more or {})
    if alone:
        environment |= {"PATH": str(Path(command[0]).parent), "CC": "no-compiler-here", "CXX": "no-compiler-here"}
    done = subprocess.run(
        list(map(str, command)),
        cwd=WORK if alone else ROOT,
        env=environment,
        text=True,
        check=True,
        capture_output=True,
    )
    return done.stdout


def interpreter(version: str) -> Path:
    """The Python of this version: on the path, or one of pyenv's."""
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    found = [shutil.which(f"python{version}"), *sorted(pyenv.glob(f"{version}.*/bin/python"))]
    for path in filter(None, found):
        asked = subprocess.run(
            [path, "-c", "import sys, venv; print('%d.%d' % sys.version_info[:2])"], capture_output=True
        )
        if asked.stdout.decode().strip() == version:
            return Path(path)
    raise Failed(f"no Python {version} was found on the path or in pyenv")


def environment(folder: str, version: str) -> Path:
    """The Python of a new virtual environment."""
    shutil.rmtree(WORK / folder, ignore_errors=True)
    run(interpreter(version), "-m", "venv", WORK / folder)
    return WORK / folder / "bin" / "python"


def pinned(names: list[str]) -> list[str]:
    lines = (ROOT / "requirements" / "test.txt").read_text().splitlines()
    return [line.split()[0] for line in lines if line.split("==")[0] in names]


def tools() -> Path:
    """The folder of the commands that build and audit."""
    stamp = WORK / "tools" / "installed"
    needed = (ROOT / "requirements" / "wheels.txt").read_text()
    if not stamp.exists() or stamp.read_text() != needed:
        run(environment("tools", "3.11"), "-m", "pip", "install", "-q", "-r", "requirements/wheels.txt")
        stamp.write_text(needed)
    binaries = WORK / "tools" / "bin"
    for name in ("cc", "c++"):
        script = binaries / f"zig-{name}"
        script.write_text(COMPILER.format(python=binaries / "python", name=name))
        script.chmod(0o755)
    return binaries


def built(tag: str, binaries: Path, out: Path) -> Path:
    """The wheel of this tag, in `out`."""
    python = environment(f"build-{tag}", BUILT_WITH[tag])
    run(python, "-m", "pip", "install", "-q", "-r", "requirements/build.txt")
    raw = WORK / f"raw-{tag}"
    for old in (raw, WORK / tag):
        shutil.rmtree(old, ignore_errors=True)
    compiler = {
        "CC": str(binaries / "zig-cc"),
        "CXX": str(binaries / "zig-c++"),
        "CXXFLAGS": "-include cstdio",  # libc++ does not bring it along, and nanobind's headers use it
        "PATH": f"{python.parent}:{binaries}:{os.environ['PATH']}",
        "ZIG_GLOBAL_CACHE_DIR": str(WORK / "zig"),
    }
    for launcher in ("CMAKE_C_COMPILER_LAUNCHER", "CMAKE_CXX_COMPILER_LAUNCHER"):
        compiler[launcher] = ""
    folder = f"build-dir={WORK / tag}"
    command = [python, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", raw, "-C", folder, "."]
    run(*command, more=compiler)
    (wheel,) = raw.glob("*.whl")
    path = {"PATH": f"{binaries}:{os.environ['PATH']}"}
    run(binaries / "auditwheel", "repair", "--only-plat", "--plat", PLATFORM, "-w", out, wheel, more=path)
    (repaired,) = out.glob(f"stillreach-*-{tag}-*{PLATFORM}.whl")
    return repaired


def audited(wheel: Path, binaries: Path) -> str:
    said = " ".join(
        run(binaries / "auditwheel", "show", wheel, more={"PATH": f"{binaries}:{os.environ['PATH']}"}).split()
    )
    if f'"{PLATFORM}"' not in said:
        raise Failed(said)
    return f"auditwheel: {PLATFORM}, {wheel.stat().st_size / 1e6:.1f} MB"


def stable(wheel: Path, binaries: Path) -> str:
    if "-abi3-" not in wheel.name:
        raise Failed(f"{wheel.name} does not have the stable ABI: CMake did not find Python::SABIModule")
    report = json.loads(run(binaries / "abi3audit", "--report", "--strict", wheel).split("\n", 1)[0])
    (checked,) = report["specs"].values()
    results = [entry["result"] for entry in checked["wheel"]]
    if not results or any(not result["is_abi3"] or result["non_abi3_symbols"] for result in results):
        raise Failed(str(results))
    return f"abi3audit: {len(results)} module, no symbol outside the stable ABI of {results[0]['baseline']}"


def installed(version: str, wheel: Path) -> str:
    python = environment(f"user-{version}", version)
    run(python, "-m", "pip", "install", "-q", "--only-binary", ":all:", wheel, *pinned(SAMPLE_NEEDS), alone=True)
    said = run(python, "-c", "import stillreach as sr; print(sr.__version__, sr.__file__)", alone=True).split()
    return f"installed without a compiler, version {said[0]}"


def sampled(version: str) -> str:
    python = WORK / f"user-{version}" / "bin" / "python"
    tests = [ROOT / name for name in SAMPLE]
    options = [
        "-q",
        "-n",
        str(os.cpu_count()),
        "-p",
        "no:cacheprovider",
        "--rootdir",
        ROOT,
        "-c",
        ROOT / "pyproject.toml",
    ]
    said = run(python, "-m", "pytest", *options, *tests, alone=True)
    return said.strip().splitlines()[-1].strip("= ")


def same_bits(version: str, reference: Path) -> str:
    python, said = WORK / f"user-{version}" / "bin" / "python", []
    if sample_set(python) != sample_set(reference):
        raise Failed(f"it chooses {sample_set(python)}, the build of GCC {sample_set(reference)}")
    for instructions in available(reference):
        ours, gcc = (sample(which, "bits", instructions) for which in (python, reference))
        different = [law for law in gcc if ours[law] != gcc[law]]
        if different:
            raise Failed(f"{instructions}: other bits than the build of GCC for {', '.join(different)}")
        said.append(instructions)
    return f"the bits of the build of GCC, {len(gcc)} laws, with {', '.join(said)}"


def available(reference: Path) -> list[str]:
    return SETS[: SETS.index(sample_set(reference)) + 1]


def sample_set(python: Path) -> str:
    return run(python, "-c", "import stillreach._core as core; print(core.instruction_set())", alone=True).strip()


def sample(python: Path, what: str, instructions: str = "avx512") -> dict:
    script = ROOT / "scripts" / "wheel_sample.py"
    return json.loads(run(python, script, what, more={"STILLREACH_INSTRUCTIONS": instructions}, alone=True))


def speed(version: str, reference: Path, rounds: int) -> str:
    """Minima over processes, taken in turn; more of them while the machine has other work."""
    best: dict[str, dict[str, float]] = {"ours": {}, "gcc": {}}
    # another Python calls at another speed: only the batch shows the compiled code alone
    same = version == run(reference, "-c", "import sys; print('%d.%d' % sys.version_info[:2])").strip()
    gated = ["tick", "batch"] if same else ["batch"]
    for turn in range(PATIENCE * rounds):
        for name, python in (("ours", WORK / f"user-{version}" / "bin" / "python"), ("gcc", reference)):
            for what, value in sample(python, "times").items():
                best[name][what] = min(best[name].get(what, value), value)
        ratio = {what: best["ours"][what] / best["gcc"][what] for what in best["gcc"]}
        fast = all(ratio[what] <= SLOWER for what in gated)
        if fast and turn + 1 >= rounds:
            break
    texts = "; ".join(f"{what} {best['ours'][what]:.2f} µs, {ratio[what]:.2f} of GCC's" for what in ratio)
    if not fast:
        raise Failed(texts)
    return texts


def first_picture(version: str, wheel: Path) -> str:
    python = environment(f"time-{version}", version)
    seconds = {}
    for name, command in {
        "other packages": [python, "-m", "pip", "install", "-q", *pinned(["numpy", "rich", "typer", "matplotlib"])],
        "our wheel": [python, "-m", "pip", "install", "-q", wheel],
        "the picture": [python.with_name("stillreach"), "run", "panda-elbow", "--out", WORK / "picture"],
    }.items():
        began = time.perf_counter()
        run(*command, alone=True)
        seconds[name] = time.perf_counter() - began
    if not list((WORK / "picture").rglob("*.png")):
        raise Failed("stillreach run drew no picture")
    parts = ", ".join(f"{name} {value:.1f} s" for name, value in seconds.items())
    return f"{sum(seconds.values()):.1f} s from nothing: {parts}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="folder for the wheels (default: dist)")
    parser.add_argument("--rounds", type=int, default=5, help="repeats of each timing (default: 5)")
    parser.add_argument(
        "--reference", type=Path, default=ROOT / ".venv" / "bin" / "python", help="Python with GCC's build"
    )
    arguments = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    out, reference = arguments.out.resolve(), arguments.reference.absolute()
    for old in out.glob("stillreach-*.whl"):
        old.unlink()
    binaries = tools()
    gates, wheels = Gates(), {}

    def build(tag: str) -> str:
        wheels[tag] = built(tag, binaries, out)
        return wheels[tag].name

    for tag in BUILT_WITH:
        gates.hold(f"{tag}: built", lambda tag=tag: build(tag))
        if tag in wheels:
            gates.hold(f"{tag}: old C library", lambda tag=tag: audited(wheels[tag], binaries))
    if "cp312" in wheels:
        gates.hold("cp312: stable ABI", lambda: stable(wheels["cp312"], binaries))
    for version in PYTHONS:
        wheel = wheels.get("cp311" if version == "3.11" else "cp312")
        if wheel is None:
            continue
        gates.hold(f"{version}: installs", lambda v=version, wheel=wheel: installed(v, wheel))
        if not gates.lines[-1][1]:
            continue
        gates.hold(f"{version}: tests", lambda v=version: sampled(v))
        gates.hold(f"{version}: bits", lambda v=version: same_bits(v, reference))
        gates.hold(f"{version}: speed", lambda v=version: speed(v, reference, arguments.rounds))
        gates.hold(f"{version}: first picture", lambda v=version, wheel=wheel: first_picture(v, wheel))
    print(f"\n{gates.table()}")
    return 0 if wheels and all(good for _, good, _ in gates.lines) else 1


if __name__ == "__main__":
    sys.exit(main())
