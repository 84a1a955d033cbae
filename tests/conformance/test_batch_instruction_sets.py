"""Batches with other instruction sets.

The same bits as one row at a time there; the same bits with AVX2 and with AVX-512; the same answers without either.
"""

import functools
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
from stillreach import _core
from tests.conformance.batches import ANSWERS, Rows, ask_alone, ask_batch, differences, mixed_rows
from tests.conformance.registry import LAWS

ROOT = Path(__file__).parents[2]
ARM = sr.arms.nasa_modular()
ALIKE = 4000
MIXED = 150
OTHER_SET = """
import pickle, sys
from tests.conformance import test_batch_instruction_sets as here
pickle.dump(here.report(), open(sys.argv[1], "wb"))
"""


def ordinary_rows(count):
    """Places all over, 0 to 5 joints locked, about half of the rows over the limit, a few nearly singular."""
    rng = np.random.default_rng(1)
    q = rng.uniform(-np.pi, np.pi, (count, 11))
    near = rng.random(count) < 0.1
    q[near, 1::2] *= 10.0 ** rng.uniform(-3, -1, (np.count_nonzero(near), 1))
    upper = np.full((count, 11), np.deg2rad(50))
    upper[rng.permuted(np.tile(np.arange(11), (count, 1)), axis=1) < rng.integers(0, 6, (count, 1))] = 0.0
    return Rows(q, rng.normal(size=(count, 6)) * 10.0 ** rng.uniform(-1.5, 0.5, (count, 1)), -upper, upper)


def nudged(rows):
    """The same questions but for their last digits."""
    rng = np.random.default_rng(2)
    return Rows(rows.q, rows.twist * (1.0 + 1e-13 * rng.normal(size=rows.twist.shape)), rows.lower, rows.upper)


def ratio(J, chosen):
    """Largest over smallest singular value of the chosen columns, but for those that are 0."""
    sigma = np.linalg.svd(J * chosen[:, None, :], compute_uv=False)
    kept = sigma > 1e-10 * sigma[:, :1]
    return np.max(np.where(kept, sigma[:, :1] / np.where(kept, sigma, 1.0), 1.0), axis=1)


def report():
    """Of this process's instruction set: its name, what a batch does not share with single rows, and answers."""
    wrong, answers, mixed = {}, {}, mixed_rows(ARM, MIXED, seed=3)
    for name, contract in LAWS.items():
        law = contract.make()
        alone = ask_alone(law, ARM.jacobian(mixed.q), mixed.twist, mixed.bounds, length=ARM.reach)
        wrong[name] = differences(ask_batch(ARM, law, mixed), alone)[:3]
        batch = ask_batch(ARM, law, ordinary_rows(ALIKE))
        answers[name] = {key: getattr(batch, key) for key in ("rates", "status", *ANSWERS)}
    return {"set": _core.instruction_set(), "wrong": wrong, "answers": answers}


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """The report of a process that is told to use an instruction set."""

    @functools.cache
    def ask(instruction_set):
        file = tmp_path_factory.mktemp(instruction_set) / "report.pickle"
        paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
        environment = {**os.environ, "STILLREACH_INSTRUCTIONS": instruction_set, "PYTHONPATH": paths}
        command = [sys.executable, "-c", OTHER_SET, file]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return pickle.loads(file.read_bytes())

    return ask


@pytest.mark.parametrize("instruction_set", ["baseline", "avx2"])
def test_every_set_answers_each_row_as_alone(told, instruction_set):
    if _core.instruction_set() == "baseline" != instruction_set:
        pytest.skip("this machine has no AVX2")
    other = told(instruction_set)
    assert other["set"] == instruction_set
    assert {name: wrong for name, wrong in other["wrong"].items() if wrong} == {}


@pytest.mark.skipif(_core.instruction_set() != "avx512", reason="this machine has no AVX-512")
@pytest.mark.parametrize("law", LAWS)
def test_eight_lanes_give_the_bits_of_four(told, law):
    here, there = ask_batch(ARM, LAWS[law].make(), ordinary_rows(ALIKE)), told("avx2")["answers"][law]
    for key, values in there.items():
        np.testing.assert_array_equal(getattr(here, key), values, err_msg=key)


@pytest.mark.skipif(_core.instruction_set() == "baseline", reason="this machine has one instruction set")
@pytest.mark.parametrize("law", LAWS)
def test_the_baseline_agrees(told, law, capsys):
    """Rates to 1e-12 (σmax/σmin)² of the largest, statuses exactly, task errors to 1e-9.

    σ are those of the working joints or of those left free, whichever are worse. Left out are rows where the last
    digits of the question decide: a twist changed by 1e-13 changes the answer there, with one and the same instruction
    set. How many steps a search took is no part of the answer.
    """
    rows = ordinary_rows(ALIKE)
    here, there = ask_batch(ARM, LAWS[law].make(), rows), told("baseline")["answers"][law]
    near = ask_batch(ARM, LAWS[law].make(), nudged(rows))
    J = ARM.jacobian(rows.q)
    condition = np.maximum(ratio(J, rows.lower < rows.upper), ratio(J, here.active == 0))
    size = np.max(np.abs(here.rates), axis=1)
    reach = np.linalg.norm(rows.twist, axis=1)

    def alike(status, rates, task_error):
        gap = np.max(np.abs(rates - here.rates), axis=1)
        same = (status ^ here.status) & ~sr.Status.ITERATION_LIMIT == 0
        return same & (gap <= 1e-12 * condition**2 * size) & (np.abs(task_error - here.task_error) <= 1e-9 * reach)

    ties = ~alike(near.status, near.rates, near.task_error)
    wrong = ~ties & ~alike(there["status"], there["rates"], there["task_error"])
    with capsys.disabled():
        print(f"\n  {law}: {ALIKE} rows, {np.count_nonzero(ties)} ties, {np.count_nonzero(wrong)} differ")
    assert not np.any(wrong), np.flatnonzero(wrong)[:5]
    assert np.count_nonzero(ties) <= 0.02 * ALIKE
