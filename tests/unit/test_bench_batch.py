"""The batch's benchmark: its rows, its tables, the page that they stand in, what counts as a stage."""

from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
from bench import batch, stages, why
from bench.batch import REQUIRED, Case, solver
from bench.rows import make_rows
from bench.timing import Row
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


def test_every_law_is_measured_and_every_table_printed() -> None:
    said = "\n\n".join(batch.run(40, 1))
    for name in (*batch.LAWS, "`forward`", "`jacobian`", "`rollout_batch`", "working joints", "two threads"):
        assert name in said


def test_a_rate_is_that_of_the_shortest_pieces_and_a_requirement_is_met_or_not() -> None:
    """Two pieces and the whole, two repeats each [µs a row]."""
    cases = [Case(name, lambda part: None) for name in REQUIRED]
    for case in cases:
        case.row = Row(case.name, "", case.run, times=[[0.3, 0.1], [0.2, 0.5], [0.4, 0.6]])
    assert cases[0].cells() == [cases[0].name, "6.67", "2.00", "150"]
    lines = batch.requirements(cases, {"a law": 1.69, "another": 1.7}).splitlines()
    assert [line.startswith("- met") for line in lines] == [*(need <= 6.67 for need in REQUIRED.values()), False, True]


def test_the_page_has_a_place_for_what_each_command_prints_and_keeps_its_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = tmp_path / "page.md"
    page.write_text(before := why.PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr(why, "PAGE", page)
    monkeypatch.setattr(why, "measure", lambda part: f"what {part} printed")
    monkeypatch.setattr("sys.argv", ["why"])
    why.main()
    after = page.read_text(encoding="utf-8")
    for part in why.PARTS:
        mark = f"<!-- figures: {part} -->"
        assert after.split(mark)[0].splitlines()[-1:] == before.split(mark)[0].splitlines()[-1:]
        assert f"{mark}\nwhat {part} printed\n<!-- /figures: {part} -->" in after


def test_parts_that_are_none_are_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["why", "batches"])
    with pytest.raises(SystemExit):
        why.main()
    assert "batches" in capsys.readouterr().err


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
