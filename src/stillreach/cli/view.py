"""`stillreach view`: a page with the live arm."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stillreach.cli._chain import BaseOption, TipOption
from stillreach.cli._complete import complete_law, complete_view
from stillreach.cli._recordings import (
    AngleOption,
    EpisodeOption,
    PeriodOption,
    RobotOption,
    TopicOption,
)

if TYPE_CHECKING:
    from stillreach.page import Page

PAGE = "view.html"
RUNS = (".nc", ".npz")


def view(
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="WHAT...",
            help="An arm by name, a robot file, a scenario, one or more runs (run.nc), or with --robot a recording.",
            autocompletion=complete_view,
        ),
    ],
    robot: RobotOption = None,
    tip: TipOption = None,
    base: BaseOption = None,
    angle: AngleOption = None,
    topic: TopicOption = None,
    episode: EpisodeOption = None,
    period: PeriodOption = None,
    law: Annotated[str | None, typer.Option(help="Law instead of a scenario's.", autocompletion=complete_law)] = None,
    fail: Annotated[
        list[str] | None,
        typer.Option(metavar="JOINT[@S][:KIND]", help="One more fault of a scenario or recording, as of run."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Output folder; by default out/NAME.")] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Write the page, and do not open it.")] = False,
) -> None:
    """Make a page in which a click breaks a joint.

    Writes view.html, one file that runs the controller and needs neither network nor server, and opens it. Of an arm
    it moves the tool as you like; of a scenario or a recording it plays the motion and the faults; runs are replayed,
    two or more side by side, and go on live from any moment.
    """
    from stillreach.cli._records import folder_for
    from stillreach.cli._terminal import console, note

    options = {"angle": angle, "topic": topic, "episode": episode, "period": period}
    page = _page(what, robot, tip, base, law, fail or [], options)
    path = folder_for(out, what[0]) / PAGE
    if no_browser:
        page.save(path)
    opened = no_browser or page.open(path)
    console().print(f"wrote {path}", soft_wrap=True)
    if not opened:
        note("stillreach: no browser found; open the file in one")


def _page(
    what: list[str],
    robot: str | None,
    tip: str | None,
    base: str | None,
    law: str | None,
    fail: list[str],
    options: dict[str, Any],
) -> Page:
    """The page of whatever was named.

    Raises:
        InputError: if it is unknown, or an option does not go with it.
    """
    from stillreach.cli._complete import scenario_names
    from stillreach.cli._faults import changed
    from stillreach.cli._recordings import scenario_or_recording
    from stillreach.cli._robots import load_arm
    from stillreach.errors import InputError
    from stillreach.page import arm_page, run_page, scenario_page
    from stillreach.simulation import Run

    first, recording = what[0], robot is not None
    runs = not recording and all(Path(name).suffix.lower() in RUNS for name in what)
    if len(what) > 1 and not runs:
        raise InputError("WHAT", f"{len(what)} things", "one, or several runs (run.nc)")
    task = recording or (not runs and (first in scenario_names() or Path(first).suffix.lower() == ".toml"))
    if not task:
        given = {"law": law, "fail": fail or None, **options}
        if runs:
            given |= {"tip": tip, "base": base}
        for name, value in given.items():
            if value is not None:
                raise InputError(f"--{name}", repr(value), "a scenario, or a recording with --robot")
        if runs:
            return run_page(*map(Run.load, what))
        return arm_page(load_arm(first, tip=tip, base=base, fixed={}))
    scenario, file = (None, first) if recording else (first, None)
    given_task, _ = scenario_or_recording(scenario, file, robot, tip, base, **options)
    return scenario_page(changed(given_task, law=law, fail=fail, healthy=False, known_after=None))
