"""A batch answers each row with the bits that the law gives for it alone."""

import os
from functools import cache

import numpy as np
import pytest

import stillreach as sr
from oracles.kinematics import INCH
from tests.conformance.batches import INF, as_arrays, ask_alone, ask_batch, differences, mixed_rows
from tests.conformance.registry import LAWS
from tests.unit.arm.odd_arms import ODD_ARMS, placement

FULL = os.environ.get("STILLREACH_FULL") == "1"
MANY = 100_000
BATCH_ARMS = {
    "paper": sr.arms.nasa_modular,
    "planar": lambda: sr.arms.planar(4),
    "one joint": lambda: sr.arms.planar(1),
    "five joints": lambda: sr.arms.snake(5),
    "six joints": lambda: sr.arms.snake(6),
    "snake of 30": lambda: sr.arms.snake(30),
    "canadarm2": sr.arms.canadarm2,
    "skew": ODD_ARMS["skew"],
    "gantry": ODD_ARMS["slides and turns"],
    "mounted": ODD_ARMS["mounted"],
}
EVERY_LAW = pytest.mark.parametrize("law", LAWS)


def kinds(arm):
    return "".join("RP"[kind] for kind in arm.kinds)


def same(batch, alone, places=None):
    found = differences(batch, alone, places)
    assert not found, f"{len(found)} differ:\n" + "\n".join(found[:5])


@pytest.mark.parametrize("arm", BATCH_ARMS)
@EVERY_LAW
def test_every_arm(law, arm):
    law, arm = LAWS[law].make(), BATCH_ARMS[arm]()
    rows = mixed_rows(arm, 160 if arm.n < 20 else 60, seed=1)
    jacobians = arm.jacobian(rows.q)
    alone = ask_alone(law, jacobians, rows.twist, rows.bounds, joint_kinds=kinds(arm), length=arm.reach)
    same(ask_batch(arm, law, rows), alone | {"pose": arm.forward(rows.q), "jacobian": jacobians})


@cache
def hundred_thousand():
    """The rows, or a twentieth of them, and their Jacobians."""
    arm = sr.arms.nasa_modular()
    rows = mixed_rows(arm, MANY if FULL else MANY // 20, seed=2)
    return rows, arm.jacobian(rows.q)


@pytest.mark.timeout(1800)
@EVERY_LAW
def test_a_hundred_thousand_mixed_rows(law, capsys):
    contract, arm, (rows, jacobians) = LAWS[law], sr.arms.nasa_modular(), hundred_thousand()
    batch = ask_batch(arm, contract.make(), rows)
    same(batch, ask_alone(contract.make(), jacobians, rows.twist, rows.bounds, length=arm.reach))
    inside = np.all((batch.rates >= rows.lower) & (batch.rates <= rows.upper))
    assert inside or not contract.bounded
    with capsys.disabled():
        counts = {flag.name: np.count_nonzero(batch.status & int(flag)) for flag in sr.Status if flag}
        told = ", ".join(f"{name} {count}" for name, count in counts.items() if count)
        print(f"\n  {law}: {len(rows)} of {MANY} rows compared, all the same; {told}")


@pytest.mark.parametrize("count", [0, 1, 3, 4, 5, 255, 256, 257, 1000])
@pytest.mark.parametrize("law", ["pseudoinverse", "exact damping", "least error", "keep direction"])
def test_any_number_of_rows(law, count):
    arm, law = sr.arms.nasa_modular(), LAWS[law].make()
    rows = mixed_rows(arm, count, seed=4)
    batch = ask_batch(arm, law, rows, threads=2)
    assert len(batch) == count
    assert batch.rates.shape == (count, 11)
    some = np.arange(count)[-200:]  # the last block, and what is left of it
    same(batch, ask_alone(law, arm.jacobian(rows.q[some]), rows.twist[some], rows[some].bounds, length=arm.reach), some)


@EVERY_LAW
def test_a_row_does_not_see_its_neighbours(law):
    arm, law = sr.arms.nasa_modular(), LAWS[law].make()
    rows = mixed_rows(arm, 240, seed=5)
    order = np.random.default_rng(6).permutation(len(rows))
    one, other = ask_batch(arm, law, rows), ask_batch(arm, law, rows[order])
    same(other, {name: getattr(one, name)[order] for name in ("rates", "status", "task_error", "damping")})


SHARED = {
    "healthy": sr.Bounds.symmetric(0.5, n=11),
    "2, 4, 7 failed": sr.Bounds.symmetric(0.5, n=11).lock([1, 3, 6]),
    "five work": sr.Bounds.symmetric(0.5, n=11).lock(range(6)),
    "six work": sr.Bounds.symmetric(0.5, n=11).lock(range(5)),
    "none works": sr.Bounds.symmetric(0.5, n=11).lock(range(11)),
    "runaway": sr.Bounds.symmetric(0.5, n=11).fix(4, 0.3),
    "one-sided": sr.Bounds(np.zeros(11), np.linspace(0.1, 1.0, 11)),
    "asymmetric": sr.Bounds(-np.linspace(0.1, 1.0, 11), np.linspace(1.0, 0.2, 11)),
    "unbounded": sr.Bounds.unbounded(11),
    "some infinite": sr.Bounds(np.where(np.arange(11) % 3, -0.5, -np.inf), np.where(np.arange(11) % 2, 0.5, np.inf)),
    "zero and a window": sr.Bounds([0.0] * 3 + [-0.1] * 4 + [0.2] * 4, [0.0] * 3 + [0.4] * 4 + [0.6] * 4),
}


@pytest.mark.parametrize("bounds", SHARED)
@EVERY_LAW
def test_bounds_that_all_rows_share(law, bounds):
    arm, law, bounds = sr.arms.nasa_modular(), LAWS[law].make(), SHARED[bounds]
    rows = mixed_rows(arm, 60, seed=7)
    batch = ask_batch(arm, law, rows, bounds=bounds)
    same(batch, ask_alone(law, arm.jacobian(rows.q), rows.twist, bounds, length=arm.reach))
    apart = ask_batch(arm, law, rows, bounds=(np.tile(bounds.lower, (60, 1)), np.tile(bounds.upper, (60, 1))))
    same(apart, {name: getattr(batch, name) for name in ("rates", "status", "task_error", "damping", "residual")})


@EVERY_LAW
def test_law_solve_says_the_same(law):
    """The public call, for what the other tests ask the core."""
    arm, law = sr.arms.nasa_modular(), LAWS[law].make()
    rows = mixed_rows(arm, 20, seed=8)
    answers = [
        law.solve(arm.jacobian(rows.q[i]), rows.twist[i], sr.Bounds(rows.lower[i], rows.upper[i]), length=arm.reach)
        for i in range(20)
    ]
    same(ask_batch(arm, law, rows), as_arrays(answers, 6, 11))


def full(size, seed):
    a = np.random.default_rng(seed).normal(size=(size, size))
    return a @ a.T + 0.3 * np.eye(size)


POINT = placement((0.1, -0.2, 0.3), (1, 2, 3), 0.7)
WEIGHTS = {
    "units": {"length": INCH, "angle": np.deg2rad(1)},
    "W1 vector": {"task": [1.0, 2.0, 3.0, 0.1, 0.2, 0.5]},
    "W1 matrix": {"task": full(6, 1)},
    "W2 vector": {"joints": np.linspace(0.2, 3.0, 11)},
    "W2 matrix": {"joints": full(11, 2)},
    "all": {"length": 0.3, "angle": 2.0, "task": full(6, 3), "joints": full(11, 4)},
}
TASKS = {
    "pose": "pose",
    "position": "position",
    "orientation": "orientation",
    "five rows": (True, True, True, True, True, False),
    "three mixed rows": (True, False, False, True, False, True),
    "one row": (False, False, True, False, False, False),
}


PARTED = ("least error, two prices", "least error, position first")
"""With a price of its own for v rows and for w rows."""


@pytest.mark.parametrize("task", TASKS)
@EVERY_LAW
def test_tasks_and_weights(law, task):
    arm = sr.arms.nasa_modular()
    rows = mixed_rows(arm, 20, seed=9)
    for name, given in WEIGHTS.items():
        asked = sr.Task(rows=TASKS[task], tool=POINT, weights=sr.Weights(**given))
        kept = list(asked.indices)
        if "task" in given:
            W1 = np.asarray(given["task"])
            given = given | {"task": W1[kept] if W1.ndim == 1 else W1[np.ix_(kept, kept)]}
        jacobians = arm.with_tool(arm.tool @ POINT).jacobian(rows.q)[:, kept]
        own = LAWS[law].make(weights=sr.Weights(**given))
        row_kinds = "".join("vvvwww"[row] for row in kept)
        if law in PARTED and np.ndim(given.get("task", 0)) == 2 and {"v", "w"} <= set(row_kinds):
            with pytest.raises(sr.InputError, match="rows that have different prices"):
                ask_batch(arm, LAWS[law].make(), rows, task=asked)
            continue
        alone = ask_alone(own, jacobians, rows.twist[:, kept], rows.bounds, row_kinds=row_kinds, length=arm.reach)
        found = differences(ask_batch(arm, LAWS[law].make(), rows, task=asked), alone | {"jacobian": jacobians})
        assert not found, f"{name}: {found[:3]}"


@pytest.mark.parametrize("shared", [True, False])
@EVERY_LAW
def test_reference_rates(law, shared):
    arm, law, rng = sr.arms.nasa_modular(), LAWS[law].make(), np.random.default_rng(10)
    rows = mixed_rows(arm, 80, seed=11)
    reference = rng.normal(size=11 if shared else (80, 11)) * 0.3
    if not shared:
        reference[::7] = 0.0
    alone = ask_alone(law, arm.jacobian(rows.q), rows.twist, rows.bounds, reference=reference, length=arm.reach)
    same(ask_batch(arm, law, rows, reference=reference), alone)


@pytest.mark.parametrize("m", [1, 2, 3, 4, 5, 6])
@EVERY_LAW
def test_jacobians_from_elsewhere(law, m):
    rng, law = np.random.default_rng(m), LAWS[law].make(weights=sr.Weights(length=0.5, angle=0.2))
    for n in (1, 5, 9):
        jacobians = rng.normal(size=(30, m, n))
        jacobians[::5] = np.round(jacobians[::5])
        jacobians[1::5, :, n // 2] = 0.0
        jacobians[2::5] *= 10.0 ** rng.uniform(-80, 80, (6, 1, 1))
        rows = mixed_rows(sr.arms.snake(n), 30, seed=12)
        twist, names = (
            np.ascontiguousarray(rows.twist[:, :m]),
            {"row_kinds": "vwvwvw"[:m], "joint_kinds": "RPR" * 3, "length": 0.8},
        )
        names["joint_kinds"] = names["joint_kinds"][:n]
        alone = ask_alone(law, jacobians, twist, rows.bounds, **names)
        rows.q, rows.twist = None, twist
        same(ask_batch(None, law, rows, jacobians=jacobians, **names), alone | {"jacobian": jacobians})


def ticks(arm, law, rows, last, *, task=None, period=0.01):
    """What a fresh controller answers to each row, cold."""
    answers = []
    for i in range(len(rows)):
        limits = np.stack([rows.lower[i], rows.upper[i]], axis=1)
        stuck = rows.lower[i] == rows.upper[i]
        limits[stuck] = (-1.0, 1.0)
        controller = sr.Controller(arm, law=law, task=task, period=period, velocity_limits=limits)
        for joint in np.flatnonzero(stuck):
            rate = rows.lower[i, joint]
            controller.fail(int(joint), sr.Runaway(rate) if rate else sr.Locked())
        controller.reset(last[i])
        answers.append(controller.step(rows.q[i], rows.twist[i]))
    return answers


def around_zero(rows):
    """Rows with bounds that a controller's rate limits can be."""
    stuck = rows.lower == rows.upper
    rows.lower, rows.upper = (
        np.where(stuck, rows.lower, np.minimum(rows.lower, 0.0)),
        np.where(stuck, rows.upper, np.maximum(rows.upper, 0.0)),
    )
    return rows


LIMITED = {
    "position": {"position": (-2.0, 2.0)},
    "acceleration": {"acceleration": 3.0},
    "both": {"position": (-2.5, 1.5), "acceleration": [0.0, 1e-3, 5.0, 5.0, np.inf, 50.0, 1.0, 10.0, 2.0, 0.5, 1e6]},
}


@pytest.mark.parametrize("limits", LIMITED)
@EVERY_LAW
def test_limits_of_position_and_acceleration_as_a_controller_keeps_them(law, limits):
    arm, law = sr.arms.nasa_modular().with_limits(**LIMITED[limits]), LAWS[law].make()
    rows = around_zero(mixed_rows(arm, 60, seed=13))
    last = np.random.default_rng(14).normal(size=(60, 11)) * 0.3
    alone = as_arrays(ticks(arm, law, rows, last), 6, 11)
    same(ask_batch(arm, law, rows, last_rates=last, period=0.01), alone)


@pytest.mark.parametrize("rows", TASKS)
@EVERY_LAW
def test_tasks_along_the_tool(law, rows):
    arm, law = sr.arms.canadarm2().with_limits(position=(-INF, INF)), LAWS[law].make()
    task = sr.Task(rows=TASKS[rows], frame="tool", tool=placement((0.1, 0.0, 0.3), (1, 0, 1), 1.0))
    asked = around_zero(mixed_rows(arm, 30, seed=15))
    last = np.zeros((30, arm.n))
    alone = as_arrays(ticks(arm, law, asked, last, task=task), task.m, arm.n)
    same(ask_batch(arm, law, asked, task=task), alone)
