"""Each claim is a function of the saved runs: change the run that it is about, and it stands otherwise."""

import dataclasses
import shutil

import numpy as np
import pytest

import stillreach as sr
from stillreach.paper import claims, evidence, examples

FREE_1, FAILED_1 = examples.EXAMPLE_1_FREE, examples.EXAMPLE_1_FAILED
FREE_2, UNLIMITED, CLOSED, EXACT = (
    examples.EXAMPLE_2_FREE,
    examples.EXAMPLE_2_PSEUDOINVERSE,
    examples.EXAMPLE_2_CLOSED_FORM,
    examples.EXAMPLE_2_EXACT,
)
FINISHED = examples.EXAMPLE_2_STILLREACH


def moved(k, inches, ticks=slice(None)):
    """The tool shifted along an axis."""

    def spoil(run):
        pose = run.pose.copy()
        pose[ticks, k, 3] += inches * 0.0254
        return dataclasses.replace(run, pose=pose)

    return spoil


def turned(run):
    """The last attitude turned by a degree about z."""
    pose = run.pose.copy()
    c, s = np.cos(np.deg2rad(1)), np.sin(np.deg2rad(1))
    pose[-1, :3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ pose[-1, :3, :3]
    return dataclasses.replace(run, pose=pose)


def scaled(name, factor):
    """An array times a factor."""
    return lambda run: dataclasses.replace(run, **{name: factor * getattr(run, name)})


def replaced(name, tick, joint, value):
    """One entry of an array."""

    def spoil(run):
        array = getattr(run, name).copy()
        array[tick, joint] = value
        return dataclasses.replace(run, **{name: array})

    return spoil


def clipped(limit):
    """No rate above a limit [deg/s]."""
    return lambda run: dataclasses.replace(run, rates=np.clip(run.rates, -np.deg2rad(limit), np.deg2rad(limit)))


def straightened(part):
    """The tool's way off its start in y and z, times a factor."""

    def change(run):
        pose = run.pose.copy()
        pose[:, 1:3, 3] = pose[0, 1:3, 3] + part * (pose[:, 1:3, 3] - pose[0, 1:3, 3])
        return dataclasses.replace(run, pose=pose)

    return change


def damped_from(tick):
    """The damping factor is above 0 from a tick on."""
    return lambda run: dataclasses.replace(run, damping=np.where(np.arange(len(run)) < tick, 0.0, 1e-3))


def least_error(run):
    """Nothing was damped, and nothing more could be saved: no working joint is left."""
    return dataclasses.replace(run, health=np.ones_like(run.health))


R, NOT, REFUTED, OURS = "reproduced", "not reproduced", "refuted", "ours"
CHANGED = {
    "example-1-same-trajectory": (R, [(FAILED_1, moved(2, 2.0)), (FAILED_1, moved(0, -2.0, 17))]),
    "example-1-failed-joints": (R, [(FAILED_1, replaced("q", 100, 5, 0.7)), (FAILED_1, replaced("q", -1, 0, 0.7))]),
    "example-2-free-rate": (R, [(FREE_2, scaled("rates", 1.3))]),
    "feasible-needs-no-damping": (R, [(name, damped_from(399)) for name in (FREE_1, FAILED_1, FREE_2)]),
    "example-2-robust-rate": (R, [(CLOSED, replaced("rates", 100, 4, np.deg2rad(50.1)))]),
    "example-2-robust-deviation": (R, [(CLOSED, turned), (CLOSED, straightened(0.0)), (CLOSED, moved(1, 0.2, -1))]),
    "example-2-robust-halfway": (R, [(CLOSED, moved(0, -20.0, -1)), (CLOSED, moved(0, 20.0, -1))]),
    "example-2-robust-activated": (R, [(CLOSED, damped_from(tick)) for tick in (20, 60, 401)]),
    "example-2-pseudoinverse-rate": (NOT, [(UNLIMITED, clipped(400.0))]),
    "example-2-pseudoinverse-deviation": (NOT, [(UNLIMITED, straightened(0.1))]),
    "deviation-not-minimal": (REFUTED, [(FAILED_1, least_error)]),
    "euler-difference": (OURS, [(FAILED_1, moved(2, 1.0))]),
    "closed-form-conservative": (OURS, [(EXACT, scaled("damping", 100.0))]),
    "stillreach-finishes": (OURS, [(FINISHED, moved(1, 0.4, 700)), (FINISHED, moved(0, 0.4, -1))]),
    "rate-limit": (OURS, [(FREE_2, replaced("rates", 50, 2, np.deg2rad(51.0)))]),
    "failed-joints-at-rest": (OURS, [(EXACT, replaced("rates", 50, 3, 1e-300)), (EXACT, replaced("q", 9, 6, 1e-9))]),
}
"""How each claim stands, and changes of a run with which it stands otherwise."""


def claims_of(of):
    return {claim.id: claim for claim in claims.judged(of)}


def test_every_claim_has_a_run_that_changes_it(saved):
    assert set(CHANGED) == set(claims_of(saved))


@pytest.mark.parametrize("name", CHANGED)
def test_a_claim_stands_otherwise_with_another_run(saved, name):
    group, changes = CHANGED[name]
    before = claims_of(saved)[name]
    assert (before.group, before.as_documented) == (group, True)
    assert before.holds == (group in (R, OURS))
    for run_name, change in changes:
        run = change(saved[run_name])
        by_step = {key: dict(runs) for key, runs in saved.by_step.items()}
        if run_name in by_step:
            by_step[run_name][0.05] = run
        changed = dataclasses.replace(saved, runs={**saved.runs, run_name: run}, by_step=by_step)
        after = claims_of(changed)[name]
        assert (after.holds, after.as_documented) == (not before.holds, False)
        assert after.group == (OURS if group == OURS else NOT if group == R else R)


def test_only_statements_of_the_paper_are_reproduced_or_not(saved):
    for claim in claims_of(saved).values():
        assert (claim.paper == "-") == (claim.group == OURS)


def test_what_is_judged_is_what_the_files_hold(reproduction, tmp_path):
    folder = shutil.copytree(reproduction.folder, tmp_path / "paper")
    path = folder / "example-2-free.nc"
    scaled("rates", 1.3)(sr.Run.load(path)).save(path)
    spoiled = claims_of(evidence.load(folder, step=0.05))
    assert [name for name, claim in spoiled.items() if not claim.as_documented] == ["example-2-free-rate"]
