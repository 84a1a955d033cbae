"""Simulation: a Scenario in, a Run out."""

from stillreach.simulation.comparison import Comparison as Comparison
from stillreach.simulation.comparison import compare
from stillreach.simulation.motion import ConstantTwist, Wait
from stillreach.simulation.pose_table import PoseTable
from stillreach.simulation.run import Run
from stillreach.simulation.scenario import Scenario
from stillreach.simulation.scenario_file import scenario_names, scenario_schema
from stillreach.simulation.shapes import Circle, Line, Waypoints
from stillreach.simulation.simulator import simulate
from stillreach.simulation.summary import Summary as Summary

__all__ = [
    "Circle",
    "ConstantTwist",
    "Line",
    "PoseTable",
    "Run",
    "Scenario",
    "Wait",
    "Waypoints",
    "compare",
    "scenario_names",
    "scenario_schema",
    "simulate",
]
