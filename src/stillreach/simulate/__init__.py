"""Simulation: a Scenario in, a Run out."""

import sys
from types import ModuleType

from stillreach.simulate.motion import Twist
from stillreach.simulate.pose_table import PoseTable
from stillreach.simulate.run import Run
from stillreach.simulate.scenario import Scenario
from stillreach.simulate.scenario_file import scenario_names, scenario_schema
from stillreach.simulate.shapes import Circle, Line, Waypoints
from stillreach.simulate.simulate import simulate

__all__ = [
    "Circle",
    "Line",
    "PoseTable",
    "Run",
    "Scenario",
    "Twist",
    "Waypoints",
    "scenario_names",
    "scenario_schema",
    "simulate",
]


class _Package(ModuleType):
    """This package and the function ``stillreach.simulate`` share a name: a call of either simulates."""

    def __call__(self, scenario: Scenario, *, progress: bool | None = None) -> Run:
        return simulate(scenario, progress=progress)


sys.modules[__name__].__class__ = _Package
