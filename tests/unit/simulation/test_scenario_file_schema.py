"""The JSON schema of scenario files, for editors."""

import json
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft7Validator

import stillreach as sr
from tests.unit.simulation.scenario_texts import EIGHT_MISTAKES, PLANAR, planar

FOLDER = Path(sr.__file__).parent / "scenarios"


@pytest.fixture(scope="module")
def validator():
    schema = json.loads(json.dumps(sr.scenario_schema()))
    Draft7Validator.check_schema(schema)
    return Draft7Validator(schema)


def fits(validator, text):
    return validator.is_valid(tomllib.loads(text))


@pytest.mark.parametrize("name", sr.scenario_names())
def test_every_ready_scenario_fits(validator, name):
    assert fits(validator, (FOLDER / f"{name}.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    "text",
    [
        "",
        EIGHT_MISTAKES,
        PLANAR.replace("n = 3", "n = 3.5"),
        PLANAR.replace('arm = "planar"', 'arm = "planer"'),
        planar(top="lopp = 1"),
        planar(top="velocity_limits = -1"),
        planar(tables='[[faults]]\njoint = "j1"\nkind = "lost"'),
        planar(tables='[[faults]]\njoint = "j1"\nkind = "locked"\nrate = 1'),
        planar(tables='[[motion]]\nkind = "line"\nto = [1, 2]\nduration = 1'),
        planar(tables='[law]\nkind = "least-error"\nprice = "no"'),
        planar(tables='[law]\nkind = "least-error"\nprice = { tilt = 8 }'),
        planar(tables='[law]\nkind = "least-error"\nprice = { position = 0 }'),
        planar(tables='[law]\nkind = "least-error"\nprice = {}'),
        planar(tables='[law]\nkind = "least-error"\nprice = { vx = 4, vy = 3, vz = 2, wx = 1 }'),
    ],
)
def test_what_has_another_form_does_not_fit(validator, text):
    assert fits(validator, PLANAR)
    assert not fits(validator, text)


@pytest.mark.parametrize(
    "price",
    [
        "80",
        '"none"',
        '"position-first"',
        "{ position = 100, orientation = 8 }",
        '{ position = 9, "wx  wy" = 8, wz = 1 }',
    ],
)
def test_every_form_of_a_price_fits(validator, price):
    assert fits(validator, planar(tables=f'[law]\nkind = "least-error"\nprice = {price}'))


def test_every_key_has_its_meaning_and_its_unit(validator):
    schema = validator.schema
    tables = [schema, *schema["definitions"].values()]
    keys = [(name, entry) for table in tables for name, entry in table["properties"].items()]
    assert len(keys) > 80
    assert [name for name, entry in keys if name != "kind" and not entry.get("description")] == []
    assert all(table.get("description") for table in tables)
    assert "[s]" in schema["properties"]["period"]["description"]
    assert "[angle" in schema["properties"]["velocity_limits"]["description"]
    assert '"null"' not in json.dumps(schema)
