"""A hundredth of the ticks that `python tests/adversarial.py` drives."""

import numpy as np
import pytest

from stillreach import Status
from tests.adversarial import campaign, drive
from tests.conformance.attack import SEGMENT, attack, violations
from tests.conformance.registry import LAWS

TICKS = 10_000


@pytest.mark.parametrize("law", LAWS)
def test_hostile_ticks_break_no_promise(law, capsys):
    statuses, broken = campaign(law, TICKS, seed=0)
    with capsys.disabled():
        counts = ", ".join(f"{name} {count}" for name, count in statuses.items() if count)
        print(f"\n  {law}: {counts}", end="")
    assert not broken
    seen = {name for name, count in statuses.items() if count}
    assert {"SINGULAR", "NO_WORKING_JOINT", "INVALID_INPUT", "LIMIT_GIVEN_UP"} <= seen


@pytest.mark.parametrize(
    ("spoil", "name"),
    [
        (lambda rates: rates * np.nan, "not finite"),
        (lambda rates: rates + 1e-15, "failed joint off its rate"),
        (lambda rates: np.where(rates > 0.0, rates + 1e3, rates), "rate limit"),
        (lambda rates: np.where(np.arange(len(rates))[:, None] % 2 == 0, rates, 0.0), "acceleration limit"),
        (lambda rates: rates[::-1], "position limit"),
    ],
)
def test_a_broken_promise_is_seen(spoil, name):
    law, counts = LAWS["least error"].make(), 0
    for seed in range(20):
        told = attack(seed, 8 * SEGMENT)
        rates, status, _ = drive(told.controller(law), told)
        counts += violations(told, spoil(rates), status)[name]
    assert counts > 0


def test_a_status_that_is_not_told_is_seen():
    law, counts = LAWS["least error"].make(), {}
    for seed in range(20):
        told = attack(seed, 8 * SEGMENT)
        rates, status, _ = drive(told.controller(law), told)
        for spoiled in (np.zeros_like(status), np.full_like(status, Status.LIMIT_GIVEN_UP)):
            for name, count in violations(told, rates, spoiled).items():
                counts[name] = counts.get(name, 0) + count
    assert counts["bad input not told"] > 0
    assert counts["given up, not told"] > 0
    assert counts["told given up, was not"] > 0
