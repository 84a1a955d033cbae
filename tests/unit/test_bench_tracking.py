"""The tables of how well the default law tracks: what they are made of, and a small one of each kind."""

import re

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation

import stillreach as sr
from bench.tracking import limits, loops, poses
from bench.tracking.__main__ import main
from bench.tracking.loop import QP_DAMPING, Path, Record, by_box_qp, circle, error, follow
from bench.tracking.setting import RATE, Claim, machine, panda, table, twists

PAPER = machine("the paper's", sr.arms.nasa_modular(), RATE)
CANADARM = machine("Canadarm2", sr.arms.canadarm2())


def cells(text):
    """Rows of a markdown table, without its head."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    assert len({len(row) for row in rows}) == 1
    return rows[2:]


def a_path():
    random = np.random.default_rng(1)
    start = np.eye(4)
    start[:3, :3], start[:3, 3] = Rotation.random(rng=random).as_matrix(), random.normal(size=3)
    return Path(start, *random.uniform(0.05, 0.4, (2, 3)), *random.uniform(0.5, 2.0, (2, 6)))


def test_a_path_begins_where_the_tool_is_and_its_twist_is_its_derivative():
    path, h = a_path(), 1e-6
    np.testing.assert_allclose(path.goal(0.0), path.start, atol=1e-15)
    for t in (0.0, 0.7, 3.0):
        between = error(path.goal(t + h), path.goal(t - h)) / (2.0 * h)
        np.testing.assert_allclose(path.twist(t), between, atol=1e-8)


def test_the_circle_is_a_circle():
    path = circle(np.eye(4), 0.1, 8.0)
    points = np.array([path.goal(t)[:3, 3] for t in np.linspace(0.0, 8.0, 9)])
    np.testing.assert_allclose(np.linalg.norm(points - [-0.1, 0.0, 0.0], axis=1), 0.1, atol=1e-15)
    np.testing.assert_allclose(points[4], [-0.2, 0.0, 0.0], atol=1e-15)


def test_sign_changes_count_joints_that_turn_round_within_a_tick_at_speed():
    rates = np.array([[0.6, 0.1], [-0.7, -0.9], [-0.8, 0.6], [0.4, 0.7]])
    record = Record(rates, np.zeros((4, 3)), np.zeros(4), np.zeros(4))
    assert record.sign_changes(np.full(2, 0.5)) == 2
    assert record.sign_changes(np.array([0.3, 1.0])) == 2
    assert record.sign_changes(np.zeros(2)) == 4
    assert record.variation == pytest.approx(0.6 + 1.3 + 0.1 + 1.2 + 0.1 + 1.0 + 1.5 + 0.1)


def test_the_box_qp_is_damped_least_squares_in_the_bounds():
    arm, random = sr.arms.nasa_modular(), np.random.default_rng(3)
    ctl = sr.Controller(arm, velocity_limits=0.4)
    ctl.fail("j3", sr.Runaway(0.2))
    ctl.fail("j5")
    free = np.setdiff1d(np.arange(11), [2, 4])
    for q, twist in zip(random.uniform(-1.5, 1.5, (20, 11)), random.normal(size=(20, 6)), strict=True):
        rates, J = by_box_qp(ctl, q, twist), arm.jacobian(q)
        stack = np.vstack((J[:, free], np.sqrt(QP_DAMPING) * np.eye(9)))
        rest = np.append(twist - 0.2 * J[:, 2], np.zeros(9))
        expected = lsq_linear(stack, rest, (-0.4, 0.4), method="bvls", tol=1e-15).x
        np.testing.assert_allclose(rates[free], expected, atol=1e-6)
        assert (rates[2], rates[4]) == (0.2, 0.0)


def test_a_loop_follows_its_path():
    ctl = sr.Controller(PAPER.arm, period=0.01, velocity_limits=RATE)
    q = np.linspace(-0.8, 0.9, 11)
    record = follow(ctl, q, circle(PAPER.arm.forward(q)), 100, 0.01)
    assert np.max(record.off) < 1e-3
    assert np.max(record.turned) < 1e-3
    ends = PAPER.arm.forward(q + 0.01 * np.sum(record.rates, axis=0))
    np.testing.assert_allclose(record.tool[-1], ends[:3, 3], atol=1e-12)


def test_faults_come_and_are_all_restored():
    for seed in range(5):
        events = loops.faults(np.random.default_rng(seed), 7)
        last = max(events)
        assert last == 1400
        ctl = sr.Controller(panda().arm)
        for tick in sorted(events):
            for event in events[tick]:
                event(ctl)
            assert bool(ctl.faults) == (tick < last)


def test_random_twists_have_the_speed():
    np.testing.assert_allclose(np.linalg.norm(twists(50, 0.1, 1)[:, :3], axis=1), 0.1)


def test_small_tables():
    for rows, claims in (
        (poses.readme_ticks(64), 1),
        (poses.random_poses([CANADARM], 20), 0),
        (poses.giving_way([PAPER, CANADARM], 20), 0),
        (limits.generous([PAPER], 20), 1),
        (limits.one_joint([CANADARM]), 1),
    ):
        assert len(cells(rows[0])) >= 1
        assert len(rows[1]) == claims
        assert all(claim.holds for claim in rows[1]), rows[1]


def test_the_share_that_misses_is_counted():
    """Far from singular poses nothing is missed at the speeds that the arm is made for, and all is at absurd ones."""
    calm = poses.missing(PAPER, 20, 1e-6, None, far=False)
    assert np.max(calm) < 1e-9
    wild = poses.missing(PAPER, 20, 1e3, None, far=False)
    assert np.min(wild) > 0.9


def test_the_command_prints_parts_and_says_what_is_not_met(capsys):
    assert main(["--quick", "--only", "paper,one-joint"]) == 0
    said = capsys.readouterr().out
    assert [line for line in said.splitlines() if line.startswith("## ")] == [
        "## One working joint",
        "## The paper's example 2 in closed loop",
    ]
    assert re.search(r"8 of 8 requirements are met$", said.strip())
    with pytest.raises(SystemExit):
        main(["--only", "nonsense"])
    assert "nonsense" in capsys.readouterr().err


def test_a_claim_that_does_not_hold_stands_out():
    assert str(Claim("less than 1", holds=False)) == "- NOT MET: less than 1"
    assert table(("a", "b"), [(1, 2.5)]) == "| a | b |\n| --- | --- |\n| 1 | 2.5 |"
