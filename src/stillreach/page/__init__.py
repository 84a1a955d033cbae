"""A page that runs the controller: one HTML file that holds the robot, its task and the compiled core."""

from __future__ import annotations

import html
import os
import webbrowser
from collections.abc import Sequence
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
from stillreach.page.task import kinematics_of, task_of
from stillreach.simulation import Run, Scenario
from stillreach.simulation.motion import ConstantTwist

Noted = tuple[dict[str, Any], list[str]]
"""Data of a page, and notes for its reader."""
HEIGHT = 760
"""[px] in a notebook."""
SAMPLES, SEED = 500, 1994
PERIOD = 0.005
"""[s] of an arm without a scenario."""


@dataclass(frozen=True, repr=False)
class Page:
    """A page that a notebook shows.

    Args:
        html: the whole page; it needs no other file and no network.
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
    """The page of an arm, whose tool draws a circle.

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
    """The page of one or more runs of one arm: a replay that continues live from any moment.

    Raises:
        InputError: if a run has no ticks, or the arms differ.
    """
    for run in runs:
        if not len(run):
            raise InputError("run", "no ticks", "a run with at least one tick")
    scenarios = list(dict.fromkeys(run.scenario for run in runs))
    if any(kinematics_of(scenario) != kinematics_of(scenarios[0]) for scenario in scenarios):
        raise InputError("runs", "different arms or tools", "runs of one arm")
    replays = [
        replay_of(run, label, scenarios.index(run.scenario)) for run, label in zip(runs, _labels(runs), strict=True)
    ]
    return page_of(*scenarios, planned=True, replays=replays)


def _labels(runs: Sequence[Run]) -> list[str]:
    """What the page calls each run: its title; where titles are the same, a number and what differs."""
    titles = [run.scenario.title for run in runs]
    if len(set(titles)) == len(runs):
        return titles
    laws = [run.scenario.law.word if run.scenario.law else "" for run in runs]
    faults = [
        ", ".join(
            f"{run.joint_names[run.scenario.arm.joint_index(fault.joint)]} {fault.kind.word}"
            for fault in run.scenario.faults
        )
        or "no fault"
        for run in runs
    ]
    differ = [texts for texts in (laws, faults) if len(set(texts)) > 1] or [titles]
    return [f"{k}: {', '.join(texts)}" for k, texts in enumerate(zip(*differ, strict=True), 1)]


def page_of(*scenarios: Scenario, planned: bool, replays: Sequence[Noted] = ()) -> Page:
    """A page, from its parts."""
    parts = page_parts(*scenarios, planned=planned, replays=replays)
    template = Template(built("page.html"))
    title = html.escape(printable(scenarios[0].title))
    return Page(template.substitute(title=title, css=built("page.css"), **parts))


def page_parts(*scenarios: Scenario, planned: bool, replays: Sequence[Noted] = ()) -> dict[str, str]:
    """The data and the program of a page: ``document``, ``block``, ``core``, ``script``.

    Raises:
        PageNotBuiltError: if this installation was built without the page's program.
    """
    tasks = [task_of(scenario, planned=planned) for scenario in scenarios]
    notes = [note for _, own in (*tasks, *replays) for note in own]
    data = {
        "version": version("stillreach"),
        "tasks": [task for task, _ in tasks],
        "runs": [run for run, _ in replays],
        "notes": list(dict.fromkeys(notes)),
    }
    document, block = pack(data)
    return {"document": document, "block": block, "core": built("core.b64"), "script": built("page.js")}


def built(name: str) -> str:
    """A file of the page's program."""
    path = resources.files("stillreach.page") / "dist" / name
    if not path.is_file():
        raise PageNotBuiltError
    return path.read_text(encoding="utf-8")
