"""Scenario files in TOML; all mistakes of a file are reported at once."""

from stillreach.simulation.scenario_file.load import load, scenario_names, scenario_schema

__all__ = ["load", "scenario_names", "scenario_schema"]
