"""The batch's benchmark: its rows, its count of operations, its tables, what it tells apart in instructions."""

import json
import re
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
from bench import batch_tables, kernel, operations, stages, why
from bench.batch import Case, Result, call_costs, law_cases, solver, thread_cases, timed, working_cases
from bench.machine import Peak
from bench.rows import make_rows
from bench.workload import LIMIT, arm


@pytest.mark.parametrize("working", [11, 8, 6, 5, 3])
def test_exactly_the_asked_part_of_the_rows_is_over_the_limit(working: int) -> None:
    rows, robot = make_rows(400, working=working), arm()
    joints = np.flatnonzero(rows.upper)
    assert len(joints) == working
    if working == 8:
        assert [robot.joint_names[j] for j in np.flatnonzero(rows.upper == 0.0)] == ["j2", "j4", "j7"]
    largest = [
        np.max(np.abs(np.linalg.pinv(J[:, joints]) @ twist))
        for J, twist in zip(robot.jacobian(rows.q), rows.twist, strict=True)
    ]
    assert np.array_equal(np.array(largest) > LIMIT, rows.over)
    assert np.count_nonzero(rows.over) == 60


def test_other_joints_fail_in_each_mixed_row_and_as_many_are_over() -> None:
    rows, robot = make_rows(400, mixed=True), arm()
    assert np.all(np.count_nonzero(rows.upper, axis=1) == 8)
    assert len({tuple(row) for row in rows.upper}) > 100
    largest = [
        np.max(np.abs(np.linalg.pinv(J * (upper > 0)) @ twist))
        for J, upper, twist in zip(robot.jacobian(rows.q), rows.upper, rows.twist, strict=True)
    ]
    assert np.array_equal(np.array(largest) > LIMIT, rows.over)


def test_the_library_sees_the_same_rows_over_the_limit() -> None:
    rows = make_rows(1000)
    status = solver(sr.Pseudoinverse(), rows)(slice(0, 1000)).status
    assert np.array_equal((status & sr.Status.OVER_LIMIT) != 0, rows.over)
    by_row = rows.bounds_by_row()
    assert np.array_equal(solver(sr.Pseudoinverse(), by_row)(slice(0, 1000)).status, status)
    assert np.array_equal(rows.q, make_rows(1000).q)


def test_a_file_of_rows_holds_them_in_order(tmp_path: Path) -> None:
    rows = make_rows(5)
    rows.write(tmp_path / "rows")
    read = np.fromfile(tmp_path / "rows")
    assert len(read) == 5 * 17 + 22
    assert np.array_equal(read[55:85].reshape(5, 6), rows.twist)
    assert np.array_equal(read[-11:], rows.upper)


class Counting:
    """A number that counts what is done with it, in place of the algorithm's own numbers."""

    done = 0

    def _more(self, other: object) -> "Counting":
        Counting.done += 1
        return self

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _more


def counted(work: object) -> int:
    Counting.done = 0
    work()  # type: ignore[operator]
    return Counting.done


def test_operations_of_the_gram_matrix_its_factor_and_solution_are_those_of_the_algorithm() -> None:
    """The textbook loops on numbers that count; a sum starts at its first term's 0, as in the code."""
    m, k = 6, 8
    x = Counting()

    def gram() -> None:
        for _ in range(k):
            for r in range(m):
                for _ in range(r + 1):
                    x + x * x
        for _ in range(m):
            x + x

    def factor() -> None:
        for j in range(m):
            x + x  # trace
            for i in range(j, m):
                for _ in range(j):
                    x - x * x
                if i > j:
                    x * x
            1.0 / x
        for j in range(m):
            for i in range(j + 1, m):
                for _ in range(j + 1, i):
                    x - x * x
                x + (x * x) * x  # trace of the inverse: its terms
            x + x
        x * x

    def solve() -> None:
        for i in range(m):
            for _ in range(i):
                x + x * x
            x * x
        for j in range(m):
            for _ in range(j + 1, m):
                x + x * x
        for _ in range(k):
            for _ in range(m):
                x + x * x

    assert operations.gram(k) == counted(gram)
    assert operations.factor() == counted(factor)
    assert operations.solve(k) == counted(solve)


def test_operations_grow_linearly_with_joints() -> None:
    for count in (operations.kinematics, operations.gram, operations.solve, operations.checks):
        assert count(30) - count(20) == count(20) - count(10)


@cache
def result() -> Result:
    rows = make_rows(40)
    figures = (
        timed(law_cases(rows), 40, 2, 1) + timed(working_cases(20), 20, 2, 1) + timed(thread_cases(rows), 40, 2, 1)
    )
    return Result("avx2", 40, 1, figures, call_costs(rows, 1), Peak(3.0, 48.0, 0.0), ["before.", "after."])


def test_every_law_is_measured_and_written_and_comes_back() -> None:
    before = result()
    written = json.loads(json.dumps(batch_tables.as_json(before)))
    assert batch_tables.from_json(written) == before
    page = batch_tables.text(before)
    for law in ("Pseudoinverse", "exact", "closed form", "LeastError()", "KeepDirection", "rollout_batch", "jacobian"):
        assert law in page
    assert {figure.working for figure in before.of("working")} == {11, 8, 6, 5, 3}
    assert all(0.0 < figure.best <= figure.median for figure in before.figures)
    assert {figure.name for figure in before.of("laws")} == set(kernel.LAWS.values())


def test_a_requirement_is_met_or_not() -> None:
    one = result()
    needed = [figure for figure in one.of("laws") if figure.need]
    assert len(needed) == 4
    for scale, word in ((0.9, "- met"), (1.1, "- NOT MET")):
        laws = [replace(figure, best=scale / figure.need) for figure in needed if figure.need]
        lines = batch_tables.requirements(replace(one, figures=laws)).splitlines()
        assert [line.startswith(f"{word}: ") for line in lines] == [True] * 4


def test_the_share_of_the_peak_is_operations_over_time_and_peak() -> None:
    figure = Case("laws", "a law", lambda part: None, operations=2400)
    figure.row = type("Times", (), {"times": [[0.2, 0.4], [0.1, 0.3]]})()  # pieces, whole [µs]
    line = batch_tables.law_line(replace(result(), peak=Peak(2.0, 48.0)), figure.figure())
    assert line == ["a law", "10.00", "5.00", "100", "200", "2400", "50 %"]
    line = batch_tables.law_line(replace(result(), peak=Peak(2.0, 48.0)), replace(figure.figure(), kernel=0.08))
    assert line[-3:] == ["80", "160", "62 %"]
    eight = replace(result(), instruction_set="avx512", peak=Peak(2.0, 48.0, 96.0))
    assert batch_tables.law_line(eight, figure.figure())[-1] == "25 %"


def test_what_avx512_gives_is_told_where_the_machine_has_it() -> None:
    assert "no AVX-512" in why.eight_lanes(result())
    told = why.eight_lanes(replace(result(), instruction_set="avx512", peak=Peak(2.0, 48.0, 96.0)))
    assert "`Pseudoinverse`" in told
    assert "96.0 of 512 bits" in told


def test_the_page_of_figures_has_a_place_for_each_and_keeps_its_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts = [
        stages.Count(law, dict.fromkeys([*stages.STAGES, stages.ALONE], 10.0), dict.fromkeys(stages.KINDS, 10.0), 900.0)
        for law in stages.LAWS.values()
    ]
    timed_alone = [replace(figure, kernel=0.1) if figure.table == "laws" else figure for figure in result().figures]
    (tmp_path / "batch.json").write_text(json.dumps(batch_tables.as_json(replace(result(), figures=timed_alone))))
    (tmp_path / "wide.json").write_text((tmp_path / "batch.json").read_text())
    (tmp_path / "stages.json").write_text(json.dumps([asdict(one) for one in counts]))
    for part in ("tick", "long_arms"):
        (tmp_path / f"{part}.md").write_text(f"| of {part} |\n")
    page = tmp_path / "page.md"
    page.write_text(why.PAGE.read_text(encoding="utf-8"))
    for name, value in (("OUT", tmp_path), ("PAGE", page), ("PLOT", tmp_path / "plot.png"), ("ROOT", tmp_path)):
        monkeypatch.setattr(why, name, value)
    monkeypatch.setattr("sys.argv", ["why", "--kept"])
    why.main()
    figures = re.compile(r"(<!-- figures: (\w+) -->\n).*?(<!-- /figures: \2 -->)", re.DOTALL)
    after = page.read_text(encoding="utf-8")
    assert {match[2] for match in figures.finditer(after)} == set(why.sections())
    assert all(text in after for text in why.sections().values())
    words = Path(why.__file__).parents[1] / "docs" / "why-it-is-fast.md"
    assert figures.sub(r"\1\3", after) == figures.sub(r"\1\3", words.read_text(encoding="utf-8"))
    assert (tmp_path / "plot.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("given", "said"),
    [(["batches"], "batches not among batch, wide, stages, tick, long_arms"), (["--kept", "tick"], "--kept")],
)
def test_parts_that_are_none_are_named(
    given: list[str], said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["why", *given])
    with pytest.raises(SystemExit):
        why.main()
    assert said in capsys.readouterr().err


CALLGRIND = """\
positions: instr line
events: Ir
ob=/somewhere/rows
fn=piece
0x10 3 100
calls=2 0x20 7
0x14 3 999
0x14 3 5
ob=/lib/libm.so
fn=sin
0x10 0 77
ob=/somewhere/rows
fn=other
0x10 4 1
"""


def test_only_the_programs_own_instructions_count_and_none_twice() -> None:
    assert stages.addresses(CALLGRIND, "rows") == {0x10: 101, 0x14: 5}


@pytest.mark.parametrize(
    ("mnemonic", "operands", "kind", "done"),
    [
        ("vfmadd231pd", "%ymm1,%ymm2,%ymm3", "multiply-add", 8),
        ("vfnmadd213sd", "%xmm1,%xmm2,%xmm3", "multiply-add", 2),
        ("vmulpd", "%ymm1,%ymm2,%ymm3", "add, multiply", 4),
        ("vaddsd", "%xmm1,%xmm2,%xmm3", "add, multiply", 1),
        ("vdivpd", "%ymm1,%ymm2,%ymm3", "divide, root", 4),
        ("vcmpltpd", "%ymm1,%ymm2,%ymm3", "masks, choices", 0),
        ("vblendvpd", "%ymm1,%ymm2,%ymm3,%ymm4", "masks, choices", 0),
        ("vpaddq", "%ymm1,%ymm2,%ymm3", "masks, choices", 0),
        ("vmovapd", "(%rax),%ymm3", "load, store, move", 0),
        ("vunpcklpd", "%ymm1,%ymm2,%ymm3", "shuffle", 0),
        ("add", "$0x8,%rax", stages.OTHER, 0),
        ("or", "%eax,%ebx", stages.OTHER, 0),
    ],
)
def test_instructions_are_told_apart(mnemonic: str, operands: str, kind: str, done: int) -> None:
    assert stages.kind(mnemonic) == kind
    assert stages.operations_of(mnemonic, operands) == done


def test_an_instruction_belongs_to_the_stage_that_it_was_inlined_into() -> None:
    madd = "stillreach::avx2::madd(Pack, Pack, Pack) include/stillreach/simd/scalar.hpp:40"
    gram = "void stillreach::avx2::gram<6>(Pack const* const*) include/stillreach/batch/lane_solve.hpp:60"
    wide = "long stillreach::avx2::solve_wide<6>(Pack const* const*) include/stillreach/batch/lane_solve.hpp:140"
    box = "long stillreach::avx2::solve_box<6>(LaneBox<6>&) include/stillreach/batch/lane_box.hpp:300"
    lanes = "int stillreach::avx2::lane_pass<6>(Batch const&) include/stillreach/batch/batch.hpp:250"
    sines = "void stillreach::avx2::sincos(Pack const*, int) include/stillreach/kinematics/lane_kinematics.hpp:30"
    poses = "void stillreach::avx2::kinematics(ArmView const&) include/stillreach/kinematics/lane_kinematics.hpp:40"
    alone = "void stillreach::avx2::solve_law(LawSettings const&) include/stillreach/laws/law.hpp:20"
    assert stages.stage([madd, gram, wide, lanes]) == "Gram, factor, solve"
    assert stages.stage([madd, gram, box]) == "search"
    assert stages.stage([madd, sines, poses, lanes]) == "sines"
    assert stages.stage([madd, poses, lanes]) == "kinematics"
    assert stages.stage([lanes]) == "rows in and out"
    assert stages.stage([madd, alone]) == stages.ALONE
