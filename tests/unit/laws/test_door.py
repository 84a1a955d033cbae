"""What the laws refuse, and in which words: the argument, what came, what was expected."""

import inspect

import numpy as np
import pytest

import stillreach as sr

J, TWIST, BOUNDS = np.eye(6, 7), np.ones(6), sr.Bounds.symmetric(1.0, n=7)
LAWS = [
    sr.Pseudoinverse(),
    sr.SingularityRobust(),
    sr.SingularityRobust(damping=0.1),
    sr.LeastError(),
    sr.KeepDirection(),
]
EVERY_LAW = pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)


def poisoned(array, value):
    array = np.array(array, float)
    array.flat[3] = value
    return array


def refused(call, argument, *words):
    """The call raises InputError for `argument`, and the message holds it and each of `words`."""
    with pytest.raises(sr.InputError) as caught:
        call()
    message = str(caught.value)
    assert caught.value.argument == argument
    for word in (argument, "expected", *words):
        assert word in message, message


@EVERY_LAW
@pytest.mark.parametrize(
    ("jacobian", "words"),
    [
        (poisoned(J, np.nan), ["nan"]),
        (poisoned(J, np.inf), ["inf"]),
        (np.ones(6), ["(6,)"]),
        (np.ones((1, 6, 7)), ["(1, 6, 7)"]),
        (np.ones((7, 7)), ["7"]),
        (np.ones((0, 7)), ["(0, 7)"]),
        (np.ones((6, 7), complex), ["complex"]),
        (np.ones((6, 7), bool), ["bool"]),
        ("J", ["'J'"]),
        (None, ["None"]),
        ([[1.0, 2.0], [3.0]], []),
    ],
    ids=str,
)
def test_a_jacobian_that_is_none(law, jacobian, words):
    refused(lambda: law.solve(jacobian, TWIST, BOUNDS), "J", *words)


@EVERY_LAW
@pytest.mark.parametrize(
    ("twist", "words"),
    [
        (poisoned(TWIST, np.nan), ["nan", "6"]),
        (poisoned(TWIST, -np.inf), ["inf", "6"]),
        (np.ones(5), ["(5,)", "6"]),
        (np.ones((6, 1)), ["(6, 1)", "6"]),
        (["a"] * 6, ["6"]),
        (None, ["None", "6"]),
    ],
    ids=str,
)
def test_a_twist_that_is_none(law, twist, words):
    refused(lambda: law.solve(J, twist, BOUNDS), "twist", *words)


@EVERY_LAW
@pytest.mark.parametrize("bounds", [None, (-1.0, 1.0), np.ones((2, 7))], ids=str)
def test_bounds_that_are_none(law, bounds):
    refused(lambda: law.solve(J, TWIST, bounds), "bounds", "Bounds")


@EVERY_LAW
def test_bounds_of_another_arm(law):
    refused(lambda: law.solve(J, TWIST, sr.Bounds.symmetric(1.0, n=6)), "bounds", "6", "7")


@EVERY_LAW
@pytest.mark.parametrize("reference", [np.ones(6), poisoned(np.ones(7), np.nan), "home"], ids=str)
def test_a_reference_that_is_none(law, reference):
    refused(lambda: law.solve(J, TWIST, BOUNDS, reference=reference), "reference", "7")


@EVERY_LAW
def test_arguments_after_the_bounds_need_their_names(law):
    with pytest.raises(TypeError):
        law.solve(J, TWIST, BOUNDS, np.zeros(7))


@EVERY_LAW
@pytest.mark.parametrize("row_kinds", ["vvv", "vvvwwx", 3], ids=str)
def test_row_kinds_that_do_not_fit(law, row_kinds):
    refused(lambda: law.solve(J, TWIST, BOUNDS, row_kinds=row_kinds), "row_kinds")


def test_units_need_to_know_what_the_rows_are():
    law = sr.Pseudoinverse(weights=sr.Weights(length=0.1))
    refused(lambda: law.solve(np.ones((3, 7)), np.ones(3), BOUNDS), "row_kinds", "3")


@pytest.mark.parametrize(
    ("settings", "argument", "words"),
    [
        ({"damping": "exat"}, "damping", ["'exat'", "closed-form", "exact"]),
        ({"damping": -1.0}, "damping", ["-1"]),
        ({"damping": np.nan}, "damping", ["nan"]),
        ({"damping": True}, "damping", ["True"]),
        ({"damping": None}, "damping", ["None"]),
        ({"norm": "1"}, "norm", ["'1'", "inf", "2"]),
        ({"norm": np.inf}, "norm", ["inf", "2"]),
        ({"rank_tolerance": -1e-3}, "rank_tolerance", ["-0.001"]),
        ({"rank_tolerance": 1.5}, "rank_tolerance", ["1.5"]),
        ({"rank_tolerance": np.nan}, "rank_tolerance", ["nan"]),
        ({"weights": np.ones(6)}, "weights", ["Weights"]),
    ],
    ids=str,
)
def test_settings_of_the_singularity_robust_law(settings, argument, words):
    refused(lambda: sr.SingularityRobust(**settings), argument, *words)


@pytest.mark.parametrize("gain", [0.0, -1.0, np.nan, np.inf, "10", True], ids=str)
def test_settings_of_least_error(gain):
    refused(lambda: sr.LeastError(price=gain), "price")


@EVERY_LAW
def test_laws_are_frozen_and_compare_by_their_settings(law):
    with pytest.raises(AttributeError):
        law.rank_tolerance = 1.0
    assert law == type(law)(**{name: getattr(law, name) for name in inspect.signature(type(law)).parameters})


@EVERY_LAW
def test_lists_integers_and_float32_are_numbers(law):
    wanted = law.solve(J, TWIST, BOUNDS).rates
    np.testing.assert_array_equal(law.solve(J.astype(int).tolist(), [1] * 6, BOUNDS).rates, wanted)
    np.testing.assert_array_equal(law.solve(J.astype(np.float32), TWIST.astype(np.float32), BOUNDS).rates, wanted)


@EVERY_LAW
def test_a_transposed_or_strided_jacobian_is_read_as_what_it_says(law):
    rng = np.random.default_rng(0)
    j, twist = rng.normal(size=(6, 7)), rng.normal(size=6)
    wanted = law.solve(j, twist, BOUNDS).rates
    np.testing.assert_array_equal(law.solve(np.asfortranarray(j), twist, BOUNDS).rates, wanted)
    wide, long = np.zeros((6, 14)), np.zeros(12)
    wide[:, ::2], long[::2] = j, twist
    np.testing.assert_array_equal(law.solve(wide[:, ::2], long[::2], BOUNDS).rates, wanted)


@EVERY_LAW
def test_the_arguments_are_left_as_they_were(law):
    j, twist, nu = J.copy(), TWIST.copy(), np.ones(7)
    law.solve(j, twist, BOUNDS, reference=nu)
    np.testing.assert_array_equal(j, J)
    np.testing.assert_array_equal(twist, TWIST)
    np.testing.assert_array_equal(nu, np.ones(7))


@EVERY_LAW
def test_numerically_hard_is_not_an_error(law):
    """Singular, empty of motion, huge, denormal: an answer, finite and inside the bounds."""
    big, small = np.finfo(float).max / 1e3, np.finfo(float).smallest_subnormal
    for jacobian in (np.zeros((6, 7)), J * 1e-300, J * 1e150, np.ones((6, 7))):
        for twist in (np.zeros(6), np.full(6, big), np.full(6, small), TWIST):
            for limit in (0.0, small, 1.0, big):
                out = law.solve(jacobian, twist, sr.Bounds.symmetric(limit, n=7))
                assert np.all(np.isfinite(out.rates))
                if not isinstance(law, sr.Pseudoinverse):
                    assert np.all(np.abs(out.rates) <= limit)
