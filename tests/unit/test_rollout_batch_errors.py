"""Every wrong argument of rollout_batch is answered with one InputError that names it."""

import numpy as np
import pytest

import stillreach as sr
from stillreach.errors import InputError
from tests.refusals import refused

N, T = 4, 5
ARM = sr.arms.nasa_modular()
GOOD = {
    "arm": ARM,
    "law": sr.LeastError(),
    "start": np.full((N, 11), 0.1),
    "twist": np.full((N, 6), 0.1),
    "bounds": (np.full((N, 11), -0.5), np.full((N, 11), 0.5)),
    "period": 0.01,
    "steps": T,
}
TEXT, BOOLS, COMPLEX, OBJECTS = "0.1", np.full((N, 11), True), np.full((N, 11), 0.1j), np.full((N, 11), None)
NEVER = [TEXT, BOOLS, COMPLEX, OBJECTS, [[1.0, 2.0], [3.0]], np.datetime64("2026-01-01"), {}, {1.0}, lambda: 0, 0.1]
NAN_AT_ONE_STEP = np.zeros((1, T, 6))
NAN_AT_ONE_STEP[0, 3, 2] = np.nan
COUNTS = [0, -1, 2.0, "2", True, None, np.nan, [2], 2**70, -(2**70)]


def wrong(name, values):
    return [(GOOD | {name: value}, name) for value in values]


CASES = [
    *wrong("arm", [None, "paper", ARM.model, 7, sr.arms.nasa_modular]),
    *wrong("law", [None, "LeastError", sr.LeastError, 0.1, sr.LeastError().core()]),
    *wrong("start", [*NEVER, None, np.zeros(11), np.zeros((N, 10)), np.zeros((11, N)), np.zeros((N, 11, 1))]),
    *wrong("twist", [*NEVER, None, np.zeros(5), np.zeros((N, 5)), np.zeros((N + 1, 6)), np.zeros((1, 6))]),
    *wrong("twist", [np.zeros((T, 6)), np.zeros((N, T + 1, 6)), np.zeros((T, N, 6)), np.zeros((N, 1, 6))]),
    *wrong("twist", [[0, 0, np.nan, 0, 0, 0], [np.inf] * 6, NAN_AT_ONE_STEP, [True] * 6, np.zeros((1, T, 7))]),
    *wrong("bounds", [None, 0.5, GOOD["bounds"][0], {}, sr.Bounds.unbounded(10), "inf", (), [0.5], (0.5, -0.5)]),
    *wrong("bounds", [(TEXT, 0.5), (np.zeros(10), 0.5), (-0.5, np.zeros((N + 1, 11))), (np.full(11, np.nan), 0.5)]),
    *wrong("period", [None, 0.0, -1.0, np.nan, np.inf, "0.1", True, 1j, [0.1]]),
    *wrong("steps", COUNTS),
    *wrong("every", COUNTS),
    *wrong("task", ["pose", (True,) * 6, sr.Weights(), 0]),
    *wrong("last_rates", [*NEVER, np.zeros(11), np.zeros((N, 10)), np.zeros((N + 1, 11))]),
    *wrong("integrator", ["rk5", "Euler", "", None, 4, b"rk4", True]),
    *wrong("record", ["rate", "", "final_q", 5, True, None, [5], [None], ["q", "Rates"], b"q"]),
    *wrong("threads", [0, -1, 2.0, "2", True, np.nan, [2], 1025, 2**40]),
]


def roll(given):
    given = dict(given)
    first = [given.pop(name) for name in ("arm", "law", "start", "twist", "bounds")]
    return sr.rollout_batch(*first, **given)


@pytest.mark.parametrize(("given", "argument"), CASES)
def test_it_is_named(given, argument):
    with pytest.raises(InputError) as caught:
        roll(given)
    error = caught.value
    assert error.argument == argument, str(error)
    assert str(error) == f"{argument}: got {error.got}, expected {error.expected}"
    assert error.got
    assert error.expected


def test_weights_that_contradict_or_do_not_fit():
    law = sr.LeastError(weights=sr.Weights(length=0.2))
    with refused("weights"):
        roll(GOOD | {"law": law, "task": sr.Task(weights=sr.Weights(length=0.1))})
    with refused("weights.joints"):
        roll(GOOD | {"law": sr.LeastError(weights=sr.Weights(joints=np.ones(3)))})


@pytest.mark.parametrize("record", ["q", "rates", "task_error", "status"])
def test_records_that_no_memory_holds(record):
    with refused("record", record, f"({N}, 1000000000000"):
        roll(GOOD | {"record": record, "steps": 10**12, "twist": np.zeros(6)})


def test_typos_are_met_with_the_word():
    with refused("record", "'rate'", "did you mean 'rates'"):
        roll(GOOD | {"record": "rate"})
    with refused("integrator", "'eular'", "did you mean 'euler'"):
        roll(GOOD | {"integrator": "eular"})


def test_good_arguments_pass():
    assert len(roll(GOOD)) == N
    assert len(roll(GOOD | {"twist": [0.1] * 6, "bounds": (-0.5, 0.5), "start": GOOD["start"].tolist()})) == N
    assert roll(GOOD | {"every": 10**12, "record": "q", "threads": 1024}).q.shape == (N, 1, 11)
