"""`stillreach arms`: the built-in arms and scenarios."""

from __future__ import annotations

import inspect
from typing import Any

from stillreach.cli import _options as option


def arms(as_json: option.Json = False) -> None:
    """List the built-in arms and the ready scenarios."""
    from stillreach.arms import BUILDERS
    from stillreach.cli._scenarios import ready_scenarios
    from stillreach.cli._terminal import console, print_json, print_table, table

    found, scenarios = [_arm(name) for name in BUILDERS], ready_scenarios()
    if as_json:
        print_json({"arms": found, "scenarios": scenarios})
        return
    out = console()
    made = table("arm", "joints", "reach", "", right=(1, 2), wrap=(3,))
    for arm in found:
        sized = "N" if arm["sized"] else ""
        reach = f"{'N × ' if sized else ''}{arm['reach']:.3g} m"
        text = f"{arm['text']}\n{arm['source']}" if arm["source"] else arm["text"]
        made.add_row(f"{arm['name']}{sized}", sized or str(arm["joints"]), reach, text)
    print_table(made)
    out.print("\nstillreach inspect ARM shows one of them, e.g. panda or planar3.\n")
    listed = table("ready scenario", "what happens", wrap=(1,))
    for scenario in scenarios:
        listed.add_row(scenario["name"], scenario["text"])
    print_table(listed)
    out.print("\nstillreach run SCENARIO runs one of them.")


def _arm(name: str) -> dict[str, Any]:
    """What a built-in arm is: for an arm of any number of joints, its reach is that of one joint."""
    from stillreach.arms import BUILDERS, SIZED, by_name

    builder = BUILDERS[name]
    arm = by_name(name, n=1 if name in SIZED else None)
    return {
        "name": name,
        "text": getattr(builder, "text", (inspect.getdoc(builder) or "").split("\n")[0]),
        "source": getattr(builder, "source", None),
        "tips": getattr(builder, "tips", ()),
        "joints": None if name in SIZED else arm.n,
        "reach": arm.reach,
        "sized": name in SIZED,
    }
