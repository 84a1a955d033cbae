"""What the paper states and what stillreach adds, each judged by a small function of the saved runs.

A statement of the paper is *reproduced* where the runs give the paper's value, else *not reproduced*, or *refuted*
where they show that it cannot be right. Statements about stillreach are *ours*. ``paper`` quotes the paper's text.
"""

from __future__ import annotations

import numpy as np

from stillreach.paper import examples, measure
from stillreach.paper.claim import Claim, Group, Measured, Verdict, as_json, claim, judged
from stillreach.paper.evidence import Evidence
from stillreach.paper.examples import RATE_LIMIT

__all__ = ["Claim", "Group", "Measured", "as_json", "judged"]

FASTER = 20.0
"""The command of example 1 is taken this many times as fast where limits must be active."""

SAME_PATH = 0.01
"""Two curves of a printed figure look identical up to this part of the commanded path, and 1 deg."""

SOMEWHAT = 0.1
"""A deviation is "somewhat" up to this part of the commanded path."""


@claim(
    "example-1-same-trajectory",
    Group.REPRODUCED,
    "Example 1: the tool moves with joints 1, 6, 7 failed as with all joints free (largest distance, angle)",
    "in, deg",
    paper="Figure 4 shows the end-effector trajectory which is identical to the all joints free case",
)
def _example_1_same_trajectory(of: Evidence) -> Verdict:
    free, failed = of[examples.EXAMPLE_1_FREE], of[examples.EXAMPLE_1_FAILED]
    distance, angle = measure.apart(free, failed)
    path = float(np.linalg.norm(measure.commanded_displacement(free)))
    return [distance, angle], distance <= SAME_PATH * path and angle <= 1.0


@claim(
    "example-1-failed-joints",
    Group.REPRODUCED,
    "Example 1: the failed joints do not move (largest change of an angle)",
    "deg",
    paper="joints 1,6, and 7 do not move as would be expected",
)
def _example_1_failed_joints(of: Evidence) -> Verdict:
    run = of[examples.EXAMPLE_1_FAILED]
    moved = float(np.rad2deg(np.max(np.ptp(run.q[:, [0, 5, 6]], axis=0))))
    return moved, moved == 0.0


@claim(
    "example-2-free-rate",
    Group.REPRODUCED,
    "Example 2, all joints free: the largest joint rate",
    "deg/s",
    paper="the maximum joint rate is less than 6 deg/sec",
)
def _example_2_free_rate(of: Evidence) -> Verdict:
    rate = measure.largest_rate(of[examples.EXAMPLE_2_FREE])
    return rate, rate < 6.0


@claim(
    "feasible-needs-no-damping",
    Group.REPRODUCED,
    "Where the pseudoinverse meets the limit (example 1, and example 2 with all joints free): the largest κ",
    "1",
    paper="scaling is not required and κ = 0",
)
def _feasible_needs_no_damping(of: Evidence) -> Verdict:
    names = (examples.EXAMPLE_1_FREE, examples.EXAMPLE_1_FAILED, examples.EXAMPLE_2_FREE)
    largest = max(float(np.max(of[name].damping)) for name in names)
    return largest, largest == 0.0


@claim(
    "example-2-pseudoinverse-rate",
    Group.NOT_REPRODUCED,
    "Example 2, joints 2, 4, 7 failed, pseudoinverse: the largest joint rate",
    "deg/s",
    paper="the very high joint rate solution (up to 400 deg/sec)",
)
def _example_2_pseudoinverse_rate(of: Evidence) -> Verdict:
    peak = measure.largest_rate(of[examples.EXAMPLE_2_PSEUDOINVERSE])
    return peak, 300.0 <= peak <= 500.0


@claim(
    "example-2-pseudoinverse-deviation",
    Group.NOT_REPRODUCED,
    "Example 2, joints 2, 4, 7 failed, pseudoinverse: largest distance of the tool from the commanded line",
    "in",
    paper="is seen to deviate somewhat from the desired trajectory",
)
def _example_2_pseudoinverse_deviation(of: Evidence) -> Verdict:
    run = of[examples.EXAMPLE_2_PSEUDOINVERSE]
    distance = measure.off_the_line(run)
    return distance, 0.0 < distance <= SOMEWHAT * float(np.linalg.norm(measure.commanded_displacement(run)))


@claim(
    "example-2-robust-rate",
    Group.REPRODUCED,
    "Example 2, failed, robust inverse: the largest joint rate, limit 50 deg/s",
    "deg/s",
    paper="the joint rate limit is not exceeded",
)
def _example_2_robust_rate(of: Evidence) -> Verdict:
    rate = measure.largest_rate(of[examples.EXAMPLE_2_CLOSED_FORM])
    return rate, rate <= RATE_LIMIT


@claim(
    "example-2-robust-deviation",
    Group.REPRODUCED,
    "Example 2, failed, robust inverse: deviation at the end in x, y, z, pitch, yaw, roll",
    "in, deg",
    paper="the deviation from the desired trajectory appears in the x and z-axes and pitch angle",
)
def _example_2_robust_deviation(of: Evidence) -> Verdict:
    x, y, z, pitch, yaw, roll = (float(value) for value in measure.deviation(of[examples.EXAMPLE_2_CLOSED_FORM]))
    nothing = max(abs(y), abs(yaw), abs(roll)) < 0.1
    return [x, y, z, pitch, yaw, roll], nothing and min(abs(x), abs(z), abs(pitch)) > 1.0


@claim(
    "example-2-robust-halfway",
    Group.REPRODUCED,
    "Example 2, failed, robust inverse: motion in x as a part of the commanded one",
    "%",
    paper="at the end of the simulation the manipulator has only moved halfway in the x-direction",
)
def _example_2_robust_halfway(of: Evidence) -> Verdict:
    run = of[examples.EXAMPLE_2_CLOSED_FORM]
    part = float(100.0 * measure.displacement(run)[0] / measure.commanded_displacement(run)[0])
    return part, 40.0 <= part <= 60.0


@claim(
    "example-2-robust-activated",
    Group.REPRODUCED,
    "Example 2, failed, robust inverse: when κ is first above 0",
    "s",
    paper="the SRI solution is activated at approximately 2 seconds",
)
def _example_2_robust_activated(of: Evidence) -> Verdict:
    when = measure.first_damped(of[examples.EXAMPLE_2_CLOSED_FORM])
    return when, 1.5 <= when <= 2.5


@claim(
    "deviation-not-minimal",
    Group.REFUTED,
    "The κ of eq. (10) minimises the deviation: by how much least squares inside the limits is below it "
    f"(∞-norm, median over example 1, {FASTER:g} times as fast)",
    "%",
    paper="a feasible solution which minimizes the deviation from the specified end-effector trajectory",
)
def _deviation_not_minimal(of: Evidence) -> Verdict:
    saved = measure.error_above_the_optimum(of[examples.EXAMPLE_1_FAILED], FASTER)
    median = 100.0 * float(np.median(saved)) if len(saved) else 0.0
    return median, median < 0.1


@claim(
    "euler-difference",
    Group.OURS,
    "The difference between the tools of example 1, free and failed, halves with the Euler step",
    "in",
)
def _euler_difference(of: Evidence) -> Verdict:
    free, failed = of.by_step[examples.EXAMPLE_1_FREE], of.by_step[examples.EXAMPLE_1_FAILED]
    distances = [measure.apart(free[step], failed[step])[0] for step in free]
    ratios = np.array(distances[:-1]) / distances[1:]
    return distances, bool(np.all(np.abs(ratios - 2.0) < 0.1))


@claim(
    "closed-form-conservative",
    Group.OURS,
    "Example 2, failed: the κ of eq. (16) is larger than the exact one of eq. (10) (ratio of the medians)",
    "1",
)
def _closed_form_conservative(of: Evidence) -> Verdict:
    closed_form = measure.median_damping(of[examples.EXAMPLE_2_CLOSED_FORM])
    ratio = closed_form / measure.median_damping(of[examples.EXAMPLE_2_EXACT])
    return ratio, ratio > 1.0


@claim(
    "stillreach-finishes",
    Group.OURS,
    "Example 2, failed, stillreach: the whole -100 in (motion in x), never more than 0.3 in and 0.1 deg off",
    "in, in, deg",
)
def _stillreach_finishes(of: Evidence) -> Verdict:
    run = of[examples.EXAMPLE_2_STILLREACH]
    distance, angle = (float(np.max(values)) for values in measure.off_target(run))
    along, commanded = float(measure.displacement(run)[0]), measure.commanded_displacement(run)[0]
    return [along, distance, angle], abs(along - commanded) < 0.3 and distance < 0.3 and angle < 0.1


@claim(
    "rate-limit",
    Group.OURS,
    "Every run but the pseudoinverse's without limit: all rates are inside their bounds at every tick (largest rate)",
    "deg/s",
)
def _rate_limit(of: Evidence) -> Verdict:
    bounded = [run for name, run in of.runs.items() if name not in examples.UNLIMITED]
    inside = all(bool(np.all((run.rates >= run.lower) & (run.rates <= run.upper))) for run in bounded)
    largest = max(measure.largest_rate(run) for run in bounded)
    return largest, inside and largest <= RATE_LIMIT * (1 + 1e-15)


@claim(
    "failed-joints-at-rest",
    Group.OURS,
    "Every run: failed joints have a rate of exactly 0 and do not move (largest rate or motion)",
    "rad/s, rad",
)
def _failed_joints_at_rest(of: Evidence) -> Verdict:
    rate, moved = 0.0, 0.0
    for name, run in of.runs.items():
        failed = [run.joint_names.index(joint) for joint in _failed(name)]
        if failed:
            rate = max(rate, float(np.max(np.abs(run.rates[:, failed]))))
            moved = max(moved, float(np.max(np.ptp(run.q[:, failed], axis=0))))
    return [rate, moved], rate == moved == 0.0


def _failed(name: str) -> tuple[str, ...]:
    if name == examples.EXAMPLE_1_FAILED:
        return examples.FAILED_1
    return examples.FAILED_2 if name.startswith("example-2-failed") else ()
