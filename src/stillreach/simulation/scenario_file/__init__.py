"""Scenario files: a Scenario written in TOML, and everything that is wrong with it said at once."""

from stillreach.simulation.scenario_file.load import load, scenario_names, scenario_schema

__all__ = ["load", "scenario_names", "scenario_schema"]
