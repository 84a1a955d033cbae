"""What a tick costs is gated on what is exact: instructions, within 5 % of the stored figures."""

import shutil
from pathlib import Path

import pytest
from cpp_build import build_targets

from bench.instructions import Counts, count, out_of_line

STORED = Counts.stored()
RENEW = "`make instructions` stores the new figures"

pytestmark = pytest.mark.timeout(600)


@pytest.fixture(scope="module")
def build() -> Path:
    """The driver, compiled with the kernels of a release."""
    return build_targets("ticks") / "tests" / "cpp" / "ticks"


def test_every_kind_of_tick_has_a_stored_figure(build: Path) -> None:
    assert set(Counts.nothing_yet(build).instructions) == set(STORED.instructions), RENEW


@pytest.mark.skipif(shutil.which("valgrind") is None, reason="apt-get install valgrind")
@pytest.mark.parametrize("kind", STORED.instructions)
def test_a_tick_takes_as_many_instructions_as_it_did(build: Path, kind: str) -> None:
    measured, stored = count(build, kind), STORED.instructions[kind]
    if reason := Counts.nothing_yet(build).unlike(STORED):
        pytest.skip(f"{reason}: {measured} instructions, not compared")
    assert not out_of_line(measured, stored), f"{measured} instructions, stored are {stored}; if meant so, {RENEW}"


def test_more_than_5_percent_is_seen_to_either_side() -> None:
    assert [out_of_line(measured, stored=1000) for measured in (940, 960, 1040, 1060)] == [True, False, False, True]


@pytest.mark.parametrize(
    ("compiler", "instruction_set", "reason"),
    [
        ("GCC 12.3.1", "avx2", None),
        ("GCC 13.1.0", "avx2", "counted for GCC 12, this is GCC 13"),
        ("Clang 12.0.0", "avx2", "counted for GCC 12, this is Clang 12"),
        ("GCC 12.2.0", "baseline", "counted for avx2, this machine runs baseline"),
    ],
)
def test_figures_of_another_compiler_do_not_compare(compiler: str, instruction_set: str, reason: str | None) -> None:
    stored = Counts("GCC 12.2.0", "avx2", {})
    assert Counts(compiler, instruction_set, {}).unlike(stored) == reason
