"""Simulation: a Scenario in, a Run out."""

from stillreach.simulate.motion import Twist
from stillreach.simulate.run import Run
from stillreach.simulate.scenario import Scenario
from stillreach.simulate.simulate import simulate

__all__ = ["Run", "Scenario", "Twist", "simulate"]
