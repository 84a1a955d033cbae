"""Scenarios by file or by name."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stillreach import _door
from stillreach._messages import hint, short
from stillreach.errors import InputError, Mistake, ScenarioFileError

if TYPE_CHECKING:
    from stillreach._reading import Reading
    from stillreach.simulation.scenario import Scenario
    from stillreach.simulation.scenario_file.document import Document

SUFFIX = ".toml"
DIALECT = "http://json-schema.org/draft-07/schema#"
"""Of the schema: editors of TOML know no later one."""


def load(path: str | os.PathLike[str]) -> Scenario:
    """A scenario from a file, or one that comes with the package.

    Args:
        path: a TOML file, or the name of a ready scenario (``scenario_names()``).

    Raises:
        ScenarioFileError: there is no such file, or something is wrong with it: ``mistakes`` holds everything.
    """
    from stillreach.simulation.scenario_file.document import read

    return scenario_of(read(*_found(path)))


def scenario_of(document: Document) -> Scenario:
    """The scenario that a file describes.

    Raises:
        ScenarioFileError: with everything that is wrong with its form, or else with what it means.
    """
    from stillreach._reading import WRONG, Reading
    from stillreach.simulation.scenario_file.tables import SCENARIO

    reading = Reading(document.folder, document.line, document.content)
    settings = SCENARIO.read(document.content, (), reading)
    scenario = None if settings is WRONG else _sensible(settings, reading)
    if scenario is None or reading.mistakes:
        raise ScenarioFileError(document.name, reading.mistakes)
    return scenario


def _sensible(settings: dict[str, Any], reading: Reading) -> Scenario | None:
    """The scenario with these arguments; None after recording what they cannot mean together."""
    from stillreach.simulation.plausible import goals_beyond_reach
    from stillreach.simulation.scenario import Scenario
    from stillreach.simulation.scenario_file.meaning import check

    check(settings, reading)
    if reading.mistakes:
        return None
    strict = not settings.pop("allow_outside", False)
    try:
        scenario = Scenario(**settings, allow_outside=True)
    except InputError as error:
        reading.refused((), error)
        return None
    for goal in goals_beyond_reach(scenario) if strict else []:
        reading.refused((), goal)
    return None if reading.mistakes else replace(scenario, allow_outside=not strict)


@cache
def scenario_names() -> tuple[str, ...]:
    """The names of the scenarios that come with the package, in order."""
    folder = _ready()
    return tuple(sorted(entry.name.removesuffix(SUFFIX) for entry in folder.iterdir() if entry.name.endswith(SUFFIX)))


def scenario_schema() -> dict[str, Any]:
    """The JSON schema of scenario files (draft 7), for editors."""
    from stillreach.simulation.scenario_file.tables import SCENARIO

    definitions: dict[str, Any] = {}
    whole = SCENARIO.definition(definitions)
    return {"$schema": DIALECT, "title": "stillreach scenario", "definitions": definitions, **whole}


def _ready() -> Path:
    return Path(str(resources.files("stillreach"))) / "scenarios"


def _found(path: str | os.PathLike[str]) -> tuple[Path, str]:
    """The file, and what messages call it."""
    if not isinstance(path, str | os.PathLike) or not isinstance(os.fspath(path), str):
        raise InputError("path", _door.describe(path), "the path of a scenario file, or the name of a ready scenario")
    name = os.fspath(path)
    if isinstance(path, str) and name in scenario_names() and (Path(name).is_dir() or not Path(name).exists()):
        return _ready() / f"{name}{SUFFIX}", name
    if isinstance(path, str) and "/" not in name and os.sep not in name and not name.endswith(SUFFIX):
        _refuse_unknown(name)
    return Path(name), name if len(name) < 1000 and name.isprintable() else repr(name[:1000])


def _refuse_unknown(name: str) -> None:
    """A word that is neither a file nor a ready scenario."""
    try:
        if Path(name).exists():
            return
    except (OSError, ValueError):
        pass
    expected = f"a scenario file, or one of {', '.join(scenario_names())}"
    near = hint(name, scenario_names())
    raise ScenarioFileError(short(name), [Mistake("", "no such file or ready scenario", expected, near)])
