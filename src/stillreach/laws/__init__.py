"""What to do this tick: one law a file, each a frozen set of settings for the compiled core."""

from stillreach.laws.keep_direction import KeepDirection
from stillreach.laws.law import Law
from stillreach.laws.least_error import LeastError
from stillreach.laws.pseudoinverse import Pseudoinverse
from stillreach.laws.singularity_robust import SingularityRobust

__all__ = ["KeepDirection", "Law", "LeastError", "Pseudoinverse", "SingularityRobust"]
