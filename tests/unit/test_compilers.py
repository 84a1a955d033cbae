"""Clang and 64-bit Arm: the C++ tests pass, and the results are those of GCC on x86-64 to the last bit.

Arm has one kernel, with fused multiply-adds as AVX2 has; without them its results are the baseline's.
"""

import os
import platform
import shutil
from pathlib import Path

import pytest
from cpp_build import BUILD, ROOT, build_targets, run

FULL = bool(os.environ.get("STILLREACH_FULL"))
QEMU = "qemu-aarch64"
ARM_COMPILER = "aarch64-linux-gnu-g++"
ARM_LIBRARIES = Path("/usr/aarch64-linux-gnu")
ARM = (
    "-DCMAKE_SYSTEM_NAME=Linux",
    "-DCMAKE_SYSTEM_PROCESSOR=aarch64",
    f"-DCMAKE_CXX_COMPILER={ARM_COMPILER}",
    f"-DCMAKE_CROSSCOMPILING_EMULATOR={QEMU};-L;{ARM_LIBRARIES}",
)
LIGHT_TESTS = tuple(f"test_{name}" for name in ("allocation", "batch", "kinematics", "laws", "rollout", "tick"))

pytestmark = [
    pytest.mark.timeout(1800),
    pytest.mark.xdist_group("build"),
    pytest.mark.skipif(platform.machine() != "x86_64", reason="the results to compare with are those of x86-64"),
]
needs_clang = pytest.mark.skipif(shutil.which("clang++") is None, reason="apt-get install clang")
needs_arm = [
    pytest.mark.skipif(not FULL, reason="STILLREACH_FULL=1 compiles for Arm"),
    pytest.mark.skipif(shutil.which(ARM_COMPILER) is None, reason="apt-get install g++-aarch64-linux-gnu"),
    pytest.mark.skipif(shutil.which(QEMU) is None, reason="apt-get install qemu-user"),
]


def configured(name: str, *definitions: str) -> Path:
    """A build folder beside the one of `make cpp-test`, for another compiler."""
    folder = BUILD.with_name(f"{BUILD.name}-{name}")
    run("cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DSTILLREACH_TESTS=ON", *definitions)
    return folder


def make(folder: Path, *targets: str) -> None:
    run("cmake", "--build", folder, "--parallel", "2", *(f"--target={target}" for target in targets))


def arm_checksums(folder: Path) -> str:
    make(folder, "bits")
    return run(QEMU, "-L", ARM_LIBRARIES, folder / "tests" / "cpp" / "bits")


@pytest.fixture
def checksums(monkeypatch):
    """What the kernel of GCC computes with an instruction set at most, law by law."""

    def of(instruction_set: str, build: Path | None = None) -> str:
        program = (build or build_targets("bits")) / "tests" / "cpp" / "bits"
        monkeypatch.setenv("STILLREACH_INSTRUCTIONS", instruction_set)
        return run(program)

    return of


def test_the_laws_have_checksums_of_their_own(checksums) -> None:
    lines = [line.partition(": ") for line in checksums("baseline").splitlines()]
    assert len(lines) >= 9
    assert len({sums for _, _, sums in lines}) == len({name for name, _, _ in lines}) == len(lines)


@needs_clang
def test_clang_gives_the_bits_of_gcc(checksums) -> None:
    sets = "baseline;avx2;avx512" if FULL else "baseline"
    build = configured("clang", "-DCMAKE_CXX_COMPILER=clang++", f"-DSTILLREACH_INSTRUCTION_SETS={sets}")
    make(build, "bits")
    for instruction_set in sets.split(";"):
        assert checksums(instruction_set, build) == checksums(instruction_set)


@needs_clang
def test_the_cpp_tests_pass_with_clang() -> None:
    sets = "baseline;avx2;avx512" if FULL else "baseline"
    build = configured("clang", "-DCMAKE_CXX_COMPILER=clang++", f"-DSTILLREACH_INSTRUCTION_SETS={sets}")
    if FULL:
        make(build)
        run("ctest", "--test-dir", build, "--no-tests=error", "--output-on-failure", "-j", "2")
    else:
        make(build, *LIGHT_TESTS)
        for name in LIGHT_TESTS:
            run(build / "tests" / "cpp" / name)


class TestArm:
    pytestmark = needs_arm

    def test_arm_gives_the_bits_of_avx2(self, checksums) -> None:
        assert arm_checksums(configured("arm", *ARM)) == checksums("avx2")

    def test_arm_without_fused_multiply_adds_gives_the_bits_of_the_baseline(self, checksums) -> None:
        build = configured("arm-unfused", *ARM, "-DCMAKE_CXX_FLAGS=-U__ARM_FEATURE_FMA")
        assert arm_checksums(build) == checksums("baseline")

    def test_the_cpp_tests_pass_on_arm(self) -> None:
        build = configured("arm", *ARM)
        make(build)
        run("ctest", "--test-dir", build, "--no-tests=error", "--output-on-failure", "-j", "2")
