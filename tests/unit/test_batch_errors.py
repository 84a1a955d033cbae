"""Every wrong argument of solve_batch is answered with one InputError that names it."""

import numpy as np
import pytest

import stillreach as sr
from stillreach.errors import InputError, StillreachError
from tests.refusals import refused

N = 4
ARM = sr.arms.nasa_modular()
GOOD = {
    "arm": ARM,
    "law": sr.LeastError(),
    "q": np.full((N, 11), 0.1),
    "twist": np.full((N, 6), 0.1),
    "bounds": (np.full((N, 11), -0.5), np.full((N, 11), 0.5)),
}
BARE = GOOD | {"arm": None, "q": None, "jacobians": np.ones((N, 6, 11))}
TEXT, BOOLS, COMPLEX = "0.1", np.full((N, 11), True), np.full((N, 11), 0.1j)
NAN_TWIST, RAGGED, OBJECTS = np.array([0, 0, np.nan, 0, 0, 0]), [[1.0, 2.0], [3.0]], np.full((N, 11), None)
NEVER = [TEXT, BOOLS, COMPLEX, RAGGED, OBJECTS, np.datetime64("2026-01-01"), {}, {1.0}, lambda: 0, 0.1]
PAIR = GOOD["bounds"]
NAN_BOUND, INVERTED = np.full(11, np.nan), (np.full(11, 0.5), np.full(11, -0.5))


def wrong(name, values, good=GOOD, argument=None, **others):
    return [(good | others | {name: value}, argument or name) for value in values]


CASES = [
    *wrong("arm", [None, "paper", ARM.model, 7, sr.arms.nasa_modular]),
    *wrong("law", [None, "LeastError", sr.LeastError, 0.1, sr.LeastError().core()]),
    *wrong(
        "q", [*NEVER, None, np.zeros(11), np.zeros((N, 10)), np.zeros((11, N)), np.zeros((N, 11, 1)), np.zeros((0, 6))]
    ),
    *wrong("twist", [*NEVER, None, np.zeros((N, 5)), np.zeros((N + 1, 6)), np.zeros((6, N)), np.zeros(5), NAN_TWIST]),
    *wrong("twist", [np.zeros((1, 6)), np.zeros((N, 6, 1)), [np.inf] * 6, [True] * 6]),
    *wrong(
        "bounds", [None, 0.5, PAIR[1], np.array(PAIR), PAIR + PAIR[:1], {}, sr.Bounds.unbounded(10), "inf", (), [0.5]]
    ),
    *wrong("bounds", [(side, PAIR[1]) for side in (TEXT, BOOLS, None, COMPLEX, np.zeros(10), np.zeros((N, 10)))]),
    *wrong(
        "bounds", [(PAIR[0], side) for side in (TEXT, BOOLS, None, RAGGED, np.zeros((N + 1, 11)), np.zeros((11, N)))]
    ),
    *wrong(
        "bounds", [(NAN_BOUND, 0.5), (-0.5, NAN_BOUND), INVERTED, (0.5, -0.5), (np.inf, np.inf), (-np.inf, -np.inf)]
    ),
    *wrong("jacobians", [*NEVER, np.ones((N, 6)), np.ones((N, 7, 11)), np.ones((N, 0, 11)), np.ones((N, 6, 0))], BARE),
    *wrong("q", [GOOD["q"], 0.0], BARE),
    *wrong("arm", [sr.arms.planar(3), "paper", ARM.model], BARE),
    *wrong("task", [sr.Task(), "pose"], BARE),
    *wrong("twist", [np.zeros((N, 3)), np.zeros(3), None, np.zeros((N + 1, 6)), NAN_TWIST], BARE),
    *wrong("row_kinds", ["vvv", "vvvwwx", 6, b"vvvwww", ["v"] * 6], BARE),
    *wrong("joint_kinds", ["R", "R" * 10 + "X", 11, ["R"] * 11], BARE),
    *wrong("length", ["1", 0.0, -1.0, np.nan, np.inf, True, [1.0]], BARE),
    *wrong("length", [None], BARE, law=sr.LeastError(price=(100, 8))),
    *wrong("length", [1.0]),
    *wrong("last_rates", [np.zeros((N, 11))], BARE, period=0.1),
    *wrong("task", ["pose", (True,) * 6, sr.Weights(), 0]),
    *wrong("row_kinds", ["vvvwww"]),
    *wrong("joint_kinds", ["R" * 11]),
    *wrong("reference", [*NEVER, np.zeros(10), np.zeros((N, 10)), np.zeros((N + 1, 11)), NAN_BOUND]),
    *wrong("last_rates", [*NEVER, np.zeros(10), np.zeros((N, 10)), np.zeros((N + 1, 11)), NAN_BOUND], period=0.1),
    *wrong("period", [None, 0.0, -1.0, np.nan, np.inf, "0.1", True, 1j, [0.1]], last_rates=np.zeros(11)),
    *wrong("period", [0.1]),
    *wrong("want", ["rates", "residuals", "", 5, True, None, [5], [None], ["residual", "Pose"], "status", b"pose"]),
    *wrong("want", ["pose"], BARE),
    *wrong("threads", [0, -1, 2.0, "2", True, np.nan, [2], 1025, 2**40, -(2**70)]),
]


@pytest.mark.parametrize(("given", "argument"), CASES)
def test_it_is_named(given, argument):
    given = dict(given)
    first = [given.pop(name) for name in ("arm", "law", "q", "twist", "bounds")]
    out = np.full((N, 11), 7.0)
    with pytest.raises(InputError) as caught:
        sr.solve_batch(*first, out=out, **given)
    error = caught.value
    assert isinstance(error, StillreachError)
    assert error.argument == argument, str(error)
    assert error.got
    assert error.expected
    assert str(error) == f"{argument}: got {error.got}, expected {error.expected}"
    assert np.all(out == 7.0)


def test_weights_in_law_and_task_are_refused():
    task = sr.Task(weights=sr.Weights(length=0.1))
    given = (GOOD["q"], GOOD["twist"], GOOD["bounds"])
    with refused("weights"):
        sr.solve_batch(ARM, sr.LeastError(weights=sr.Weights(length=0.2)), *given, task=task)
    shared = task.weights
    sr.solve_batch(ARM, sr.LeastError(weights=shared), *given, task=task)


def test_weights_of_another_size_are_refused():
    given = (GOOD["q"], GOOD["twist"], GOOD["bounds"])
    with refused("weights.joints"):
        sr.solve_batch(ARM, sr.LeastError(weights=sr.Weights(joints=np.ones(3))), *given)
    with refused("weights.task"):
        sr.solve_batch(ARM, sr.LeastError(weights=sr.Weights(task=np.ones(3))), *given)


def test_a_typo_is_met_with_the_word():
    with refused("want", "'residuals'", "did you mean 'residual'"):
        sr.solve_batch(*GOOD.values(), want="residuals")


def test_good_arguments_pass():
    assert len(sr.solve_batch(*GOOD.values())) == N
    first = [BARE[name] for name in ("arm", "law", "q", "twist", "bounds")]
    assert len(sr.solve_batch(*first, jacobians=BARE["jacobians"])) == N
    assert len(sr.solve_batch(*first[:3], np.zeros(6), (-0.5, 0.5), jacobians=BARE["jacobians"], threads=1024)) == N
