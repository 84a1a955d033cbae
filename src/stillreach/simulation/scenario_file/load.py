"""Scenarios by file or by name."""

from __future__ import annotations

import os
from functools import cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stillreach import _door
from stillreach.errors import InputError, Mistake, ScenarioFileError

if TYPE_CHECKING:
    from stillreach.simulation.scenario import Scenario

SUFFIX = ".toml"


def load(path: str | os.PathLike[str]) -> Scenario:
    """A scenario from a file, or one that comes with the package.

    Args:
        path: a TOML file, or the name of a ready scenario (``scenario_names()``).

    Raises:
        ScenarioFileError: there is no such file, or something is wrong with it: ``mistakes`` holds everything.
    """
    from stillreach.simulation.scenario_file.build import scenario_of
    from stillreach.simulation.scenario_file.document import read

    return scenario_of(read(*_found(path)))


@cache
def scenario_names() -> tuple[str, ...]:
    """The names of the scenarios that come with the package, in order."""
    folder = _ready()
    return tuple(sorted(entry.name.removesuffix(SUFFIX) for entry in folder.iterdir() if entry.name.endswith(SUFFIX)))


def scenario_schema() -> dict[str, Any]:
    """The JSON schema of scenario files (draft 7), for editors."""
    from stillreach.simulation.scenario_file.json_schema import schema

    return schema()


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
    from stillreach.simulation.scenario_file.words import did_you_mean, short

    try:
        if Path(name).exists():
            return
    except (OSError, ValueError):
        pass
    expected = f"a scenario file, or one of {', '.join(scenario_names())}"
    hint = did_you_mean(name, scenario_names())
    raise ScenarioFileError(short(name), [Mistake("", "no such file or ready scenario", expected, hint)])
