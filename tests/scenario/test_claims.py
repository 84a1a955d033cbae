"""Each claim is a function of the saved runs: spoil the run that it is about, and it fails."""

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


def least_error(run):
    """Nothing was damped, and nothing more could be saved: no working joint is left."""
    return dataclasses.replace(run, health=np.ones_like(run.health))


SPOILED = {
    "example-1-start": (FREE_1, moved(0, 0.2, 0)),
    "example-1-end": (FREE_1, moved(1, -0.2, -1)),
    "example-1-free-rate": (FREE_1, scaled("rates", 1.02)),
    "example-1-failed-rate": (FAILED_1, scaled("rates", 0.98)),
    "example-1-same-path": (FAILED_1, moved(2, 1.0)),
    "example-1-no-damping": (FAILED_1, lambda run: dataclasses.replace(run, damping=run.damping + 1e-12)),
    "example-2-free-rate": (FREE_2, scaled("rates", 1.3)),
    "example-2-free-singular-value": (FREE_2, scaled("q", 0.0)),
    "example-2-pseudoinverse-passes-limit": (UNLIMITED, scaled("rates", 0.001)),
    "example-2-pseudoinverse-peak": (UNLIMITED, lambda run: dataclasses.replace(run, rates=np.clip(run.rates, -6, 6))),
    "example-2-pseudoinverse-leaves-line": (
        UNLIMITED,
        lambda run: dataclasses.replace(run, pose=np.broadcast_to(run.pose[0], run.pose.shape)),
    ),
    "example-2-closed-form-rate": (CLOSED, replaced("rates", 100, 4, np.deg2rad(50.1))),
    "example-2-closed-form-halfway": (CLOSED, moved(0, -20.0, -1)),
    "example-2-closed-form-deviation": (CLOSED, turned),
    "example-2-closed-form-damping": (CLOSED, scaled("damping", 1.2)),
    "example-2-closed-form-conservative": (EXACT, scaled("damping", 20.0)),
    "deviation-not-minimal": (FAILED_1, least_error),
    "stillreach-finishes": (FINISHED, moved(1, 0.4, 700)),
    "rate-limit": (FREE_2, replaced("rates", 50, 2, np.deg2rad(51.0))),
    "failed-joints-at-rest": (EXACT, replaced("rates", 50, 3, 1e-300)),
}


def holding(of):
    return {claim.id: claim.holds for claim in claims.judged(of)}


def test_every_claim_has_a_run_that_spoils_it(saved):
    assert set(SPOILED) == set(holding(saved))


@pytest.mark.parametrize("claim", SPOILED)
def test_a_claim_fails_when_its_run_is_spoiled(saved, claim):
    name, spoil = SPOILED[claim]
    run = spoil(saved[name])
    by_step = {key: dict(runs) for key, runs in saved.by_step.items()}
    if name in by_step:
        by_step[name][0.05] = run
    assert holding(saved)[claim]
    assert not holding(dataclasses.replace(saved, runs={**saved.runs, name: run}, by_step=by_step))[claim]


def test_what_is_judged_is_what_the_files_hold(reproduction, tmp_path):
    folder = shutil.copytree(reproduction.folder, tmp_path / "paper")
    path = folder / "example-2-free.nc"
    scaled("rates", 1.3)(sr.Run.load(path)).save(path)
    spoiled = holding(evidence.load(folder, step=0.05))
    assert [claim for claim, holds in spoiled.items() if not holds] == ["example-2-free-rate"]
