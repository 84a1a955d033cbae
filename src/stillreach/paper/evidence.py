"""The runs that the claims are judged by, as files in a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy.typing as npt

from stillreach.errors import InputError
from stillreach.paper import examples
from stillreach.paper.examples import scenarios
from stillreach.simulation import Run, Scenario, simulate

STEP_FACTORS = (4.0, 2.0, 0.5, 0.25)
"""Further steps, as multiples of the one asked for: what a value owes to the step shows in their spread."""

LEAST_STEPS = 20
"""Least number of steps in a run; the longest steps leave a quarter of them."""

STEP_DEPENDENT = (
    examples.EXAMPLE_1_FREE,
    examples.EXAMPLE_1_FAILED,
    examples.EXAMPLE_2_PSEUDOINVERSE,
    examples.EXAMPLE_2_CLOSED_FORM,
    examples.EXAMPLE_2_EXACT,
)
STEP_FOLDER = "by-step"


@dataclass(frozen=True)
class Evidence:
    """Saved runs, read back.

    Attributes:
        runs: by name, at the step asked for.
        by_step: by name and step [s], the one asked for included, longest first.
    """

    runs: Mapping[str, Run]
    by_step: Mapping[str, Mapping[float, Run]]

    def __getitem__(self, name: str) -> Run:
        return self.runs[name]


def make(
    out: Path, *, step: float, duration: float, lengths: npt.ArrayLike | None = None, on_run: Callable[[str], None]
) -> None:
    """Simulate every run and save it.

    Args:
        out: folder; made if it is not there.
        step: period of the Euler steps [s].
        duration: of each run [s].
        lengths: (6,) [m] segments of the arm; None takes the inferred ones.
        on_run: called with a run's name before it begins.

    Raises:
        InputError: step, duration or lengths is not what it should be, or the folder cannot be made.
    """
    wanted = scenarios(step=step, duration=duration, lengths=lengths)
    if step > duration / LEAST_STEPS:
        raise InputError("step", f"{step:g}", f"at most 1/{LEAST_STEPS} of the duration of {duration:g} s")
    try:
        (out / STEP_FOLDER).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError("out", repr(str(out)), f"a folder that can be written to ({error.strerror})") from error
    for name, scenario in wanted.items():
        on_run(name)
        _saved(scenario, out / f"{name}.nc")
    for factor in STEP_FACTORS:
        others = scenarios(step=factor * step, duration=duration, lengths=lengths)
        for name in STEP_DEPENDENT:
            on_run(f"{name}, step {factor * step:g} s")
            _saved(others[name], _step_file(out, name, factor * step))


def load(out: Path, *, step: float) -> Evidence:
    """Read back what ``make`` saved."""
    names = scenarios(step=step)
    runs = {name: Run.load(out / f"{name}.nc") for name in names}
    by_step = {}
    for name in STEP_DEPENDENT:
        others = {factor * step: Run.load(_step_file(out, name, factor * step)) for factor in STEP_FACTORS}
        by_step[name] = dict(sorted({**others, step: runs[name]}.items(), reverse=True))
    return Evidence(runs, by_step)


def _saved(scenario: Scenario, path: Path) -> None:
    simulate(scenario, progress=False).save(path)


def _step_file(out: Path, name: str, step: float) -> Path:
    return out / STEP_FOLDER / f"{name}-step-{step:g}.nc"
