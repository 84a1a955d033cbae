"""What an arm can afford to lose."""

from stillreach.tolerance.along import survey_along
from stillreach.tolerance.cause import Cause
from stillreach.tolerance.postures import Posture, best_posture, better_place, better_start
from stillreach.tolerance.reach import ReachLeft, reach
from stillreach.tolerance.rehearsal import Rehearsal
from stillreach.tolerance.rehearse import rehearse
from stillreach.tolerance.report import Report, report
from stillreach.tolerance.survey import Survey, survey
from stillreach.tolerance.workspace import Workspace, best_limits, workspace

__all__ = [
    "Cause",
    "Posture",
    "ReachLeft",
    "Rehearsal",
    "Report",
    "Survey",
    "Workspace",
    "best_limits",
    "best_posture",
    "better_place",
    "better_start",
    "reach",
    "rehearse",
    "report",
    "survey",
    "survey_along",
    "workspace",
]
