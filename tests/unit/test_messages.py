"""Suggestions in messages."""

import pytest

from stillreach._messages import did_you_mean, nearest


@pytest.mark.parametrize(
    ("word", "choices", "near"),
    [
        ("radius", ("centre", "axis", "angle", "duration"), None),  # the radius is the distance of the start
        ("joint9", ("joint1", "joint7"), None),
        ("j22", ("j1", "j2"), "j2"),
        ("Joint_7", ("joint-1", "joint-7"), "joint-7"),
        ("least error", ("least-error", "keep-direction"), "least-error"),
        ("hnd", ("base", "hand"), "hand"),
        ("canadarm", ("canadarm2", "planar"), "canadarm2"),
        ("degrees", ("rad", "deg"), "deg"),
        ("J2", ("j1", "j2"), "j2"),
        ("axes", ("centre", "axis"), "axis"),
        ("", ("a",), None),
        ("x" * 101, ("x" * 100,), None),
        (3, ("3",), None),
    ],
)
def test_a_suggestion_is_what_was_misspelt_and_nothing_else(word, choices, near):
    assert nearest(word, choices) == near
    assert did_you_mean(word, choices) == (f" (did you mean {near!r}?)" if near else "")
