"""`stillreach view`: a page with the live arm."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stillreach.cli import _options as option
from stillreach.cli._complete import complete_view

if TYPE_CHECKING:
    from stillreach.page import Page

PAGE = "view.html"
RUNS = (".nc", ".npz")


@option.of_recording
def view(
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="WHAT...",
            help="An arm by name, a robot file, a scenario, one or more runs (run.nc), or with --robot a recording.",
            autocompletion=complete_view,
        ),
    ],
    robot: option.RecordedRobot = None,
    *,
    options: option.Recording,
    law: option.Law = None,
    fail: option.Fail = None,
    out: option.Out = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Write the page, and do not open it.")] = False,
) -> None:
    """Make a page in which a click breaks a joint.

    Writes view.html, one file that runs the controller and needs neither network nor server, and opens it. Of an arm
    it moves the tool as you like; of a scenario or a recording it plays the motion and the faults; runs are replayed,
    two or more side by side, and go on live from any moment.
    """
    from stillreach.cli._records import folder_for
    from stillreach.cli._terminal import console, note

    page = _page(what, robot, options, law, fail or [])
    path = folder_for(out, what[0]) / PAGE
    if no_browser:
        page.save(path)
    opened = no_browser or page.open(path)
    console().print(f"wrote {path}", soft_wrap=True)
    if not opened:
        note("stillreach: no browser found; open the file in one")


def _page(what: list[str], robot: str | None, options: option.Recording, law: str | None, fail: list[str]) -> Page:
    """The page of whatever was named.

    Raises:
        InputError: if it is unknown, or an option does not go with it.
    """
    from stillreach.cli._complete import scenario_names
    from stillreach.cli._faults import changed
    from stillreach.cli._recordings import refuse, scenario_or_recording
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
        chain = set() if runs else {"tip", "base"}
        given = {name: value for name, value in options.given().items() if name not in chain}
        refuse({"law": law, "fail": fail or None, **given}, "a scenario, or a recording with --robot")
        if runs:
            return run_page(*map(Run.load, what))
        return arm_page(load_arm(first, tip=options.tip, base=options.base, fixed={}))
    scenario, file = (None, first) if recording else (first, None)
    given_task, _ = scenario_or_recording(scenario, file, robot, options)
    return scenario_page(changed(given_task, law=law, fail=fail, healthy=False, known_after=None))
