"""rollout_batch against a loop of solve_batch in NumPy, controllers and simulations."""

import os
import signal
import threading

import numpy as np
import pytest

import stillreach as sr
from stillreach import Status

ARM = sr.arms.nasa_modular()
LIMITED = ARM.with_limits(position=(-1.2, 1.2), acceleration=3.0)
LAWS = (sr.Pseudoinverse(), sr.SingularityRobust(damping="exact"), sr.LeastError(), sr.KeepDirection())
BARE = sr.LeastError(price=None)
PERIOD, STEPS = 0.02, 12
RECORDS = ("q", "rates", "task_error", "status")
EVERYTHING = (*RECORDS, "final_q", "final_rates", "worst_error", "any_status")


def places(count, seed=0):
    """Configurations, twists, and bounds with another fault in each row: locked, derated, running away."""
    rng = np.random.default_rng(seed)
    upper = np.full((count, 11), np.deg2rad(50))
    lower, row, joint = -upper, np.arange(count), rng.integers(0, 11, count)
    lower[row, joint] = upper[row, joint] = np.where(row % 3 == 2, 0.1, 0.0)
    upper[row, (joint + 4) % 11] *= 0.2
    return rng.uniform(-1, 1, (count, 11)), rng.normal(size=(count, 6)) * 0.1, (lower, upper)


def roll(start, twist, bounds, *, arm=ARM, law=BARE, steps=STEPS, period=PERIOD, **kwargs):
    return sr.rollout_batch(arm, law, start, twist, bounds, period=period, steps=steps, **kwargs)


def same(one, other, names=EVERYTHING):
    for name in names:
        assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True), name


def step(arm, law, q, twist, bounds, last, integrator="euler", period=PERIOD, task=None):
    """The answers at q, and where the joints are a period later."""
    limits = {} if arm is ARM else {"last_rates": last, "period": period}

    def ask(at, want=()):
        return sr.solve_batch(arm, law, at, twist, bounds, task=task, want=want, **limits)

    first = ask(q, "task_error")
    if integrator == "euler":
        return first, q + period * first.rates
    k1 = first.rates
    k2 = ask(q + period / 2 * k1).rates
    k3 = ask(q + period / 2 * k2).rates
    k4 = ask(q + period * k3).rates
    return first, q + period / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def check_steps(run, twists, bounds, arm=ARM, law=BARE, integrator="euler", last=None, task=None):
    """Each recorded step is what the loop makes of the one before; twists: (N or 1, T or 1, 6)."""
    twists = np.broadcast_to(twists, (len(run), run.q.shape[1], 6))
    last = np.zeros_like(run.final_q) if last is None else last
    worst, any_status = np.zeros(len(run)), np.zeros(len(run), np.int32)
    for k in range(run.q.shape[1]):
        twist = np.ascontiguousarray(twists[:, k])
        expected, after = step(arm, law, run.q[:, k], twist, bounds, last, integrator, task=task)
        last = expected.rates
        assert np.array_equal(run.rates[:, k], expected.rates), k
        assert np.array_equal(run.status[:, k], expected.status), k
        assert np.array_equal(run.task_error[:, k], expected.task_error), k
        there = run.q[:, k + 1] if k + 1 < run.q.shape[1] else run.final_q
        assert np.allclose(there, after, rtol=0, atol=1e-15 if integrator == "euler" else 1e-11), k
        worst, any_status = np.maximum(worst, expected.task_error), any_status | expected.status
    assert np.array_equal(run.final_rates, last)
    assert np.array_equal(run.worst_error, worst)
    assert np.array_equal(run.any_status, any_status)


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("arm", [ARM, LIMITED], ids=["free", "limited"])
def test_each_step_is_a_solve_batch_and_a_move(arm, law, integrator):
    q, twist, bounds = places(24)
    run = roll(q, twist, bounds, arm=arm, law=law, integrator=integrator, record=RECORDS)
    assert np.array_equal(run.q[:, 0], q)
    check_steps(run, twist[:, None], bounds, arm, law, integrator)


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
@pytest.mark.parametrize("arm", [ARM, LIMITED], ids=["free", "limited"])
def test_a_loop_in_numpy_ends_where_it_does(arm, integrator):
    q, twist, bounds = places(40, seed=1)
    run = roll(q, twist, bounds, arm=arm, steps=40, integrator=integrator)
    last = np.zeros_like(q)
    for _ in range(40):
        answer, q = step(arm, BARE, q, twist, bounds, last, integrator)
        last = answer.rates
    assert np.allclose(run.final_q, q, rtol=0, atol=1e-10)
    assert np.allclose(run.final_rates, last, rtol=0, atol=1e-8)


@pytest.mark.parametrize("shape", [(6,), (7, 6), (1, STEPS, 6), (7, STEPS, 6), (1, 6), (1, 1, 6), (7, 1, 6)])
@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_every_shape_of_twist(shape, integrator):
    rows = shape[0] if len(shape) == 2 else 7
    steps = shape[1] if len(shape) == 3 else STEPS
    q, _, bounds = places(rows)
    twist = np.random.default_rng(2).normal(size=shape) * 0.1
    run = roll(q, twist, bounds, steps=steps, integrator=integrator, record=RECORDS)
    check_steps(run, twist[:, None] if len(shape) == 2 else twist, bounds, integrator=integrator)


@pytest.mark.parametrize("count", [1, 6, STEPS])
def test_as_many_rows_as_steps_or_entries_of_a_twist(count):
    """Shapes that could be taken for each other are not: rows come first."""
    q, twist, bounds = places(count)
    run = roll(q, twist, bounds, steps=count, record=RECORDS)
    check_steps(run, twist[:, None], bounds)
    by_step = roll(q, twist[None], bounds, steps=count, record=RECORDS)
    check_steps(by_step, twist[None], bounds)


@pytest.mark.parametrize("arm", [ARM, LIMITED], ids=["free", "limited"])
@pytest.mark.parametrize("every", [1, 2, 5, STEPS - 1, STEPS, STEPS + 1, 10**9])
def test_every_so_many_steps(every, arm):
    q, twist, bounds = places(5)
    whole = roll(q, twist, bounds, arm=arm, record=RECORDS)
    run = roll(q, twist, bounds, arm=arm, record=RECORDS, every=every)
    same(run, whole, EVERYTHING[4:])
    for name in RECORDS:
        assert np.array_equal(getattr(run, name), getattr(whole, name)[:, ::every]), name


@pytest.mark.parametrize("record", [(), "q", ("rates",), ["status", "q"], ("task_error", "status"), RECORDS])
def test_what_is_not_recorded_is_none(record):
    q, twist, bounds = places(5)
    whole, run = (roll(q, twist, bounds, record=names) for names in (RECORDS, record))
    asked = (record,) if isinstance(record, str) else record
    same(run, whole, (*asked, *EVERYTHING[4:]))
    assert [name for name in RECORDS if getattr(run, name) is not None] == [name for name in RECORDS if name in asked]
    assert run.any_status.dtype == np.int32
    assert len(run) == 5


def test_last_rates_count_where_acceleration_is_limited():
    q, twist, bounds = places(30)
    last = np.clip(np.random.default_rng(3).normal(size=q.shape) * 0.3, *bounds)
    run = roll(q, twist, bounds, arm=LIMITED, last_rates=last, record=RECORDS)
    check_steps(run, twist[:, None], bounds, LIMITED, last=last)
    held = ~np.any(run.status & Status.LIMIT_GIVEN_UP, axis=1)
    rates = np.concatenate([last[:, None], run.rates], axis=1)[held]
    working = (bounds[0] < bounds[1])[held]
    assert np.count_nonzero(held) > 10
    assert np.abs(np.diff(rates, axis=1)).max(axis=1)[working].max() <= 3.0 * PERIOD * (1 + 1e-8)
    at_rest = roll(q, twist, bounds, arm=LIMITED, record=RECORDS)
    assert not np.array_equal(at_rest.rates[:, 0], run.rates[:, 0])
    same(roll(q, twist, bounds, last_rates=last, record=RECORDS), roll(q, twist, bounds, record=RECORDS))


@pytest.mark.parametrize("law", LAWS[2:], ids=lambda law: type(law).__name__)
def test_failed_joints_and_position_limits_hold_all_the_way(law):
    q, twist, (lower, upper) = places(60)
    run = roll(q, twist * 5, (lower, upper), arm=LIMITED, law=law, steps=150, record=("q", "rates"))
    locked = (lower == upper) & (upper == 0.0)
    assert np.count_nonzero(locked) > 20
    assert np.array_equal(run.q.transpose(0, 2, 1)[locked], np.repeat(q[locked][:, None], 150, axis=1))
    runaway = (lower == upper) & (upper != 0.0)
    assert np.all(run.rates.transpose(0, 2, 1)[runaway] == 0.1)
    assert np.all((run.rates >= lower[:, None]) & (run.rates <= upper[:, None]))
    free = np.abs(run.q.transpose(0, 2, 1)[lower < upper])
    assert 1.19 < free.max() <= 1.2 + 1e-12


TASKS = [
    (sr.LeastError(), sr.Task(rows="position")),
    (sr.KeepDirection(), sr.Task(rows="orientation")),
    (sr.LeastError(), sr.Task(rows="position", frame="tool")),
    (sr.LeastError(), sr.Task(rows=(True, False, True, False, False, True))),
    (sr.LeastError(weights=sr.Weights(length=0.1, joints=np.linspace(1, 3, 11))), None),
    (sr.SingularityRobust(), sr.Task(weights=sr.Weights(task=[1, 2, 3, 4, 5, 6]))),
    (sr.LeastError(weights=sr.Weights(joints=np.eye(11) + 0.2 * np.ones((11, 11)))), None),
]


@pytest.mark.parametrize("arm", [ARM, LIMITED], ids=["free", "limited"])
@pytest.mark.parametrize(("law", "task"), TASKS)
def test_tasks_and_weights(law, task, arm):
    q, twist, bounds = places(9)
    run = roll(q, twist, bounds, arm=arm, law=law, task=task, record=RECORDS)
    check_steps(run, twist[:, None], bounds, arm, law, task=task)


def test_the_point_of_a_task_goes_where_it_is_told():
    """In small steps the tool's tip moves along the twist, by Arm.forward."""
    tip = np.eye(4)
    tip[:3, 3] = 0.05, -0.1, 0.2
    q, twist, _ = places(10, seed=4)
    twist *= 0.2
    run = roll(
        q,
        twist,
        sr.Bounds.unbounded(11),
        task=sr.Task(rows="position", tool=tip),
        period=1e-3,
        steps=200,
        integrator="rk4",
    )
    moved = (ARM.forward(run.final_q) @ tip - ARM.forward(q) @ tip)[:, :3, 3]
    assert np.allclose(moved, 0.2 * twist[:, :3], rtol=0, atol=1e-6)


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
@pytest.mark.parametrize("arm", [ARM, LIMITED], ids=["free", "limited"])
def test_going_on_is_one_long_rollout(arm, integrator):
    q, _, bounds = places(20)
    twist = np.random.default_rng(5).normal(size=(20, 30, 6)) * 0.1
    given = {"arm": arm, "integrator": integrator, "record": RECORDS, "law": sr.LeastError()}
    whole = roll(q, twist, bounds, steps=30, **given)
    first = roll(q, twist[:, :13], bounds, steps=13, **given)
    rest = roll(first.final_q, twist[:, 13:], bounds, steps=17, last_rates=first.final_rates, **given)
    same(rest, whole, ("final_q", "final_rates"))
    for name in RECORDS:
        both = np.concatenate([getattr(first, name), getattr(rest, name)], axis=1)
        assert np.array_equal(both, getattr(whole, name)), name
    assert np.array_equal(np.maximum(first.worst_error, rest.worst_error), whole.worst_error)
    assert np.array_equal(first.any_status | rest.any_status, whole.any_status)


@pytest.mark.parametrize("count", [0, 1, 63, 64, 65, 200])
def test_a_row_does_not_depend_on_how_many_there_are(count):
    q, twist, (lower, upper) = places(200)
    given = {"arm": LIMITED, "law": sr.LeastError(), "record": RECORDS, "steps": 5}
    whole = roll(q, twist, (lower, upper), **given)
    some = slice(200 - count, 200)
    run = roll(q[some], twist[some], (lower[some], upper[some]), **given)
    assert len(run) == count
    for name in EVERYTHING:
        assert np.array_equal(getattr(run, name), getattr(whole, name)[some]), name


@pytest.mark.parametrize("threads", [2, 5, None])
def test_threads_change_no_bit(threads):
    q, twist, bounds = places(140)
    for arm, integrator in ((ARM, "euler"), (LIMITED, "rk4")):
        given = {"arm": arm, "integrator": integrator, "record": RECORDS, "law": sr.KeepDirection(), "steps": 3}
        same(roll(q, twist, bounds, threads=1, **given), roll(q, twist, bounds, threads=threads, **given))


def test_inputs_stay_what_they_were():
    given = places(70)
    last = given[0] * 0.1
    copies = [array.copy() for array in (given[0], given[1], *given[2], last)]
    roll(*given, arm=LIMITED, last_rates=last, integrator="rk4")
    for array, copy in zip((given[0], given[1], *given[2], last), copies, strict=True):
        assert np.array_equal(array, copy)


SPOILED = {
    "a NaN in start": lambda q, twist, lower, upper: q.__setitem__((5, 3), np.nan),
    "an infinite twist": lambda q, twist, lower, upper: twist.__setitem__((5, 2), np.inf),
    "a NaN in the bounds": lambda q, twist, lower, upper: lower.__setitem__((5, 1), np.nan),
    "bounds that contradict": lambda q, twist, lower, upper: lower.__setitem__((5, 1), 2.0),
    "no rate left": lambda q, twist, lower, upper: upper.__setitem__((5, 1), -np.inf),
}


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
@pytest.mark.parametrize("what", SPOILED)
def test_invalid_rows_do_not_affect_the_others(what, integrator):
    q, twist, (lower, upper) = places(12)
    lower[5], upper[5] = -0.5, 0.5
    lower[5, 7] = upper[5, 7] = 0.25
    given = {"integrator": integrator, "record": RECORDS, "law": sr.LeastError()}
    good = roll(q, twist, (lower, upper), **given)
    SPOILED[what](q, twist, lower, upper)
    run = roll(q, twist, (lower, upper), **given)
    others = np.arange(12) != 5
    for name in EVERYTHING:
        assert np.array_equal(getattr(run, name)[others], getattr(good, name)[others]), name
    assert np.all(run.status[5] == Status.INVALID_INPUT)
    assert run.any_status[5] == Status.INVALID_INPUT
    expected = np.where(np.arange(11) == 7, 0.25, 0.0)
    assert np.array_equal(run.rates[5], np.tile(expected, (STEPS, 1)))
    assert np.allclose(run.final_q[5], q[5] + expected * PERIOD * STEPS, rtol=0, atol=1e-15, equal_nan=True)


@pytest.mark.parametrize("threads", [1, 3])
def test_ctrl_c_ends_a_long_rollout(threads):
    q, twist, bounds = places(130)
    timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        roll(q, twist, bounds, steps=10**9, threads=threads)
    timer.join()
    same(roll(q, twist, bounds, threads=threads), roll(q, twist, bounds, threads=1), EVERYTHING[4:])
