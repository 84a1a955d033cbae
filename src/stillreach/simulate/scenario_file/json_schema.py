"""The form of scenario files as a JSON schema, for editors."""

from __future__ import annotations

from typing import Any

from stillreach.simulate.scenario_file.schema import ScenarioTable

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def schema() -> dict[str, Any]:
    """The schema of the whole file."""
    return {"$schema": DIALECT, **ScenarioTable.model_json_schema(), "title": "stillreach scenario"}
