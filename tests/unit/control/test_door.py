"""The door of step, track and bind: what is refused, in which words, and that nothing changes when it is."""

import gc
import sys

import numpy as np
import pytest

import stillreach as sr
from tests.unit.control.robots import TWIST, configuration, mixed, refused

N = 8
Q = np.linspace(-0.7, 0.9, N)
POSE = np.eye(4)


@pytest.fixture
def ctl():
    """A controller that has moved, with a fault and with limits that its next answer depends on."""
    ctl = sr.Controller(mixed(), velocity_limits=1.0, acceleration_limits=20.0, period=0.01)
    ctl.fail("j2")
    ctl.step(Q, TWIST)
    return ctl


def state(ctl):
    """All that a refused call could have changed, and the answer to one more tick of a copy that was never asked."""
    return ctl.last_rates.tolist(), ctl.health.tolist(), ctl.faults


def poisoned(value, at=2, n=N):
    out = np.zeros(n)
    out[at] = value
    return out


BAD_VECTORS = [
    (lambda n: poisoned(np.nan, n=n), ["nan", "index 2"]),
    (lambda n: poisoned(-np.inf, n=n), ["-inf", "index 2"]),
    (lambda n: np.zeros(n + 1), ["{n} "]),
    (lambda n: np.zeros((n, 1)), ["{n} "]),
    (lambda n: np.zeros((1, n)), ["{n} "]),
    (lambda n: 0.0, ["0.0", "{n} "]),
    (lambda n: np.float64(0.0), ["0.0", "{n} "]),
    (lambda n: np.zeros(n, complex), ["complex"]),
    (lambda n: np.zeros(n, bool), ["bool"]),
    (lambda n: [True] + [0.0] * (n - 1), ["True"]),
    (lambda n: "home", ["'home'"]),
    (lambda n: None, ["None"]),
    (lambda n: [[0.0], [0.0, 1.0]], []),
    (lambda n: np.array([None] * n), ["object"]),
]
EVERY_BAD_VECTOR = pytest.mark.parametrize(("make", "words"), BAD_VECTORS, ids=range(len(BAD_VECTORS)))


@EVERY_BAD_VECTOR
@pytest.mark.parametrize("argument", ["q", "twist"])
def test_step_refuses_what_is_no_vector_and_changes_nothing(ctl, make, words, argument):
    n = N if argument == "q" else 6
    given = {"q": Q, "twist": TWIST, argument: make(n)}
    before, out = state(ctl), np.full(N, 7.0)
    refused(lambda: ctl.step(given["q"], given["twist"], out=out), argument, *(word.format(n=n) for word in words))
    assert state(ctl) == before
    assert np.all(out == 7.0)


@EVERY_BAD_VECTOR
@pytest.mark.parametrize("argument", ["q", "feedforward"])
def test_track_refuses_what_is_no_vector_and_changes_nothing(ctl, make, words, argument):
    if argument == "feedforward" and words == ["None"]:
        pytest.skip("no feedforward is one")
    n = N if argument == "q" else 6
    given = {"q": Q, "feedforward": TWIST, argument: make(n)}
    before = state(ctl)
    refused(
        lambda: ctl.track(given["q"], POSE, feedforward=given["feedforward"]), argument, *(w.format(n=n) for w in words)
    )
    assert state(ctl) == before


def reflection():
    return np.diag([1.0, 1.0, -1.0, 1.0])


def with_entry(row, column, value):
    T = np.eye(4)
    T[row, column] = value
    return T


BAD_POSES = {
    "wrong shape": (lambda: np.eye(3), "(3, 3)"),
    "nan": (lambda: with_entry(0, 3, np.nan), "nan"),
    "inf": (lambda: with_entry(1, 3, np.inf), "inf"),
    "no rotation": (lambda: with_entry(0, 0, 1.1), "orthonormal"),
    "reflection": (reflection, "reflection"),
    "last row": (lambda: with_entry(3, 3, 2.0), "last row"),
    "nan in the last row": (lambda: with_entry(3, 0, np.nan), "nan"),
    "not quite a rotation": (lambda: with_entry(0, 1, 3e-5), "orthonormal"),
    "text": (lambda: "home", "'home'"),
    "scalar": (lambda: 1.0, "1.0"),
}


@pytest.mark.parametrize("kind", BAD_POSES)
@pytest.mark.parametrize(
    "form", [lambda T: T, lambda T: T.tolist() if isinstance(T, np.ndarray) else T], ids=["array", "list"]
)
def test_track_refuses_a_target_that_is_not_rigid_and_changes_nothing(ctl, kind, form):
    make, word = BAD_POSES[kind]
    before = state(ctl)
    refused(
        lambda: ctl.track(Q, form(make())),
        "target_pose",
        "4",
        *([word] if form(0) == 0 and kind != "wrong shape" else []),
    )
    assert state(ctl) == before


BAD_OUTPUTS = {
    "float32": (lambda: np.zeros(N, np.float32), "float32"),
    "integers": (lambda: np.zeros(N, int), "int64"),
    "big endian": (lambda: np.zeros(N, ">f8"), ">f8"),
    "strided": (lambda: np.zeros(2 * N)[::2], "not contiguous"),
    "reversed": (lambda: np.zeros(N)[::-1], "not contiguous"),
    "unaligned": (lambda: np.frombuffer(bytearray(8 * N + 1), np.uint8)[1:].view(float), ""),
    "read-only": (lambda: np.broadcast_to(np.zeros(N), (N,)), "read-only"),
    "too long": (lambda: np.zeros(N + 1), f"({N + 1},)"),
    "too short": (lambda: np.zeros(N - 1), f"({N - 1},)"),
    "matrix": (lambda: np.zeros((N, 1)), f"({N}, 1)"),
    "list": (lambda: [0.0] * N, "0.0"),
    "scalar": (lambda: 0.0, "0.0"),
}


@pytest.mark.parametrize("kind", BAD_OUTPUTS)
@pytest.mark.parametrize("method", ["step", "track"])
def test_an_out_that_cannot_be_written_in_place_is_refused_and_nothing_changes(ctl, kind, method):
    make, word = BAD_OUTPUTS[kind]
    before, out = state(ctl), make()
    call = {"step": lambda: ctl.step(Q, TWIST, out=out), "track": lambda: ctl.track(Q, POSE, out=out)}[method]
    refused(call, "out", word, "writable", "float64", f"({N},)")
    assert state(ctl) == before


@pytest.mark.parametrize("kind", [kind for kind in BAD_OUTPUTS if kind != "read-only"])
@pytest.mark.parametrize("argument", ["q", "twist", "rates", "target"])
def test_bind_refuses_what_it_cannot_read_or_write_in_place(ctl, kind, argument):
    arrays = {"q": Q.copy(), "twist": TWIST.copy(), "rates": np.zeros(N), "target": np.eye(4)}
    arrays[argument] = BAD_OUTPUTS[kind][0]()
    refused(lambda: ctl.bind(**arrays), argument, "float64")


def test_bind_refuses_rates_that_are_read_only_but_reads_inputs_that_are(ctl):
    q, twist, rates = Q.copy(), TWIST.copy(), np.zeros(N)
    for array in (q, twist, rates):
        array.flags.writeable = False
    refused(lambda: ctl.bind(q=q, twist=twist, rates=rates), "rates", "read-only")
    assert not ctl.bind(q=q, twist=twist, rates=np.zeros(N))() & sr.Status.INVALID_INPUT


def test_bound_arrays_need_their_names(ctl):
    with pytest.raises(TypeError):
        ctl.bind(Q, TWIST, np.zeros(N))


@pytest.mark.parametrize("form", [list, tuple, np.float32, lambda x: x[::-1].copy()[::-1], lambda x: x.astype(">f8")])
def test_step_reads_anything_that_is_numbers(form):
    """Inputs, unlike outputs, may come in any form."""
    q = np.float32(Q).astype(float)
    twist = np.float32(TWIST).astype(float)
    made = [form(x) if form is not np.float32 else x.astype(np.float32) for x in (q, twist)]
    a, b = (sr.Controller(mixed()) for _ in range(2))
    np.testing.assert_array_equal(a.step(*made).rates, b.step(q, twist).rates)


def test_out_takes_the_rates_and_is_what_the_solution_holds(ctl):
    other = sr.Controller(mixed(), velocity_limits=1.0)
    other.fail("j2")
    expected = sr.Controller(mixed(), velocity_limits=1.0)
    expected.fail("j2")
    out = np.full(N, 7.0)
    answer = other.step(Q, TWIST, out=out)
    assert answer.rates is out
    np.testing.assert_array_equal(out, expected.step(Q, TWIST).rates)


@pytest.mark.parametrize("name", ["q", "shifted"])
def test_out_may_overlap_the_inputs(name):
    memory = np.concatenate((Q, [0.0]))
    out = memory[:N] if name == "q" else memory[1:]
    expected = sr.Controller(mixed()).step(Q, TWIST).rates
    np.testing.assert_array_equal(sr.Controller(mixed()).step(memory[:N], TWIST, out=out).rates, expected)
    np.testing.assert_array_equal(out, expected)


def test_new_arrays_are_not_shared_between_ticks(ctl):
    first = ctl.step(Q, TWIST)
    kept = first.rates.copy()
    ctl.step(Q, -TWIST)
    np.testing.assert_array_equal(first.rates, kept)
    assert first.rates.flags.writeable


def test_references_are_not_leaked():
    ctl = sr.Controller(mixed())
    q, twist, rates = Q.copy(), TWIST.copy(), np.zeros(N)
    for call in (lambda: ctl.step(q, twist, out=rates), lambda: ctl.bind(q=q, twist=twist, rates=rates)()):
        call()
        gc.collect()
        before = [sys.getrefcount(x) for x in (q, twist, rates)]
        for _ in range(50):
            call()
        gc.collect()
        assert [sys.getrefcount(x) for x in (q, twist, rates)] == before


@pytest.mark.parametrize("n", [511, 513, 600, 2000])
def test_an_arm_of_any_length_is_answered_or_refused(n):
    arm = sr.arms.planar(n)
    out = sr.Controller(arm).step(configuration(arm) / n, np.zeros(6))
    assert np.all(out.rates == 0.0)
