"""What to do this tick: one law a file, each a frozen set of settings for the compiled core; ``LAWS``, all of them."""

from stillreach.laws.keep_direction import KeepDirection
from stillreach.laws.law import Law
from stillreach.laws.least_error import LeastError
from stillreach.laws.pseudoinverse import Pseudoinverse
from stillreach.laws.singularity_robust import SingularityRobust

LAWS: tuple[type[Law], ...] = (LeastError, KeepDirection, SingularityRobust, Pseudoinverse)
"""Every law, the default first."""

__all__ = ["KeepDirection", "Law", "LeastError", "Pseudoinverse", "SingularityRobust"]
