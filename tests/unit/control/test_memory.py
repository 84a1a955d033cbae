"""A controller goes on from an earlier state of its own."""

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError

PANDA = sr.arms.panda()
BENT = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
TWIST = [0.05, 0.1, -0.05, 0.1, 0.0, 0.0]


def ticks(ctl, q, count):
    found = []
    for _ in range(count):
        q = q + 0.01 * ctl.step(q, TWIST).rates
        found.append(q)
    return np.array(found)


def test_what_follows_a_memory_is_the_same_again_whatever_happened_since():
    settings = {"period": 0.01, "null_motion": sr.null_motions.Centring(), "acceleration_limits": 5.0}
    ctl = sr.Controller(PANDA, **settings)
    ctl.fail(2)
    q = ticks(ctl, BENT, 7)[-1]
    memory = ctl.memory()
    expected = ticks(ctl, q, 20)
    ctl.fail(5, sr.Derated(0.2))
    ctl.restore(2)
    ticks(ctl, q + 0.1, 9)
    ctl.recall(memory)
    assert ctl.faults == {"panda_joint3": sr.Locked()}
    np.testing.assert_array_equal(ticks(ctl, q, 20), expected)
    other = sr.Controller(PANDA, **settings)
    other.step(BENT, np.zeros(6))
    other.recall(memory)
    np.testing.assert_array_equal(ticks(other, q, 20), expected)


def test_mistakes_change_nothing():
    ctl = sr.Controller(PANDA)
    ctl.fail(1)
    before = ctl.memory()
    with pytest.raises(InputError, match=r"memory: got 3, expected what memory\(\)"):
        ctl.recall(3)
    with pytest.raises(InputError, match=r"memory: got \d+ bytes, expected \d+ bytes, of a controller of 7 joints"):
        ctl.recall(sr.Controller(sr.arms.nasa_modular()).memory())
    assert ctl.memory() == before
