"""The form of scenario files as a JSON schema, for editors.

Draft 7, because editors of TOML know no later one. There a reference hides what stands beside it, so that a reference
with a description goes into an ``allOf``.
"""

from __future__ import annotations

from typing import Any

from stillreach.simulation.scenario_file.schema import ScenarioTable

DIALECT = "http://json-schema.org/draft-07/schema#"
NULL = {"type": "null"}


def schema() -> dict[str, Any]:
    """The schema of the whole file."""
    tidy = _tidied(ScenarioTable.model_json_schema(ref_template="#/definitions/{model}"))
    return {"$schema": DIALECT, "title": "stillreach scenario", **tidy}


def _tidied(node: Any) -> Any:
    """Without what TOML does not know (null) and what says nothing (titles that repeat the key)."""
    if isinstance(node, list):
        return [_tidied(entry) for entry in node]
    if not isinstance(node, dict):
        return node
    tidy: dict[str, Any] = {}
    for key, value in node.items():
        if key in ("properties", "$defs"):
            tidy[key.replace("$defs", "definitions")] = {name: _tidied(entry) for name, entry in value.items()}
        elif key == "anyOf" and NULL in value:
            others = [_tidied(entry) for entry in value if entry != NULL]
            tidy |= others[0] if len(others) == 1 else {"anyOf": others}
        elif key != "title" and not (key == "default" and value is None):
            tidy[key] = _tidied(value)
    if "$ref" in tidy and len(tidy) > 1:
        tidy = {"allOf": [{"$ref": tidy.pop("$ref")}], **tidy}
    return tidy
