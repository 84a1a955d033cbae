"""Where an arm can still go if a joint locks on a task: a survey of the configurations along it."""

from __future__ import annotations

import os

import numpy as np

from stillreach import _door
from stillreach.errors import InputError
from stillreach.simulation import simulate
from stillreach.task import Task
from stillreach.tolerance.rehearsal import Rehearsal
from stillreach.tolerance.survey import Survey, survey
from stillreach.tolerance.surveys.positions import region_of

METRICS = ("relative", "depth", "reach", "positions")


def survey_along(
    rehearsal: Rehearsal,
    out: str | os.PathLike[str],
    *,
    count: int = 1000,
    k: int = 1,
    seed: int = 1994,
    threads: int | None = None,
    progress: bool | None = None,
) -> Survey:
    """Where the arm can still go after each loss, with joints locked where they stand at moments of a task.

    The configurations are those of the task without the rehearsed failures, at evenly spaced moments. The poses to be
    reached are those of random configurations within the position limits. Faults of the scenario itself do not count.

    Args:
        rehearsal: of the task.
        out: the folder to write, as for ``survey``.
        count: how many moments.
        k: the largest number of joints that fail together.
        seed: of the random poses.
        threads: how many; None: as for ``solve_batch``.
        progress: show a bar; None: on a terminal, after one second.

    Returns:
        The survey, with positions where the task has them; also as ``rehearsal.survey``.

    Raises:
        InputError: if an argument is invalid, or the folder is that of something else.
        MissingExtraError: if Zarr is not installed (extra ``survey``).
    """
    if not isinstance(rehearsal, Rehearsal):
        raise InputError("rehearsal", _door.describe(rehearsal), "a Rehearsal")
    moments = _door.count("count", count)
    scenario = rehearsal.scenario
    run = simulate(scenario, progress=False)
    task = scenario.task if scenario.task is not None else Task()
    times = np.linspace(0.0, float(run.time[-1]), moments)
    found = survey(
        scenario.arm,
        out,
        q=np.column_stack([np.interp(times, run.time, values) for values in run.q.T]),
        k=k,
        metrics=[word for word in METRICS if word != "positions" or _has_positions(rehearsal, task)],
        task=task,
        seed=seed,
        threads=threads,
        progress=progress,
    )
    rehearsal.survey = found
    return found


def _has_positions(rehearsal: Rehearsal, task: Task) -> bool:
    try:
        region_of(rehearsal.scenario.arm, task)
    except InputError:
        return False
    return True
