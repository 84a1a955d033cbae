"""Several builds of one header live in one library; the linker must never swap one for the other.

A function that two objects define as a weak symbol of one name is kept once, from either: an illegal instruction on
a machine without AVX2, and nothing says so before it runs.
"""

import os
import platform
import re
import shutil
import subprocess
import sys
from itertools import combinations
from pathlib import Path

import pytest
from cpp_build import build_targets, run

X86_64 = platform.machine() in ("x86_64", "AMD64")
AVX_ARITHMETIC = re.compile(r"\bv(?:add|mul|fn?m(?:add|sub)\d+)[sp]d\b|%ymm")
OLD_MACHINE = ["qemu-x86_64", "-cpu", "Nehalem"]

AVX512_ARITHMETIC = re.compile(r"%zmm|%k[0-7]")
SETS = ("baseline", "avx2", "avx512")

pytestmark = pytest.mark.skipif(not X86_64, reason="only x86-64 has several instruction sets")
needs_qemu = pytest.mark.skipif(shutil.which(OLD_MACHINE[0]) is None, reason="apt-get install qemu-user")


@pytest.fixture(scope="module")
def build() -> Path:
    """The C++ build folder with the kernels up to date: nothing to do after `make cpp-test`."""
    return build_targets(*(f"stillreach_{name}" for name in SETS))


def kernel_object(build: Path, name: str) -> Path:
    return build / "CMakeFiles" / f"stillreach_{name}.dir" / "dispatch" / "kernel.cpp.o"


def weak_symbols(path: Path) -> set[str]:
    """Names that an object defines and leaves to the linker to merge; references to runtime support are data."""
    lines = [line.split() for line in run("nm", "--defined-only", "--format=posix", path).splitlines()]
    return {name for name, kind, *_ in lines if kind in "VWuvw" and not name.startswith("DW.ref.")}


@pytest.mark.timeout(600)
def test_the_kernels_share_no_weak_symbol(build: Path) -> None:
    for one, other in combinations([weak_symbols(kernel_object(build, name)) for name in SETS], 2):
        assert one & other == set()


@pytest.mark.timeout(600)
def test_the_kernels_are_compiled_for_what_they_are_named_after(build: Path) -> None:
    baseline, avx2, avx512 = (run("objdump", "-d", "--no-show-raw-insn", kernel_object(build, name)) for name in SETS)
    assert AVX_ARITHMETIC.search(baseline) is None
    assert AVX_ARITHMETIC.search(avx2)
    assert AVX512_ARITHMETIC.search(baseline + avx2) is None
    assert AVX512_ARITHMETIC.search(avx512)


def test_a_shared_weak_symbol_is_seen(tmp_path: Path) -> None:
    source = tmp_path / "inline.cpp"
    source.write_text("inline __attribute__((noinline)) int f(int x) { return x; }\nint NAME(int x) { return f(x); }\n")
    objects = []
    for name in ("g", "h"):
        objects.append(tmp_path / f"{name}.o")
        run(os.environ.get("CXX", "c++"), "-O2", f"-DNAME={name}", "-c", source, "-o", objects[-1])
    assert weak_symbols(objects[0]) & weak_symbols(objects[1]) == {"_Z1fi"}


@needs_qemu
@pytest.mark.timeout(600)
def test_a_tick_of_a_cpp_program_runs_on_a_machine_without_avx(build: Path) -> None:
    build_targets("test_tick")
    run(*OLD_MACHINE, build / "tests" / "cpp" / "test_tick")


TICK = """
import numpy as np, stillreach as sr, stillreach._core as core
arm = sr.arms.nasa_modular()
controller = sr.Controller(arm, law=sr.SingularityRobust(damping="exact"))
controller.fail("j4")
print(core.instruction_set(), *controller.step(np.linspace(0.1, 1.0, arm.n), np.ones(6)).rates)
"""


@needs_qemu
def test_a_tick_from_python_runs_on_a_machine_without_avx() -> None:
    _, *rates = run(sys.executable, "-c", TICK).split()
    path, *old_rates = run(*OLD_MACHINE, sys.executable, "-c", TICK).split()
    assert path == "baseline"
    assert list(map(float, old_rates)) == pytest.approx(list(map(float, rates)), rel=1e-9, abs=1e-12)


@pytest.mark.skipif(not Path("/proc/cpuinfo").exists(), reason="only Linux lists what its processor has")
def test_the_widest_set_that_the_processor_has_is_chosen() -> None:
    flags = set(re.search(r"^flags\s*:(.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)[1].split())
    expected = "baseline"
    if {"avx2", "fma"} <= flags:
        expected = "avx512" if {"avx512f", "avx512dq"} <= flags else "avx2"
    for named in SETS:
        environment = {**os.environ, "STILLREACH_INSTRUCTIONS": named}
        code = "import stillreach._core as core; print(core.instruction_set())"
        chosen = subprocess.run(
            [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
        )
        assert chosen.stdout.strip() == min(named, expected, key=SETS.index)
