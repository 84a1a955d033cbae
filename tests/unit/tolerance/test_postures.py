"""Postures that can afford to lose a joint."""

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError

PANDA = sr.arms.panda()
NASA = sr.arms.nasa_modular()
BENT = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
LEANING = np.deg2rad([0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0])


def worst(arm, q, task=None):
    return sr.tolerance.report(arm, q, k=1, task=task).worst()[1]


def worst_of_each(arm, q):
    """(N,) the same of many, from singular vectors."""
    rows = np.linalg.svd(arm.jacobian(q), full_matrices=False)[2]
    return np.sqrt(np.maximum(1.0 - np.sum(rows**2, axis=1), 0.0)).min(axis=1)


@pytest.mark.parametrize(("arm", "poses"), [(PANDA, 20), (NASA, 20)], ids=["panda", "11 joints"])
def test_the_best_posture_beats_its_start_and_every_random_one(arm, poses):
    """Of 200 configurations of the same pose that another seed finds."""
    rng = np.random.default_rng(3)
    lower, upper = np.clip(arm.position_limits, -2.5, 2.5).T
    for _ in range(poses):
        q = rng.uniform(lower, upper)
        pose = arm.forward(q)
        found = sr.tolerance.best_posture(arm, pose, q)
        np.testing.assert_allclose(arm.forward(found.q), pose, atol=2e-9)
        assert np.all((found.q >= arm.position_limits[:, 0]) & (found.q <= arm.position_limits[:, 1]))
        assert found.before == pytest.approx(worst(arm, q))
        assert found.worst == pytest.approx(worst(arm, found.q))
        assert found.worst >= found.before
        others = arm.inverse(pose, q, solutions=200, starts=800, seed=99)
        assert found.worst >= worst_of_each(arm, others.q[: int(others.found)]).max() - 1e-9


def slowest(arm, q):
    return float(np.min(sr.tolerance.report(arm, q, k=1).speeds[0]))


@pytest.mark.parametrize(
    ("climb", "left"),
    [
        (sr.null_motions.Tolerance(failures=2), lambda arm, q: sr.tolerance.report(arm, q, k=2).worst(2)[1]),
        (sr.null_motions.GuaranteedSpeed(gain=0.1, max_rate=0.3), slowest),
    ],
    ids=["pairs", "speed"],
)
def test_it_climbs_what_is_asked_for(climb, left):
    """Of 100 other configurations of the pose, none leaves more."""
    arm, q = NASA, LEANING + 0.2
    found = sr.tolerance.best_posture(arm, arm.forward(q), q, climb=climb)
    assert found.before == pytest.approx(left(arm, q))
    assert found.worst == pytest.approx(left(arm, found.q))
    assert len(found.joints) == (2 if left is not slowest else 1)
    others = arm.inverse(arm.forward(q), q, solutions=100, starts=400, seed=99)
    assert found.worst >= max(left(arm, other) for other in others.q[: int(others.found)])


def test_a_task_of_fewer_rows():
    task = sr.Task(rows="position")
    found = sr.tolerance.best_posture(PANDA, PANDA.forward(BENT), BENT, task=task)
    np.testing.assert_allclose(PANDA.forward(found.q)[:3, 3], PANDA.forward(BENT)[:3, 3], atol=2e-9)
    assert found.worst > worst(PANDA, BENT, task)


def test_mistakes_of_a_posture():
    with pytest.raises(InputError, match="start: got a configuration that does not have the pose"):
        sr.tolerance.best_posture(PANDA, PANDA.forward(BENT), BENT + 0.1)
    with pytest.raises(InputError, match="arm: got 3"):
        sr.tolerance.best_posture(3, np.eye(4), BENT)
    with pytest.raises(InputError, match="climb: got 3, expected a Tolerance or a GuaranteedSpeed"):
        sr.tolerance.best_posture(PANDA, PANDA.forward(BENT), BENT, climb=3)
    with pytest.raises(InputError, match="pose: got"):
        sr.tolerance.best_posture(PANDA, np.ones((4, 4)), BENT)
    found = sr.tolerance.rehearse(task(PANDA, BENT, sr.Line([0, 0.1, 0], duration=1.0, relative=True)), onsets=3)
    with pytest.raises(InputError, match="count: got 0"):
        sr.tolerance.better_start(found, count=0)


def task(arm, start, motion, **settings):
    return sr.Scenario(arm=arm, start=start, motion=motion, loop="closed", period=0.02, **settings)


TASKS = {
    "Panda, circle": task(PANDA, BENT, sr.Circle(centre=[0, 0.12, 0], axis=[1, 0, 0], duration=5.0, relative=True)),
    "Panda, line": task(PANDA, BENT, sr.Line([0.12, -0.2, 0.15], duration=4.0, relative=True)),
    "Panda, swing": sr.Recording(
        PANDA,
        np.linspace(0, 4, 81),
        BENT + 0.25 * np.sin(np.outer(np.linspace(0, 4, 81), [0.5, 0.7, 0.3, 0.6, 0.4, 0.8, 0.2])),
    ).scenario(period=0.02),
    "xArm7, line": task(
        sr.arms.xarm7(),
        np.deg2rad([10, -20, 10, 60, 10, 70, 10]),
        sr.Line([0.0, 0.25, -0.1], duration=4.0, relative=True),
    ),
    "11 joints, circle": task(
        NASA, LEANING, sr.Circle(centre=[0, 0.4, 0], axis=[1, 0, 0], duration=8.0, relative=True)
    ),
}


def test_a_better_start_survives_more_on_at_least_four_of_five_tasks():
    better = 0
    for scenario in TASKS.values():
        found = sr.tolerance.rehearse(scenario, kinds=["locked", "confined"], onsets=10, known_after=0.04)
        other = sr.tolerance.better_start(found, count=14)
        if other is None:
            assert found.better is None
            assert found.advice == ""
            continue
        better += 1
        assert other is found.better
        assert other.share > found.share
        assert other.healthy_survives
        assert "% survive instead of" in found.advice
        assert found.advice in str(found)
        again = sr.tolerance.rehearse(
            other.scenario,
            kinds=["locked", "confined"],
            onsets=10,
            known_after=0.04,
            allowed_distance=found.limits[0],
            allowed_angle=found.limits[1],
        )
        np.testing.assert_array_equal(again.cause, other.cause)
        start, own = other.scenario.start, scenario.start
        arm = scenario.arm
        np.testing.assert_allclose(arm.forward(start), arm.forward(own), atol=2e-9)
    assert better >= 4


def test_a_task_is_moved_to_a_better_place():
    arm = PANDA
    scenario = task(arm, BENT, sr.Line([0.12, -0.2, 0.15], duration=3.0, relative=True))
    found = sr.tolerance.rehearse(scenario, kinds=["locked"], onsets=10)
    moved = sr.tolerance.better_place(found)
    assert moved is not None
    assert moved is found.moved
    assert moved.share > found.share
    step = arm.forward(moved.scenario.start)[:3, 3] - arm.forward(BENT)[:3, 3]
    np.testing.assert_allclose(step, found.shift, atol=2e-9)
    assert np.linalg.norm(found.shift) == pytest.approx(0.1)
    run, there = sr.simulate(scenario), sr.simulate(moved.scenario)
    np.testing.assert_allclose(there.target[:, :3, 3], run.target[:, :3, 3] + found.shift, atol=2e-9)
    assert "With the task moved by (" in found.advice
    far = sr.tolerance.rehearse(scenario, kinds=["locked"], onsets=3)
    assert sr.tolerance.better_place(far, [[9.0, 0.0, 0.0]]) is None
    with pytest.raises(InputError, match="shifts: got"):
        sr.tolerance.better_place(found, [1.0])
