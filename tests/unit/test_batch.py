"""solve_batch at its door: what it takes in place, what it refuses, what it does with rows that are no question."""

import resource
import tracemalloc

import numpy as np
import pytest

import stillreach as sr
from oracles.kinematics import paper_arm
from stillreach import Status
from stillreach.errors import InputError
from tests.refusals import refused

ARM = sr.arms.nasa_modular()
LAW = sr.LeastError()
LAWS = (sr.Pseudoinverse(), sr.SingularityRobust(damping="exact"), sr.LeastError(), sr.KeepDirection())
N = 12


def questions(count=N, seed=0):
    """Ordinary rows, with bounds that bite."""
    rng = np.random.default_rng(seed)
    upper = np.full((count, 11), 0.5)
    upper[np.arange(count), rng.integers(0, 11, count)] = 0.0
    return rng.uniform(-2, 2, (count, 11)), rng.normal(size=(count, 6)) * 0.3, (-upper, upper)


def same(one, other):
    assert np.array_equal(one.rates.view(np.int64), other.rates.view(np.int64))
    assert np.array_equal(one.status, other.status)


def test_the_pseudoinverse_is_numpys():
    q, twist, _ = questions(200)
    batch = sr.solve_batch(ARM, sr.Pseudoinverse(), q, twist, sr.Bounds.unbounded(11), want=("residual", "task_error"))
    for i in range(200):
        J = paper_arm(q[i])[2]
        assert np.allclose(batch.rates[i], np.linalg.pinv(J) @ twist[i], rtol=1e-9, atol=1e-12)
        assert np.allclose(batch.residual[i], 0.0, atol=1e-12)
    assert np.array_equal(batch.task_error, np.linalg.norm(batch.residual, axis=1)) or np.all(batch.task_error < 1e-12)


def test_failed_joints_stand_still_and_rates_are_inside():
    q, twist, (lower, upper) = questions(500)
    for law in LAWS[1:]:
        batch = sr.solve_batch(ARM, law, q, twist, (lower, upper), want="residual")
        assert np.all(batch.rates[lower == upper] == 0.0)
        assert np.all((batch.rates >= lower) & (batch.rates <= upper))
        moved = np.einsum("nij,nj->ni", ARM.jacobian(q), batch.rates)
        assert np.allclose(twist - moved, batch.residual, atol=1e-13)


def test_what_is_not_wanted_is_none():
    q, twist, bounds = questions()
    bare = sr.solve_batch(ARM, LAW, q, twist, bounds)
    for name in ("residual", "damping", "scale", "task_error", "pose", "jacobian", "active", "iterations"):
        assert getattr(bare, name) is None
        one = sr.solve_batch(ARM, LAW, q, twist, bounds, want=name)
        assert getattr(one, name) is not None
        same(bare, one)
    assert bare.status.dtype == np.int32
    assert Status(bare.status[0]) is not None


def test_poses_and_jacobians_are_the_arms():
    q, twist, bounds = questions()
    batch = sr.solve_batch(ARM, LAW, q, twist, bounds, want=("pose", "jacobian"))
    for i in range(N):
        assert np.allclose(batch.jacobian[i], paper_arm(q[i])[2], atol=1e-13)
    assert np.array_equal(batch.pose, ARM.forward(q))


FORMS = {
    "lists": lambda a: a.tolist(),
    "float32": lambda a: a.astype(np.float32),
    "Fortran order": np.asfortranarray,
    "every other row": lambda a: np.repeat(a, 2, axis=0)[::2],
    "columns of a wider array": lambda a: np.hstack([a, a])[:, : a.shape[1]],
    "backwards": lambda a: a[::-1].copy()[::-1],
    "big-endian": lambda a: a.astype(">f8"),
    "read-only": lambda a: (lambda b: (b.setflags(write=False), b)[1])(a.copy()),
    "unaligned": lambda a: np.frombuffer(b"x" + a.tobytes(), offset=1).reshape(a.shape),
}


@pytest.mark.parametrize("form", FORMS)
def test_any_form_of_the_numbers_gives_the_same(form):
    change = FORMS[form]
    q, twist, (lower, upper) = (
        np.asarray(a, np.float32).astype(float) if not isinstance(a, tuple) else a for a in questions()
    )
    expected = sr.solve_batch(
        ARM, LAW, q, twist, (lower, upper), reference=q, last_rates=twist[:, :1] * np.ones(11), period=0.1
    )
    got = sr.solve_batch(
        ARM,
        LAW,
        change(q),
        change(twist),
        (change(lower), change(upper)),
        reference=change(q),
        last_rates=change(twist[:, :1] * np.ones(11)),
        period=0.1,
    )
    same(expected, got)
    jacobians = ARM.jacobian(q).reshape(N, 66)
    jacobians = jacobians.astype(np.float32).astype(float)
    expected = sr.solve_batch(None, LAW, None, twist, (lower, upper), jacobians=jacobians.reshape(N, 6, 11))
    changed = np.reshape(change(jacobians), (N, 6, 11)) if form == "lists" else change(jacobians).reshape(N, 6, 11)
    same(expected, sr.solve_batch(None, LAW, None, change(twist), (lower, upper), jacobians=changed))


def test_inputs_stay_what_they_were_and_where_they_are():
    q, twist, (lower, upper) = given = questions(20_000)
    before = [q.copy(), twist.copy(), lower.copy(), upper.copy()]
    out = np.empty_like(q)
    sr.solve_batch(ARM, LAW, q[:1], twist[:1], (lower[:1], upper[:1]))
    tracemalloc.start()
    batch = sr.solve_batch(ARM, LAW, q, twist, given[2], out=out)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert batch.rates is out
    assert peak < batch.status.nbytes + 20_000  # NumPy tells tracemalloc of every array
    for array, old in zip((q, twist, lower, upper), before, strict=True):
        assert np.array_equal(array, old)


def test_memory_does_not_grow_with_the_rows():
    q, twist, (lower, upper) = questions(1000)
    law = sr.LeastError()
    many = [np.tile(a, (100, 1)) for a in (q, twist, lower, upper)]
    out = np.zeros_like(many[0])
    sr.solve_batch(ARM, law, q, twist, (lower, upper), threads=2)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    sr.solve_batch(ARM, law, many[0], many[1], (many[2], many[3]), out=out, threads=2)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 4096  # KiB; one copy of q alone is 8,600


def spoil_q(q, twist, lower, upper, value):
    q[5, 3] = value


def spoil_twist(q, twist, lower, upper, value):
    twist[5, 2] = value


def spoil_bounds(q, twist, lower, upper, value):
    lower[5, 1] = value


def contradict(q, twist, lower, upper, value):
    lower[5, 0], upper[5, 0] = 0.2, 0.1


def no_room(q, twist, lower, upper, value):
    lower[5, 0] = upper[5, 0] = np.inf


SPOILED = [(spoil, value) for spoil in (spoil_q, spoil_twist) for value in (np.nan, np.inf, -np.inf)]
SPOILED += [(spoil_bounds, np.nan), (spoil_bounds, np.inf), (contradict, None), (no_room, None)]


@pytest.mark.parametrize(("spoil", "value"), SPOILED)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_invalid_rows_do_not_affect_the_others(law, spoil, value):
    q, twist, (lower, upper) = questions()
    lower[5, 7] = upper[5, 7] = 0.25
    want = ("residual", "pose", "jacobian", "active", "task_error", "damping", "scale", "iterations")
    good = sr.solve_batch(ARM, law, q, twist, (lower, upper), want=want)
    spoil(q, twist, lower, upper, value)
    batch = sr.solve_batch(ARM, law, q, twist, (lower, upper), want=want)
    others = np.arange(N) != 5
    for name in ("rates", "status", *want):
        assert np.array_equal(getattr(batch, name)[others], getattr(good, name)[others]), name
        assert np.all(np.isfinite(getattr(batch, name)[5])), name
    assert batch.status[5] == Status.INVALID_INPUT
    assert batch.rates[5, 7] == 0.25
    assert np.count_nonzero(batch.rates[5]) == 1
    assert batch.active[5, 7] == sr.Reason.FAULT
    assert np.array_equal(batch.pose[5], np.zeros((4, 4)))


@pytest.mark.parametrize(("low", "high"), [(0.2, 0.1), (-0.5, -np.inf), (np.inf, 0.5), (np.inf, np.inf), (np.nan, 0.5)])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_limits_make_no_answer_of_bounds_that_leave_no_rate(law, low, high):
    q, twist, (lower, upper) = questions()
    lower[5], upper[5] = -0.5, 0.5
    lower[5, 0], upper[5, 0] = low, high
    limited = ARM.with_limits(position=(-3.0, 3.0), acceleration=5.0)
    batch = sr.solve_batch(limited, law, q, twist, (lower, upper), last_rates=np.zeros(11), period=0.1)
    assert np.array_equal(np.flatnonzero(batch.status & Status.INVALID_INPUT), [5])
    assert np.array_equal(batch.rates[5], np.zeros(11))


@pytest.mark.parametrize("name", ["reference", "last_rates"])
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_a_nan_beside_the_question_marks_its_row(law, name):
    q, twist, bounds = questions()
    values = np.zeros((N, 11))
    values[4, 2] = np.nan
    limited = ARM.with_limits(acceleration=5.0)
    batch = sr.solve_batch(
        limited, law, q, twist, bounds, **{name: values}, period=0.1 if name == "last_rates" else None
    )
    assert np.array_equal(np.flatnonzero(batch.status & Status.INVALID_INPUT), [4])
    assert np.all(np.isfinite(batch.rates))


def test_a_jacobian_with_a_nan_marks_its_row():
    q, twist, bounds = questions()
    jacobians = ARM.jacobian(q)
    good = sr.solve_batch(None, LAW, None, twist, bounds, jacobians=jacobians)
    jacobians[3, 2, 10] = np.inf
    batch = sr.solve_batch(None, LAW, None, twist, bounds, jacobians=jacobians)
    assert np.array_equal(np.flatnonzero(batch.status & Status.INVALID_INPUT), [3])
    others = np.arange(N) != 3
    assert np.array_equal(batch.rates[others], good.rates[others])


def test_out_receives_the_rates():
    q, twist, bounds = questions()
    out = np.full((N, 11), 7.0)
    batch = sr.solve_batch(ARM, LAW, q, twist, bounds, out=out)
    assert batch.rates is out
    same(batch, sr.solve_batch(ARM, LAW, q, twist, bounds))


def read_only():
    array = np.full((N, 11), 7.0)
    array.setflags(write=False)
    return array


OUTS = {
    "read-only": read_only,
    "float32": lambda: np.full((N, 11), 7.0, np.float32),
    "integers": lambda: np.full((N, 11), 7),
    "one row too few": lambda: np.full((N - 1, 11), 7.0),
    "one column too few": lambda: np.full((N, 10), 7.0),
    "flat": lambda: np.full(N * 11, 7.0),
    "Fortran order": lambda: np.full((N, 11), 7.0, order="F"),
    "strided": lambda: np.full((N, 22), 7.0)[:, ::2],
    "a list": lambda: [[7.0] * 11] * N,
    "True": lambda: True,
}


@pytest.mark.parametrize("form", OUTS)
def test_another_out_is_refused_and_nothing_written(form):
    q, twist, bounds = questions()
    out = OUTS[form]()
    with pytest.raises(InputError) as caught:
        sr.solve_batch(ARM, LAW, q, twist, bounds, out=out)
    assert caught.value.argument == "out"
    assert form == "True" or np.all(np.asarray(out) == 7.0)


@pytest.mark.parametrize("name", ["q", "twist", "lower", "upper", "reference", "last"])
def test_out_in_the_memory_of_an_input_is_refused(name):
    memory = np.zeros(N * 22)
    arrays = {key: np.full((N, 11), 0.1) for key in ("q", "reference", "last")}
    arrays |= {"twist": np.full((N, 6), 0.1), "lower": np.full((N, 11), -0.5), "upper": np.full((N, 11), 0.5)}
    shape = arrays[name].shape
    arrays[name] = memory[5 : 5 + N * shape[1]].reshape(shape)
    before = arrays[name].copy()
    with refused("out", name):
        sr.solve_batch(
            ARM,
            LAW,
            arrays["q"],
            arrays["twist"],
            (arrays["lower"], arrays["upper"]),
            reference=arrays["reference"],
            last_rates=arrays["last"],
            period=0.1,
            out=memory[: N * 11].reshape(N, 11),
        )
    assert np.array_equal(arrays[name], before)
