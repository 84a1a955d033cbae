"""The paper's arm, its two examples and their variants as scenarios.

Start configurations, commands and failed joints are printed in its section 6. Segment lengths, duration and step are
not: see ``stillreach.paper.notes``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach.arm import Arm
from stillreach.arms import nasa_modular
from stillreach.errors import InputError
from stillreach.faults import Fault
from stillreach.laws import LeastError, Pseudoinverse, SingularityRobust
from stillreach.null_motions import Manipulability
from stillreach.simulation import ConstantTwist, Scenario
from stillreach.task import Task, Weights

INCH = 0.0254
RATE_LIMIT = 50.0
"""[deg/s]"""

INCHES_AND_DEGREES = Weights(length=INCH, angle=float(np.deg2rad(1.0)))
"""The paper's simulations measure inches and degrees; damping and task error are in those units."""

START_1 = (45.0, -60.0, 0.0, -45.0, 0.0, 45.0, 90.0, 45.0, 0.0, 0.0, 0.0)
"""Start of example 1 [deg]; the paper prints a twelfth entry, 0."""
COMMAND_1 = (-5.5, -2.5, 1.5)
"""Commanded velocity of the tool in example 1 [in/s], attitude kept."""
FAILED_1 = ("j1", "j6", "j7")

START_2 = (0.0, -50.0, 0.0, -30.0, 0.0, 70.0, 0.0, 30.0, 0.0, 0.0, 0.0)
"""Start of example 2 [deg]."""
COMMAND_2 = (-5.0, 0.0, 0.0)
"""Commanded velocity of the tool in example 2 [in/s], attitude kept."""
FAILED_2 = ("j2", "j4", "j7")

CLOSED_FORM = SingularityRobust(damping="closed-form", weights=INCHES_AND_DEGREES)
EXACT = SingularityRobust(damping="exact", weights=INCHES_AND_DEGREES)
BASELINE = Pseudoinverse(weights=INCHES_AND_DEGREES)

EXAMPLE_1_FREE = "example-1-free"
EXAMPLE_1_FAILED = "example-1-failed"
EXAMPLE_2_FREE = "example-2-free"
EXAMPLE_2_PSEUDOINVERSE = "example-2-failed-pseudoinverse"
EXAMPLE_2_CLOSED_FORM = "example-2-failed-closed-form"
EXAMPLE_2_EXACT = "example-2-failed-exact"
EXAMPLE_2_STILLREACH = "example-2-failed-stillreach"

TICKS_PER_STEP = 5
"""The closed loop of stillreach ticks so often in a step of the others: 100 Hz at the default step of 0.05 s."""

LONGEST = 1e6
"""[m] Reach of the longest arm that the figures can show."""

UNLIMITED = (EXAMPLE_2_PSEUDOINVERSE,)
"""Runs of the pseudoinverse without rate limits: the paper's baseline."""


def scenarios(
    *, step: float = 0.05, duration: float = 20.0, lengths: npt.ArrayLike | None = None
) -> dict[str, Scenario]:
    """Every run of the paper, by the name of its file.

    Args:
        step: period of the Euler steps [s].
        duration: time for which the paper's velocity is commanded [s].
        lengths: (6,) [m] segments of the arm; None takes the inferred ones.

    Raises:
        InputError: if an argument is invalid.
    """
    step, duration = _door.positive("step", step), _door.positive("duration", duration)
    arm = paper_arm(lengths)
    first = _scenario(arm, START_1, COMMAND_1, step, duration)
    second = _scenario(arm, START_2, COMMAND_2, step, duration)
    broken = replace(second, faults=_locked(FAILED_2))
    return {
        EXAMPLE_1_FREE: replace(first, name="Example 1, all joints free"),
        EXAMPLE_1_FAILED: replace(first, faults=_locked(FAILED_1), name="Example 1, joints 1, 6, 7 failed"),
        EXAMPLE_2_FREE: replace(second, name="Example 2, all joints free"),
        EXAMPLE_2_PSEUDOINVERSE: replace(
            broken,
            law=BASELINE,
            velocity_limits=np.inf,
            name="Example 2, joints 2, 4, 7 failed, pseudoinverse without rate limit",
        ),
        EXAMPLE_2_CLOSED_FORM: replace(broken, name="Example 2, joints 2, 4, 7 failed, closed-form damping"),
        EXAMPLE_2_EXACT: replace(broken, law=EXACT, name="Example 2, joints 2, 4, 7 failed, exact damping"),
        EXAMPLE_2_STILLREACH: replace(
            broken,
            law=LeastError(),
            task=Task(),
            period=step / TICKS_PER_STEP,
            loop="closed",
            track_gain=2.0,
            null_motion=Manipulability(gain=0.5, max_rate=10.0),
            name="Example 2, joints 2, 4, 7 failed, stillreach: least error, feedback, null motion on manipulability",
        ),
    }


def paper_arm(lengths: npt.ArrayLike | None = None) -> Arm:
    """The paper's arm; ``lengths`` (6,) [m] of its segments, None takes the inferred 30 in each."""
    arm = nasa_modular() if lengths is None else nasa_modular(lengths)
    if not arm.reach <= LONGEST:
        raise InputError("lengths", f"an arm of {arm.reach:g} m", f"an arm of at most {LONGEST:g} m")
    return arm


def _scenario(arm: Arm, start: Any, command: Sequence[float], step: float, duration: float) -> Scenario:
    """An example with all joints free; by eq. (9) the law is the pseudoinverse wherever that meets the limit."""
    return Scenario(
        arm=arm,
        start=np.deg2rad(start),
        motion=ConstantTwist(np.concatenate([np.array(command) * INCH, np.zeros(3)])),
        law=CLOSED_FORM,
        task=Task(weights=INCHES_AND_DEGREES),
        period=step,
        duration=duration,
        velocity_limits=np.deg2rad(RATE_LIMIT),
        transition_rate=0.0,
    )


def _locked(joints: Sequence[str]) -> tuple[Fault, ...]:
    return tuple(Fault(joint) for joint in joints)
