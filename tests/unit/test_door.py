"""The public door: what is let in, in which form, and what is turned away, with which words."""

import sys
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stillreach as sr
from stillreach import _door
from stillreach._labels import Labels
from stillreach.errors import InputError
from tests.refusals import refused

THREE = Labels("joint", ("a", "b", "c"))
HUGE = 10**400  # an integer, but no float64
NEVER_NUMBERS = [
    None,
    "1",
    "nan",
    b"1",
    True,
    np.True_,
    1j,
    np.complex64(1),
    Decimal("1"),
    Fraction(1, 2),
    HUGE,
    {},
    {"x": 1},
    {1.0},
    object(),
    np.datetime64("2020-01-01"),
    np.timedelta64(1, "s"),
    ["1", "2", "3"],
    [1, "2", 3],
    [True, False, True],
    [1.0, True, 2.0],
    (1, np.False_, 2),
    [1j, 0, 0],
    [1, None, 2],
    [[1, 2], [3]],
    [1, [2], 3],
    [[1, 2, 3], 4],
    np.array([True, False, True]),
    np.array([1, 2, 3], dtype=object),
    np.array(["1", "2", "3"]),
    np.zeros(3, dtype=complex),
    np.zeros(3, dtype="M8[s]"),
    np.zeros(3, dtype=[("x", float)]),
    [np.array([True]), np.array([False]), np.array([True])],
]
DOORS = {
    "vector": lambda value: _door.vector("it", value, 3),
    "vector of any length": lambda value: _door.vector("it", value, None),
    "matrix": lambda value: _door.matrix("it", value, (None, None)),
    "configurations": lambda value: _door.configurations("it", value, THREE),
    "scalar": lambda value: _door.scalar("it", value),
    "positive": lambda value: _door.positive("it", value),
    "count": lambda value: _door.count("it", value),
    "unit_vector": lambda value: _door.unit_vector("it", value),
    "pose": lambda value: _door.pose("it", value),
    "choice": lambda value: _door.choice("it", value, ["one", "two"]),
}


REFUSED = [(door, value) for door in DOORS for value in NEVER_NUMBERS if not (door == "count" and value is HUGE)]


@pytest.mark.parametrize(("door", "value"), REFUSED)
def test_what_is_no_number_passes_no_door(door, value):
    with pytest.raises(InputError) as caught:
        DOORS[door](value)
    error = caught.value
    assert error.argument == "it"
    assert error.got
    assert error.expected
    assert str(error) == f"it: got {error.got}, expected {error.expected}"


@pytest.mark.parametrize(
    "value",
    [
        [1, 2, 3],
        (1.0, 2, 3),
        np.array([1, 2, 3], dtype=np.float32),
        np.arange(1, 4),
        np.arange(1, 7)[::2] * 0.5 + 0.5,
    ],
)
def test_a_vector_is_a_read_only_float64_copy(value):
    got = _door.vector("it", value, 3)
    assert got.tolist() == [1.0, 2.0, 3.0]
    assert got.dtype == np.float64
    assert got.flags.c_contiguous
    assert not got.flags.writeable
    assert not np.shares_memory(got, value)


def test_one_number_stands_for_all():
    for one in (2, 2.0, np.float32(2), np.array(2)):
        assert _door.vector("it", one, 3).tolist() == [2.0, 2.0, 2.0]
    assert _door.vector("it", [], 0).shape == (0,)
    assert _door.vector("it", [1, 2], None).tolist() == [1.0, 2.0]


def test_one_number_is_refused_where_each_is_its_own():
    assert _door.vector("q", [1, 2], 2, one_for_all=False).tolist() == [1.0, 2.0]
    for one in (0.0, np.array(1.0)):
        with refused("q", "2"):
            _door.vector("q", one, 2, one_for_all=False)


def test_none_stands_for_the_default():
    assert _door.vector("it", None, 2, default=3.0).tolist() == [3.0, 3.0]
    assert _door.vector("it", None, 2, default=[1, 2]).tolist() == [1.0, 2.0]
    assert _door.vector("it", 0.0, 2, default=3.0).tolist() == [0.0, 0.0]
    assert _door.vector("it", None, 2, default=0.0).tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("value", "options", "message"),
    [
        ([1, 2], {}, "it: got [1, 2] of shape (2,), expected 3 finite numbers (or one for all)"),
        (
            np.ones((1, 3)),
            {},
            "it: got a float64 array of shape (1, 3), expected 3 finite numbers (or one for all)",
        ),
        (
            np.ones(4, np.float32),
            {},
            "it: got a float32 array of shape (4,), expected 3 finite numbers (or one for all)",
        ),
        ([1, np.nan, 3], {}, "it: got nan at index 1, expected 3 finite numbers (or one for all)"),
        ([1, 2, -np.inf], {}, "it: got -inf at index 2, expected 3 finite numbers (or one for all)"),
        (np.nan, {}, "it: got nan, expected 3 finite numbers (or one for all)"),
        (np.nan, {"allow_inf": True}, "it: got nan, expected 3 numbers (or one for all)"),
        (
            [1, np.inf, np.nan],
            {"allow_inf": True},
            "it: got nan at index 2, expected 3 numbers (or one for all)",
        ),
        (
            [1, -2, 3],
            {"minimum": 0},
            "it: got -2.0 at index 1, expected 3 finite numbers (or one for all), each at least 0",
        ),
        ("fast", {}, "it: got 'fast', expected 3 finite numbers (or one for all)"),
        (None, {}, "it: got None, expected 3 finite numbers (or one for all)"),
    ],
)
def test_a_refused_vector_says_what_came_and_what_was_expected(value, options, message):
    with pytest.raises(InputError) as caught:
        _door.vector("it", value, 3, **options)
    assert str(caught.value) == message


def test_infinite_entries_where_they_are_legal():
    assert _door.vector("it", [np.inf, -np.inf], 2, allow_inf=True).tolist() == [np.inf, -np.inf]
    assert _door.vector("it", [np.inf, 0], 2, allow_inf=True, minimum=0).tolist() == [np.inf, 0]
    assert _door.matrix("it", [[np.inf]], (1, 1), allow_inf=True).tolist() == [[np.inf]]
    assert _door.scalar("it", np.inf, allow_inf=True) == np.inf
    assert _door.positive("it", np.inf, allow_inf=True) == np.inf


@pytest.mark.skipif(np.finfo(np.longdouble).max == np.finfo(float).max, reason="no wider float")
def test_a_number_too_large_for_float64_is_infinite():
    with refused("it", "inf"):
        _door.vector("it", np.full(2, np.finfo(np.longdouble).max), 2)


def test_a_matrix_of_a_given_shape():
    got = _door.matrix("it", np.asfortranarray([[1, 2, 3], [4, 5, 6]]), (2, 3))
    assert got.tolist() == [[1, 2, 3], [4, 5, 6]]
    assert got.flags.c_contiguous
    assert not got.flags.writeable
    assert _door.matrix("it", [[1, 2]], (None, 2)).shape == (1, 2)
    for value in ([[1, 2]], [1, 2, 3], np.ones((3, 2)), np.ones((1, 2, 3))):
        with refused("it", "(2, 3)"):
            _door.matrix("it", value, (2, 3))
    with refused("it", "(any, 2)"):
        _door.matrix("it", [[1, 2, 3]], (None, 2))


def test_configurations_are_not_copied_without_need():
    q = np.zeros((5, 3))
    assert _door.configurations("q", q, THREE) is q
    assert _door.configurations("q", np.asfortranarray(q), THREE).flags.c_contiguous
    assert _door.configurations("q", np.zeros((0, 3)), THREE).shape == (0, 3)


@pytest.mark.parametrize(
    ("value", "options", "ok"),
    [
        (1, {}, True),
        (np.float32(0.5), {}, True),
        (np.array(2), {}, True),
        (0, {}, False),
        (-1, {}, False),
        (5e-324, {}, True),
        (0, {"or_zero": True}, True),
        (-5e-324, {"or_zero": True}, False),
        (np.inf, {}, False),
        (np.nan, {"allow_inf": True}, False),
        ([1.0], {}, False),
        (np.array([1.0]), {}, False),
    ],
)
def test_positive(value, options, ok):
    if ok:
        got = _door.positive("it", value, **options)
        assert type(got) is float
        assert got == value
    else:
        with refused("it", " 0"):
            _door.positive("it", value, **options)


def test_count():
    assert _door.count("it", np.uint8(3)) == 3
    assert type(_door.count("it", np.int64(3))) is int
    assert _door.count("it", 0, minimum=0) == 0
    for value in (0, -1, 1.0, np.float64(2), [2], np.array([2])):
        with refused("it", " 1"):
            _door.count("it", value)


def test_arrays_that_name_the_byte_order_of_the_machine_are_read_in_place():
    own = np.dtype(np.float64).newbyteorder("<" if sys.byteorder == "little" else ">")
    value = np.arange(3.0).view(own)
    assert memoryview(value).format != "d"
    read = _door.configurations("q", value, THREE)
    assert memoryview(read).format == "d"
    assert np.shares_memory(read, value)
    np.testing.assert_array_equal(sr.arms.planar(3).jacobian(value), sr.arms.planar(3).jacobian([0.0, 1.0, 2.0]))


def test_choice_suggests_the_nearest_word():
    assert _door.choice("norm", "inf", ("inf", "2")) == "inf"
    assert type(_door.choice("norm", np.str_("inf"), ("inf", "2"))) is str
    with refused("damping", "'Closed form'", "'exact', 'closed-form'", "did you mean 'closed-form'?"):
        _door.choice("damping", "Closed form", ("exact", "closed-form"))
    with refused("damping", "'EXACT'", "did you mean 'exact'?"):
        _door.choice("damping", "EXACT", ("exact", "closed-form"))
    for value in ("zzz", 2, None):
        with refused("norm", "'inf', '2'"):
            _door.choice("norm", value, ("inf", "2"))


def test_unit_vector():
    np.testing.assert_allclose(_door.unit_vector("it", [3, 0, -4]), [0.6, 0, -0.8], rtol=1e-15)
    assert _door.unit_vector("it", [0, -2], n=2).tolist() == [0, -1]
    for value in ([0, 0, 0], [0.0, -0.0, 0], [1, 2], 1.0, [[1, 0, 0]]):
        with refused("it", "3"):
            _door.unit_vector("it", value)


finite = st.floats(allow_nan=False, allow_infinity=False)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(value=st.tuples(finite, finite, finite).filter(any))
def test_a_unit_vector_has_length_one_whatever_came(value):
    got = _door.unit_vector("it", value)
    np.testing.assert_allclose(np.linalg.norm(got), 1.0, rtol=1e-14)
    np.testing.assert_array_equal(_door.unit_vector("it", got), got)
    largest = int(np.argmax(np.abs(value)))
    np.testing.assert_allclose(np.array(value) / value[largest] * got[largest], got, rtol=1e-9, atol=1e-12)


def test_a_pose_is_a_copy_and_read_only():
    T = np.eye(4)
    got = _door.pose("it", T)
    T[0, 0] = 5
    assert got[0, 0] == 1
    assert not got.flags.writeable


@pytest.mark.parametrize("off", [1e-13, 1e-10, 1.9e-5, 2.1e-5])
def test_a_rotation_is_within_1e_5_of_the_nearest(off):
    """A shear by `off` is half of it away from the nearest rotation, a turn by -off / 2."""
    T = np.eye(4)
    T[0, 1] = off
    if off > 2e-5:
        with refused("it", "2.1e-05", "1e-05"):
            _door.pose("it", T)
    else:
        half = off if off < 1e-12 else off / 2
        np.testing.assert_allclose(_door.pose("it", T)[0, 1], half, rtol=1e-9)


def test_long_values_are_cut_in_the_message():
    with pytest.raises(InputError) as caught:
        _door.vector("it", list(range(10_000)), 3)
    assert "of shape (10000,)" in str(caught.value)
    assert len(str(caught.value)) < 200
