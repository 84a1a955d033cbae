"""What an arm can afford to lose."""

from stillreach.tolerance.reach import ReachLeft, reach

__all__ = ["ReachLeft", "reach"]
