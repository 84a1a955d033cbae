"""Names and descriptions of the built-in scenarios, without imports to run them."""

from __future__ import annotations

import tomllib
from importlib import resources

from stillreach.cli._complete import scenario_names


def ready_scenarios() -> list[dict[str, str]]:
    """Name, title and description of each ready scenario."""
    folder = resources.files("stillreach") / "scenarios"
    found = []
    for name in scenario_names():
        content = tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))
        text = " ".join(str(content.get("description", "")).split())
        found.append({"name": name, "title": str(content.get("name", name)), "text": text})
    return found
