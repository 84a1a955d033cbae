"""What a price may be, and what is said of any other."""

import numpy as np
import pytest

import stillreach as sr

WRONG = {
    "zero": (0.0, "above 0"),
    "negative": (-1.0, "above 0"),
    "nan": (float("nan"), "price"),
    "infinite": (float("inf"), "price"),
    "a word": ("attitude-first", "position-first"),
    "one of a pair": ((80.0,), "pair"),
    "three": ((1.0, 2.0, 3.0), "pair"),
    "a pair with 0": ((80.0, 0.0), "above 0"),
    "a pair with None": ((80.0, None), "price"),
    "no rows": ({}, "1 to 3 parts"),
    "four parts": ({"vx": 1.0, "vy": 1.0, "vz": 1.0, "orientation": 1.0}, "1 to 3 parts"),
    "an unknown row": ({"vq": 1.0}, "vq"),
    "a row twice": ({"position": 1.0, "vx wx": 1.0}, "each row once"),
    "a row twice in a word": ({"vx vx": 1.0}, "each row once"),
    "an empty name": ({"": 1.0}, "names of rows"),
    "a number for a name": ({3: 1.0}, "names of rows"),
    "a price that is a word": ({"position": "dear"}, "price"),
    "a truth value": (True, "price"),
    "an array": (np.ones(2), "price"),
}


@pytest.mark.parametrize(("price", "words"), WRONG.values(), ids=WRONG)
def test_a_wrong_price_is_refused(price, words):
    with pytest.raises(sr.InputError, match=words) as caught:
        sr.LeastError(price=price)
    assert "price" in str(caught.value)


def test_what_only_the_task_shows_to_be_wrong_is_refused_there():
    j, x, bounds = np.eye(6, 7), np.ones(6), sr.Bounds.symmetric(1.0, n=7)
    with pytest.raises(sr.InputError, match="length"):
        sr.LeastError(price=(80.0, 8.0)).solve(j, x, bounds)
    with pytest.raises(sr.InputError, match="length"):
        sr.LeastError(price=(80.0, 8.0)).solve(j, x, bounds, length=0.0)
    with pytest.raises(sr.InputError, match="no price for the row wz"):
        sr.LeastError(price={"position": 80.0, "wx wy": 8.0}).solve(j, x, bounds, length=1.0)
    with pytest.raises(sr.InputError, match="no price for the row w"):  # of kinds, not of names
        sr.LeastError(price={"position": 80.0, "wx wy": 8.0, "wz": 1.0}).solve(
            j[:4], x[:4], bounds, row_kinds="vvvw", length=1.0
        )
    coupled = sr.Weights(task=np.eye(6) + 0.1)
    with pytest.raises(sr.InputError, match=r"weights\.task"):
        sr.LeastError(price=(80.0, 8.0), weights=coupled).solve(j, x, bounds, length=1.0)
    assert np.all(np.isfinite(sr.LeastError(weights=coupled).solve(j, x, bounds).rates))
