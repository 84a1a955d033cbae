"""The paper's arm straight up, where its Jacobian has rank 3, and a hair beside it."""

from dataclasses import replace

import numpy as np
import pytest

import stillreach as sr
from oracles.kinematics import paper_arm
from stillreach import Status
from stillreach.paper import examples
from tests.conformance.registry import LAWS

ARM = sr.arms.nasa_modular()
SIGNS = np.where(np.arange(11) % 2 == 0, 1.0, -1.0)
INWARD = np.array([0.0, 0.0, -0.127, 0.0, 0.0, 0.0])
FAILURES = {"all free": (), "2, 4, 7 failed": (1, 3, 6)}
LIMIT = np.deg2rad(50.0)
UNASKED = ("damping 0.01",)
"""A number above 0 needs no rank, and does not look for it."""


def null_space_of_rows(J):
    """(6, lost) orthonormal, by way of the eigenvectors of J J'."""
    values, vectors = np.linalg.eigh(J @ J.T)
    return vectors[:, values < 1e-12 * values[-1]]


@pytest.mark.parametrize("failed", FAILURES.values(), ids=FAILURES)
@pytest.mark.parametrize("law", LAWS)
def test_what_the_straight_arm_lost_is_told(law, failed):
    q = np.zeros(11)
    J = ARM.jacobian(q)
    lost = null_space_of_rows(J)
    assert lost.shape == (6, 3)
    assert np.allclose(J, paper_arm(q)[2], atol=1e-14)
    answer = LAWS[law].make().solve(J, INWARD, sr.Bounds.symmetric(LIMIT, n=11).lock(failed), length=1.0)
    told = answer.lost_directions()
    assert told.shape == (6, 3)
    assert np.allclose(told.T @ told, np.eye(3), atol=1e-12)
    assert np.allclose(told @ told.T, lost @ lost.T, atol=1e-12)
    assert np.all(np.abs(answer.rates) <= LIMIT)
    assert Status.SINGULAR in answer.status or law in UNASKED


@pytest.mark.parametrize("failed", FAILURES.values(), ids=FAILURES)
@pytest.mark.parametrize("angle", [1e-3, -1e-3])
def test_beside_a_singularity_no_joint_runs_for_nothing(failed, angle, capsys):
    largest, along = {}, {}
    for name, law in {"priced": sr.LeastError(), "bare": sr.LeastError(price=None)}.items():
        controller = sr.Controller(ARM, law=law, velocity_limits=LIMIT)
        for joint in failed:
            controller.fail(joint)
        answer = controller.step(angle * SIGNS, INWARD)
        largest[name] = np.max(np.abs(answer.rates))
        along[name] = -(INWARD - answer.residual)[2] / 0.127
    with capsys.disabled():
        moved = ", ".join(f"{name} {largest[name]:.4f} rad/s for {100 * along[name]:.2f} %" for name in largest)
        print(f"\n  straight arm, {len(failed)} failed, pushed inward: {moved}")
    assert largest["priced"] <= 0.1 * LIMIT
    assert largest["bare"] > 0.99 * LIMIT
    assert along["bare"] < 0.03


def test_the_free_run_of_example_2_is_worth_its_rates():
    """With all joints free it is done exactly: the price is never reached, and the answer is the bare optimum's."""
    scenario = examples.scenarios()[examples.EXAMPLE_2_FREE]
    runs = [
        sr.simulate(replace(scenario, law=sr.LeastError(price=price), velocity_limits=LIMIT), progress=False)
        for price in (80.0, None)
    ]
    assert np.max(np.abs(runs[0].rates)) > 0.01
    assert np.max(np.abs(runs[0].rates - runs[1].rates)) <= 1e-9
    assert not np.any(runs[0].damping)
