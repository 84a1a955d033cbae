"""What an arm can afford to lose."""

from stillreach.tolerance.cause import Cause
from stillreach.tolerance.postures import Posture, best_posture, better_place, better_start
from stillreach.tolerance.reach import ReachLeft, reach
from stillreach.tolerance.rehearsal import Rehearsal
from stillreach.tolerance.rehearse import rehearse
from stillreach.tolerance.report import Report, report

__all__ = [
    "Cause",
    "Posture",
    "ReachLeft",
    "Rehearsal",
    "Report",
    "best_posture",
    "better_place",
    "better_start",
    "reach",
    "rehearse",
    "report",
]
