"""The stateful tick: faults, limits, null motions, transitions."""

from stillreach.control.controller import Controller
from stillreach.control.null_motion import Centring, Gradient, Manipulability, NullMotion, Posture, Rates

__all__ = ["Centring", "Controller", "Gradient", "Manipulability", "NullMotion", "Posture", "Rates"]
