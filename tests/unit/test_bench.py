"""The comparison with other libraries: its workload, its judge, what it does with peers that fail, what it writes."""

import ast
import dataclasses
import re
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import lsq_linear

import stillreach as sr
from bench.compare import arguments
from bench.field import Peer, interleave
from bench.hostile import hostile_ticks
from bench.judge import judge
from bench.page import put
from bench.peers import ENTRIES, Entry
from bench.poses import POSES
from bench.problem import Problem, largest_fraction, least_error, make_batch, make_problem
from bench.report import MARK, report, requirements, table
from bench.workload import robot
from tests.conformance.registry import LAWS

ROOT = Path(__file__).parents[2]
PEERS = {
    f"bench.{folder}.{file.stem}": file
    for folder in ("peers", "poses")
    for file in (ROOT / "bench" / folder).glob("*.py")
    if file.stem not in ("__init__", "base", "race")
}


@pytest.fixture(scope="module")
def problem() -> Problem:
    return make_problem(128)


@pytest.fixture(scope="module")
def optimum(problem: Problem) -> np.ndarray:
    """Rates (ticks, n) of least error, by another solver than the one that the problem was made with."""
    rates, limit = np.zeros_like(problem.q), float(problem.limit)
    for row, J, twist in zip(rates, problem.jacobian[:, :, problem.working], problem.twist, strict=True):
        row[problem.working] = lsq_linear(J, twist, bounds=(-limit, limit), tol=1e-14, max_iter=1000, method="trf").x
    return np.clip(rates, -limit, limit)


def test_half_of_the_ticks_are_feasible_and_the_limit_bites(problem: Problem) -> None:
    assert np.sum(problem.feasible) == len(problem) // 2
    unlimited = [
        np.linalg.pinv(J[:, problem.working]) @ t for J, t in zip(problem.jacobian, problem.twist, strict=True)
    ]
    assert np.sum(np.max(np.abs(unlimited), axis=1) > problem.limit) >= len(problem) // 2
    assert np.all(problem.least[problem.feasible] == 0.0)
    assert np.all(problem.least[~problem.feasible] > 0.0)


def test_the_work_is_the_same_every_time_and_locked_joints_stand(problem: Problem) -> None:
    again = make_problem(128)
    for field in dataclasses.fields(Problem):
        assert np.array_equal(getattr(problem, field.name), getattr(again, field.name))
    assert np.all(problem.q[:, problem.locked] == problem.q[0, problem.locked])
    assert not np.any(np.all(problem.q[:, problem.working] == problem.q[0, problem.working], axis=0))


def test_feasibility_of_a_planar_box_is_known() -> None:
    J = np.eye(2)
    assert largest_fraction(J, np.array([3.0, 1.0]), 1.5) == pytest.approx(0.5)
    assert least_error(J, np.array([3.0, 5.5]), 1.5) == pytest.approx(np.hypot(1.5, 4.0))


def test_a_batch_has_as_many_rows_as_asked_and_knows_the_first() -> None:
    problem, q, twist = make_batch(40, judged=16)
    assert q.shape == (40, 11)
    assert np.array_equal(problem.q, q[:16])
    assert np.array_equal(problem.twist, twist[:16])
    assert np.sum(problem.feasible) == 8


def test_the_optimum_is_clean(problem: Problem, optimum: np.ndarray) -> None:
    verdict = judge(problem, optimum)
    assert (verdict.over_limit, verdict.locked_moved) == (0, 0)
    assert abs(verdict.excess) < 1e-6


def test_stillreach_is_clean(problem: Problem) -> None:
    law, bounds = sr.LeastError(price=None), sr.Bounds.symmetric(problem.limit, n=11).lock([1, 3, 6])
    rates = [law.solve(J, twist, bounds).rates for J, twist in zip(problem.jacobian, problem.twist, strict=True)]
    verdict = judge(problem, np.array(rates))
    assert verdict.clean
    assert verdict.worst_over <= 0.0
    assert verdict.worst_excess < 1e-9


def test_a_limit_violated_in_one_tick_is_seen(problem: Problem, optimum: np.ndarray) -> None:
    optimum = optimum.copy()
    optimum[17, 0] = -(1.0 + 1e-6) * problem.limit
    verdict = judge(problem, optimum)
    assert verdict.over_limit == 1
    assert verdict.worst_over == pytest.approx(1e-6)
    assert not verdict.safe


def test_a_locked_joint_that_moves_is_seen(problem: Problem, optimum: np.ndarray) -> None:
    optimum = optimum.copy()
    optimum[[3, 99], problem.locked[1]] = 1e-7, -0.1
    verdict = judge(problem, optimum)
    assert verdict.locked_moved == 2
    assert not verdict.safe


def test_a_peer_that_scales_every_twist_down_misses_feasible_ones(problem: Problem, optimum: np.ndarray) -> None:
    verdict = judge(problem, 0.9 * optimum)
    assert verdict.missed == verdict.feasible == len(problem) // 2
    assert verdict.excess > 0.01
    assert verdict.safe
    assert not verdict.clean


def test_a_peer_that_answers_zero_leaves_the_whole_twist(problem: Problem) -> None:
    verdict = judge(problem, np.zeros_like(problem.q))
    length = np.linalg.norm(problem.twist, axis=1)
    assert verdict.missed == verdict.feasible
    assert verdict.excess == pytest.approx(np.mean(1.0 - (problem.least / length)[~problem.feasible]))


def test_not_a_number_is_wrong_in_every_respect(problem: Problem, optimum: np.ndarray) -> None:
    optimum = optimum.copy()
    tick = int(np.flatnonzero(problem.feasible)[0])
    clean = judge(problem, optimum)
    optimum[tick] = np.nan
    verdict = judge(problem, optimum)
    assert (verdict.over_limit, verdict.locked_moved) == (1, 1)
    assert verdict.missed >= clean.missed


def test_rates_of_another_shape_are_refused(problem: Problem) -> None:
    with pytest.raises(ValueError, match=r"rates have shape \(128, 8\), expected \(128, 11\)"):
        judge(problem, np.zeros((128, 8)))


def test_peers_get_the_arm_without_its_failed_joints(problem: Problem, tmp_path: Path) -> None:
    given = robot(tmp_path)
    assert np.array_equal(given.working, problem.working)
    model = pin.buildModelFromUrdf(given.urdf)
    assert (model.nq, model.nv) == (8, 8)
    assert np.allclose(model.velocityLimit, problem.limit)
    joints = [sr.Joint(placement=T, axis=axis) for T, axis in zip(given.placements, given.axes, strict=True)]
    by_hand = sr.Arm(joints, tool=given.tool)
    for q, pose in zip(problem.q[:, problem.working], problem.pose, strict=True):
        data = model.createData()
        pin.framesForwardKinematics(model, data, q)
        assert np.allclose(data.oMf[model.getFrameId("tool")].homogeneous, pose)
        assert np.allclose(by_hand.forward(q), pose)


@pytest.mark.skipif(find_spec("pydrake") is not None, reason="Drake is installed: nothing is missing")
def test_a_peer_that_is_not_installed_is_left_out_with_its_reason(problem: Problem) -> None:
    missing, ours = Peer(ENTRIES["drake"]), Peer(ENTRIES["ours-bound"])
    for peer in (missing, ours):
        peer.start(problem)
    interleave([missing, ours], 0.0, 0.01, lambda turns: None)
    ours.stop()
    assert missing.reason == "ModuleNotFoundError: No module named 'pydrake'"
    assert ours.reason is None
    assert ours.verdict is not None
    assert ours.verdict.clean
    assert 0.0 < ours.best <= ours.median
    assert "Left out: Drake" in report([missing, ours], [], 128, 0, 2, {"busy machine: 3"})


def test_a_peer_that_crashes_keeps_its_times_and_leaves_the_others_alone(problem: Problem) -> None:
    first, second = Peer(ENTRIES["ours-bound"]), Peer(ENTRIES["ours-new"])
    for peer in (first, second):
        peer.start(problem)

    def crash(turns: int) -> None:
        if turns == 1:
            first.process.kill()
            first.process.join()

    interleave([first, second], 0.0, 0.01, crash)
    second.stop()
    assert first.reason == "killed by SIGKILL"
    assert first.best > 0.0
    assert second.reason is None
    assert len(second.times[0]) >= 3  # a pass at least in every turn, also after the crash


def cells(text: str) -> list[list[str]]:
    """Of a Markdown table, without its head."""
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()[2:]]


def test_a_table_and_its_requirements_say_who_is_slower_and_wrong(problem: Problem) -> None:
    ours, peer = Peer(ENTRIES["ours-bound"]), Peer(ENTRIES["pink"])
    ours.times, ours.verdict = [[2.0, 4.0, 3.0]], judge(problem, np.zeros_like(problem.q))
    peer.times, peer.verdict = [[100.0, 300.0, 200.0]], judge(problem, np.ones_like(problem.q))
    first, second = cells(table([peer, ours], "µs"))
    assert first[1:4] == ["2.00", "3.00", "1.0"]
    assert second[1:4] == ["100.00", "200.00", "50.0"]
    assert second[5] == "128"
    assert f"- MISSED: bound buffers over {peer.entry.title}: 50.0 times, required 80" in requirements([ours, peer])


def test_the_default_law_is_marked_like_any_other_whose_answers_are_wrong(
    problem: Problem, optimum: np.ndarray
) -> None:
    clean, ours, peer = (Peer(ENTRIES[key]) for key in ("ours-bound", "default-bound", "pink"))
    worse = np.where(problem.feasible[:, None], optimum, 0.5 * optimum)
    for each, rates in ((clean, optimum), (ours, 0.5 * optimum), (peer, 0.5 * optimum)):
        each.times, each.verdict = [[2.0]], judge(problem, rates)
    lines = cells(table([clean, ours, peer], "µs"))
    assert [MARK in line[0] for line in lines] == [False, True, True]
    assert lines[0][-2:] == ["0 of 64", "0"]
    ours.verdict = verdict = judge(problem, worse)
    assert verdict.clean
    (line,) = cells(table([ours], "µs"))
    assert MARK not in line[0]
    assert line[-1] == f"{100 * verdict.excess:.2g} % ({100 * verdict.worst_excess:.2g} %)"
    assert verdict.worst_excess > verdict.excess > 0.01


def test_a_page_keeps_all_but_what_lies_between_the_markers(tmp_path: Path) -> None:
    page = tmp_path / "README.md"
    page.write_text("before\n<!-- it -->\nold\n<!-- /it -->\nafter\n")
    put(page, "it", "new")
    assert page.read_text() == "before\n<!-- it -->\nnew\n<!-- /it -->\nafter\n"
    page.write_text("no markers\n")
    with pytest.raises(ValueError, match="<!-- it -->"):
        put(page, "it", "new")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["--peers", "pink,ponk"], "ponk not among"),
        (["--write", "--quick"], "only a full run"),
    ],
)
def test_options_that_make_no_sense_are_named(given: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        arguments(given)
    assert said in capsys.readouterr().err


def test_every_law_has_a_slowest_hostile_tick() -> None:
    rows = list(hostile_ticks(ticks=500, repeats=2))
    assert [row.law for row in rows] == list(LAWS)
    for row in rows:
        assert 0.0 < row.median < row.slowest


def test_every_peer_of_the_tables_has_its_file_and_every_file_its_row() -> None:
    listed = {f"{entry.package}.{entry.module}" for entry in (*ENTRIES.values(), *POSES)}
    assert sorted(listed ^ PEERS.keys()) == []


@pytest.mark.parametrize("entry", [*ENTRIES.values(), *POSES], ids=lambda entry: f"{entry.package}:{entry.key}")
def test_a_peer_has_its_class_and_its_packages_are_pinned(entry: Entry) -> None:
    """Read from its text, because most peers are not installed here."""
    text = PEERS[f"{entry.package}.{entry.module}"].read_text()
    assert re.search(rf"^class {entry.name}\b", text, re.MULTILINE)
    needed = {
        name for line in re.findall(r"^    packages = (.+)$", text, re.MULTILINE) for name in ast.literal_eval(line)
    }
    pinned = re.findall(r"^[\w.-]+(?===)", (ROOT / "requirements" / "peers.txt").read_text(), re.MULTILINE)
    assert needed
    assert sorted({name.lower() for name in needed} - {"stillreach", *pinned}) == []
