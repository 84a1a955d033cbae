"""A page that runs the controller: one HTML file that holds the robot, its task and the compiled core."""

from __future__ import annotations

import html
import os
import webbrowser
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from importlib.metadata import version
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._files import new_file
from stillreach._text import printable
from stillreach.arm import Arm
from stillreach.arm.limits import sampling_range
from stillreach.errors import InputError, PageNotBuiltError
from stillreach.page.pack import pack
from stillreach.page.replay import replay_of
from stillreach.page.task import task_of
from stillreach.simulation import Run, Scenario
from stillreach.simulation.motion import ConstantTwist

BUILT = ("page.html", "page.css", "page.js", "core.b64")
HEIGHT = 760
"""[px] in a notebook."""
SAMPLES, SEED = 500, 1994
PERIOD = 0.005
"""[s] of an arm without a scenario."""


@dataclass(frozen=True, repr=False)
class Page:
    """A page as text. A notebook shows it.

    Args:
        html: all of it; it needs no other file and no network.
    """

    html: str

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file, e.g. ``"arm.html"``; an existing one is replaced."""
        with new_file(Path(path)) as file:
            file.write(self.html.encode())

    def open(self, path: str | os.PathLike[str]) -> bool:
        """Write the page to a file and show it in the browser; False if there is none."""
        self.save(path)
        return webbrowser.open(Path(path).resolve().as_uri())

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" style="width:100%;height:{HEIGHT}px;border:0" '
            'sandbox="allow-scripts"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<Page of {len(self.html.encode()) / 1e6:.2g} MB>"


def arm_page(arm: Arm, q: Any = None) -> Page:
    """The page of an arm: it holds its tool still until it is told otherwise.

    Args:
        arm: the arm.
        q: (n,) [rad, m] where it starts, or by joint name; None: a configuration far from singularities and limits.
    """
    start = _roomy(arm) if q is None else _door.vector("q", q, arm.n, labels=arm.labels)
    scenario = Scenario(
        arm=arm,
        start=start,
        motion=ConstantTwist([0.0] * 6),
        duration=PERIOD,
        period=PERIOD,
        loop="closed",
        track_gain=5.0,
        name=arm.name,
    )
    return page_of(scenario, planned=False)


def _roomy(arm: Arm) -> FloatArray:
    """(n,) [rad, m] a configuration of a sample with much manipulability and room to all limits."""
    low, high = sampling_range(arm.kinds, *arm.position_limits.T)
    share = np.random.default_rng(SEED).uniform(0.15, 0.85, (SAMPLES, arm.n))
    q = low + share * (high - low)
    room = np.sum(np.log(4.0 * share * (1.0 - share)) * np.all(np.isfinite(arm.position_limits), axis=1), axis=1)
    return np.asarray(q[np.argmax(np.sum(np.log(arm.singular_values(q) + 1e-9), axis=1) + room)])


def scenario_page(scenario: Scenario) -> Page:
    """The page of a scenario: it plays its motion and its faults."""
    return page_of(scenario, planned=True)


def run_page(*runs: Run) -> Page:
    """The page of one run or several of one arm: it replays them, and goes on from any moment.

    Raises:
        InputError: if a run has no ticks, or the arms differ.
    """
    for run in runs:
        if not len(run):
            raise InputError("run", "no ticks", "a run with at least one tick")
        if run.joint_names != runs[0].joint_names:
            raise InputError("runs", "different arms", "runs of one arm")
    titles = [run.scenario.title for run in runs]
    labels = [title if titles.count(title) == 1 else f"{title} ({k + 1})" for k, title in enumerate(titles)]
    replays = [replay_of(run, label) for run, label in zip(runs, labels, strict=True)]
    return page_of(runs[0].scenario, planned=True, replays=replays)


def page_of(scenario: Scenario, *, planned: bool, replays: Sequence[tuple[dict[str, Any], list[str]]] = ()) -> Page:
    """A page, from its parts."""
    parts = page_parts(scenario, planned=planned, replays=replays)
    files = {name: built(name) for name in BUILT}
    return Page(
        Template(files["page.html"]).substitute(
            title=html.escape(printable(scenario.title)),
            css=files["page.css"],
            **parts,
        )
    )


def page_parts(
    scenario: Scenario,
    *,
    planned: bool,
    replays: Sequence[tuple[dict[str, Any], list[str]]] = (),
    more: Mapping[str, Any] | None = None,
) -> dict[str, str]:
    """The data and the program of a page: ``document``, ``block``, ``core``, ``script``.

    Raises:
        PageNotBuiltError: if the page's program was not built with this installation.
    """
    task, notes = task_of(scenario, planned=planned)
    document, block = pack(
        {
            "version": version("stillreach"),
            "task": task,
            "runs": [run for run, _ in replays],
            "notes": notes + [note for _, own in replays for note in own],
            **(more or {}),
        }
    )
    return {"document": document, "block": block, "core": built("core.b64"), "script": built("page.js")}


def built(name: str) -> str:
    """A file of the page's program."""
    path = resources.files("stillreach.page") / "dist" / name
    if not path.is_file():
        raise PageNotBuiltError
    return path.read_text(encoding="utf-8")
