"""Shell completion. It runs on every Tab: only laws need NumPy."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import resources
from pathlib import Path

from stillreach._formats import FORMATS
from stillreach.arms import BUILDERS
from stillreach.cli._laws import law_texts

SIZED_EXAMPLES = {"planar": "planar7", "snake": "snake30"}


def complete_robot(incomplete: str) -> list[str]:
    """Built-in arms and robot files."""
    names = [SIZED_EXAMPLES.get(name, name) for name in BUILDERS]
    return [*_starting(names, incomplete), *_files(incomplete, [f.suffix for f in FORMATS.values()])]


def complete_scenario(incomplete: str) -> list[str]:
    """Ready scenarios and scenario files."""
    return [*_starting(scenario_names(), incomplete), *_files(incomplete, ("toml",))]


def complete_view(incomplete: str) -> list[str]:
    """Everything that `stillreach view` shows."""
    return [*complete_robot(incomplete), *complete_scenario(incomplete), *_files(incomplete, ("nc", "npz"))]


def complete_law(incomplete: str) -> list[str]:
    """Laws and, after a colon, their settings."""
    laws, variants = law_texts()
    return _starting(laws + variants * (":" in incomplete), incomplete)


def complete_laws(incomplete: str) -> list[str]:
    """Laws, after those before the last comma."""
    before, comma, last = incomplete.rpartition(",")
    return [before + comma + law for law in complete_law(last) if law not in before.split(",")]


def scenario_names() -> list[str]:
    """Names of the ready scenarios, in order."""
    folder = resources.files("stillreach") / "scenarios"
    if not folder.is_dir():
        return []
    return sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))


def _starting(names: Iterable[str], incomplete: str) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]


def _files(incomplete: str, kinds: Iterable[str]) -> list[str]:
    """Files of these kinds and folders with this prefix, folders with a slash."""
    head, slash, start = incomplete.rpartition("/")
    folder = Path(head + slash or ".")
    try:
        entries = sorted(folder.iterdir())
    except OSError:
        return []
    found = []
    for entry in entries:
        hidden = entry.name.startswith(".") and not start.startswith(".")
        if entry.name.startswith(start) and not hidden:
            if entry.is_dir():
                found.append(f"{head}{slash}{entry.name}/")
            elif entry.suffix[1:] in kinds:
                found.append(f"{head}{slash}{entry.name}")
    return found
