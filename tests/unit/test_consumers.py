"""Projects of users find, build, link and run the C++ core, in each of the ways of docs/cpp.md.

Kernels are compiled for one instruction set and lightly; STILLREACH_FULL=1 builds all of them as a user gets them.
"""

import os
import platform
import shutil
from importlib import metadata
from pathlib import Path

import pytest
from cpp_build import ROOT, has_header, run

import stillreach as sr
from tests.docs.pages import blocks

CONSUMERS = ROOT / "tests" / "consumers"
VERSION = ".".join(metadata.version("stillreach").split(".")[:2])
PROGRAMS = blocks((ROOT / "docs" / "cpp.md").read_text(), "cpp")
PROGRAM, URDF = (next(one for one in PROGRAMS if header in one.code) for header in ("/stillreach.hpp", "/urdf.hpp"))
LIGHT = ("-DSTILLREACH_INSTRUCTION_SETS=baseline", "-DKERNEL_OPTIONS=-O0")
FULL = bool(os.environ.get("STILLREACH_FULL"))

pytestmark = pytest.mark.timeout(600)
each_compiler = pytest.mark.parametrize(
    "compiler",
    [
        pytest.param(name, marks=pytest.mark.skipif(shutil.which(name) is None, reason=f"apt-get install {package}"))
        for name, package in (("g++", "g++"), ("clang++", "clang"))
    ],
)


@pytest.fixture(scope="module")
def prefix(tmp_path_factory) -> Path:
    """An installation of the headers that was moved after it was made."""
    folder = tmp_path_factory.mktemp("installed")
    run("cmake", "-S", ROOT, "-B", folder / "build", "-G", "Ninja")
    run("cmake", "--install", folder / "build", "--prefix", folder / "first")
    return (folder / "first").rename(folder / "prefix")


@pytest.fixture(scope="module")
def arm(tmp_path_factory) -> Path:
    """The loop of docs/cpp.md: an arm, a fault, 200 ticks."""
    source = tmp_path_factory.mktemp("source") / "arm.cpp"
    source.write_text(PROGRAM.code, encoding="utf-8")
    return source


def built(source: Path, folder: Path, compiler: str, *definitions: str) -> Path:
    """Configures and builds a user's project in ``folder``."""
    run("cmake", "-S", source, "-B", folder, "-G", "Ninja", f"-DCMAKE_CXX_COMPILER={compiler}", *definitions)
    run("cmake", "--build", folder, "--parallel", "2")
    return folder


@each_compiler
def test_a_project_finds_an_installed_package(compiler: str, prefix: Path, arm: Path, tmp_path: Path) -> None:
    programs = (f"-DVERSION={VERSION}", f"-DARM={arm}", f"-DDISPATCHED={CONSUMERS / 'dispatched.cpp'}")
    built(CONSUMERS, tmp_path, compiler, f"-DCMAKE_PREFIX_PATH={prefix}", *programs, *LIGHT)
    assert run(tmp_path / "arm") == PROGRAM.output
    assert run(tmp_path / "dispatched").startswith("baseline: ")


@each_compiler
@pytest.mark.skipif(not has_header("tinyxml2.h"), reason="apt-get install libtinyxml2-dev")
def test_a_project_asks_for_robots_from_urdf(compiler: str, prefix: Path, tmp_path: Path) -> None:
    source = tmp_path / "urdf.cpp"
    source.write_text(URDF.code, encoding="utf-8")
    found = f"-DCMAKE_PREFIX_PATH={prefix}", f"-DVERSION={VERSION}"
    built(CONSUMERS, tmp_path / "build", compiler, *found, f"-DURDF={source}", *LIGHT)
    assert run(tmp_path / "build" / "urdf") == URDF.output


@each_compiler
def test_a_project_finds_the_wheel(compiler: str, arm: Path, tmp_path: Path) -> None:
    found = f"-Dstillreach_DIR={sr.get_cmake_dir()}"
    built(CONSUMERS, tmp_path, compiler, found, f"-DVERSION={VERSION}", f"-DARM={arm}", *LIGHT)
    assert run(tmp_path / "arm") == PROGRAM.output


@each_compiler
def test_a_project_contains_stillreach(compiler: str, arm: Path, tmp_path: Path) -> None:
    """It gets no settings, options or targets of other names, and builds nothing that it does not link."""
    programs = (f"-DARM={arm}", f"-DDISPATCHED={CONSUMERS / 'dispatched.cpp'}")
    built(
        CONSUMERS / "fetched",
        tmp_path,
        compiler,
        f"-DSOURCE={ROOT}",
        *programs,
        "-DSTILLREACH_INSTRUCTION_SETS=baseline",
    )
    assert run(tmp_path / "arm") == PROGRAM.output
    assert [path.name for path in tmp_path.rglob("*.o")] == ["arm.cpp.o"]
    if FULL:
        run("cmake", "--build", tmp_path, "--target", "dispatched")
        assert run(tmp_path / "dispatched").startswith("baseline: ")


@each_compiler
@pytest.mark.skipif(shutil.which("pkg-config") is None, reason="apt-get install pkg-config")
def test_pkg_config_gives_the_options(compiler: str, prefix: Path, arm: Path, tmp_path: Path) -> None:
    def query(option: str) -> list[str]:
        return run("pkg-config", f"--with-path={prefix / 'share' / 'pkgconfig'}", option, "stillreach").split()

    assert query("--modversion") == [metadata.version("stillreach")]
    run(compiler, "-std=c++17", "-Werror", *query("--cflags"), arm, "-o", tmp_path / "arm")
    assert run(tmp_path / "arm") == PROGRAM.output


@each_compiler
def test_an_include_path_is_enough(compiler: str, arm: Path, tmp_path: Path) -> None:
    run(compiler, "-std=c++17", f"-I{sr.get_include()}", arm, "-o", tmp_path / "arm")
    assert run(tmp_path / "arm") == PROGRAM.output


@each_compiler
@pytest.mark.skipif(not FULL, reason="STILLREACH_FULL=1 compiles all kernels")
@pytest.mark.skipif(platform.machine() != "x86_64", reason="only x86-64 has several instruction sets")
@pytest.mark.parametrize("flags", ["", "-march=native -ffast-math"])
def test_a_program_chooses_its_instruction_set(
    compiler: str, flags: str, prefix: Path, tmp_path: Path, monkeypatch
) -> None:
    program = (f"-DVERSION={VERSION}", f"-DDISPATCHED={CONSUMERS / 'dispatched.cpp'}", f"-DCMAKE_CXX_FLAGS={flags}")
    built(CONSUMERS, tmp_path, compiler, f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Debug", *program)
    for most in ("baseline", "avx2"):
        monkeypatch.setenv("STILLREACH_INSTRUCTIONS", most)
        assert run(tmp_path / "dispatched").startswith(("baseline: ", f"{most}: "))


class TestConan:
    pytestmark = pytest.mark.skipif(shutil.which("conan") is None, reason="pip install conan")

    @pytest.fixture
    def created(self, tmp_path: Path, monkeypatch):
        """Creates the package without a remote, and says what a program of its consumer prints."""
        monkeypatch.setenv("CONAN_HOME", str(tmp_path / "home"))
        run("conan", "profile", "detect")
        folder = f"--conf=tools.cmake.cmake_layout:test_folder={tmp_path / 'build'}"

        def create(program: str, *options: str) -> str:
            run("conan", "create", ROOT, "--no-remote", f"--test-folder={CONSUMERS / 'conan'}", folder, *options)
            (built,) = (tmp_path / "build").rglob(program)
            return run(built)

        return create

    def test_a_project_finds_the_package(self, created) -> None:
        assert created("dispatched").startswith("baseline: ")

    @pytest.mark.skipif(not has_header("tinyxml2.h"), reason="apt-get install libtinyxml2-dev")
    def test_a_project_asks_for_robots_from_urdf(self, created, tmp_path: Path) -> None:
        """tinyxml2 is a recipe of the test: Conan's own is on its remote."""
        source = tmp_path / "urdf.cpp"
        source.write_text(URDF.code, encoding="utf-8")
        run("conan", "create", CONSUMERS / "tinyxml2", "--no-remote")
        options = (
            "--options=stillreach/*:urdf=True",
            "--settings=build_type=Debug",
            f"--conf=user.stillreach:urdf={source}",
        )
        assert created("urdf", *options) == URDF.output


def test_the_wheel_holds_every_header() -> None:
    headers = {path.relative_to(ROOT / "include"): path.read_text() for path in (ROOT / "include").rglob("*.hpp")}
    installed = Path(sr.get_include())
    assert headers == {path.relative_to(installed): path.read_text() for path in installed.rglob("*") if path.is_file()}
