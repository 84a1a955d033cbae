"""Scenario files that the tests write."""

PLANAR = """
start = [0, 0.5, 1]

[robot]
arm = "planar"
n = 3

[[motion]]
kind = "twist"
twist = [0.1, 0, 0, 0, 0, 0]
duration = 1
"""
"""The least that a file can say."""


def planar(*, top="", tables=""):
    """PLANAR with more keys at its top and more tables at its end."""
    return f"{top}\n{PLANAR}\n{tables}\n"


EIGHT_MISTAKES = """\
name = "eight mistakes"
start = [0, 0.5, 1, 2]
period = "0.01"
lopp = "closed"

[units]
angle = "degrees"

[robot]
arm = "planar"
n = 3

[[motion]]
kind = "line"
to = [1, 0, nan]
duration = 5

[law]
kind = "least error"

[[faults]]
joint = "j22"
kind = "locked"
at = 1

[[faults]]
joint = "j2"
kind = "derated"
fraction = 1.5
"""
EIGHT = [
    # line, place, what came, what was expected, hint
    (2, "start", "4 entries", "3, one for each joint of planar3", ""),
    (3, "period", "'0.01'", "a number", "a number has no quotes"),
    (4, "lopp", "unknown key 'lopp'", "loop", "did you mean 'loop'?"),
    (7, "units.angle", "'degrees'", "one of 'rad', 'deg'", "did you mean 'deg'?"),
    (15, "motion[0].to[2]", "nan", "a finite number", ""),
    (19, "law.kind", "'least error'", "'least-error'", "did you mean 'least-error'?"),
    (22, "faults[0].joint", "'j22'", "a joint of planar3: j1, j2, j3", "did you mean 'j2'?"),
    (29, "faults[1].fraction", "1.5", "a number from 0 to 1", ""),
]
