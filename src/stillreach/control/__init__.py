"""The stateful tick: faults, limits, null motions, transitions."""

from stillreach.control.controller import Controller

__all__ = ["Controller"]
