"""docs/scenarios.md: its files load and run, and it names every key that a file may have."""

from pathlib import Path

import numpy as np
import pytest

import stillreach as sr
from tests.docs.pages import ROOT, blocks

TEXT = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
FILES = [block.code for block in blocks(TEXT, "toml")]


def loaded(text: str, folder: Path) -> sr.Scenario:
    file = folder / "example.toml"
    file.write_text(text, encoding="utf-8")
    return sr.Scenario.load(file)


def test_the_example_runs_and_its_tool_ends_where_its_motions_lead(tmp_path: Path) -> None:
    scenario = loaded(FILES[0], tmp_path)
    run = sr.simulate(scenario)
    moved = (run.pose[-1, :3, 3] - run.pose[0, :3, 3]) / 0.0254
    np.testing.assert_allclose(moved, [0, 0, 0], atol=0.01)  # out by 20 in, once round, and back
    out = (run.pose[400, :3, 3] - run.pose[0, :3, 3]) / 0.0254
    np.testing.assert_allclose(out, [-20, 0, 0], atol=0.01)


def test_the_other_file_loads_or_says_which_package_it_lacks(tmp_path: Path) -> None:
    assert len(FILES) == 2
    try:
        assert loaded(FILES[1], tmp_path).arm.n == 7
    except sr.errors.ScenarioFileError as error:
        lacking = str(error)
    else:
        return
    assert "pip install --no-deps example-robot-data" in lacking


def test_the_page_names_every_key_and_every_choice() -> None:
    schema = sr.scenario_schema()
    words = set()
    for table in (schema, *schema["definitions"].values()):
        for key, entry in table["properties"].items():
            words.add(key)
            words |= {str(word) for word in [*entry.get("enum", ()), *filter(None, [entry.get("const")])]}
    assert len(words) > 90
    assert sorted(word for word in words if f"`{word}`" not in TEXT and f'"{word}"' not in TEXT) == []


@pytest.mark.parametrize("limit", ["64 KiB", "200 joints", "2000 waypoints", "8 GiB"])
def test_the_page_says_the_limits(limit: str) -> None:
    assert limit in TEXT
