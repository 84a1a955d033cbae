"""`stillreach arms`: the arms and the scenarios that come with the package."""

from __future__ import annotations

from typing import Annotated, Any

import typer


def arms(as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False) -> None:
    """List the built-in arms and the ready scenarios."""
    from stillreach.cli._robots import BUILT_IN
    from stillreach.cli._scenarios import ready_scenarios
    from stillreach.cli._terminal import console, print_json, print_table, table

    scenarios = ready_scenarios()
    if as_json:
        print_json({"arms": [_arm(arm.name, arm.text, arm.sized) for arm in BUILT_IN], "scenarios": scenarios})
        return
    out = console()
    made = table("arm", "joints", "reach", "", right=(1, 2), wrap=(3,))
    for arm in BUILT_IN:
        facts = _arm(arm.name, arm.text, arm.sized)
        name = f"{arm.name}N" if arm.sized else arm.name
        reach = f"{facts['reach']:.3g} m" if facts["reach"] else "N × 0.1 m" if arm.name == "snake" else "N m"
        made.add_row(name, str(facts["joints"] or "N"), reach, arm.text)
    print_table(made)
    out.print("\nstillreach inspect ARM shows one of them.\n")
    listed = table("ready scenario", "what happens", wrap=(1,))
    for scenario in scenarios:
        listed.add_row(scenario["name"], scenario["text"])
    print_table(listed)
    out.print("\nstillreach run SCENARIO runs one of them.")


def _arm(name: str, text: str, sized: bool) -> dict[str, Any]:
    """Name, description, joints and reach of a built-in arm; no number where the name takes one."""
    from stillreach.cli._robots import built_in

    arm = None if sized else built_in(name)
    return {"name": name, "text": text, "joints": arm and arm.n, "reach": arm and arm.reach, "sized": sized}
