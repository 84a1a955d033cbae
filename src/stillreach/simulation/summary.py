"""Summary of a run: whether the tool arrived and why not, deviations, rates and limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._words import aligned
from stillreach.arm.dexterity import directions, full_rates, least_speeds
from stillreach.simulation.account import account
from stillreach.simulation.commanded import beside_path, commanded_in, deviation, off_goal
from stillreach.simulation.held import held_back, rate_shares
from stillreach.simulation.why import Why, why_missed
from stillreach.status import Status

if TYPE_CHECKING:
    from stillreach.simulation.run import Run

POSITION_SHARE, ANGLE_SHARE = 0.01, 0.01
"""A tool has arrived within this distance of its goal, relative to the whole path and turn,"""
POSITION_FLOOR, ANGLE_FLOOR = 1e-3, np.deg2rad(1.0)
"""or within these: [m] and [rad]."""


@dataclass(frozen=True)
class Peak:
    """The largest value of a quantity and its time [s]."""

    value: float
    time: float


@dataclass(frozen=True)
class Unnoticed:
    """A fault, or a restoration, that the controller learned of later.

    Args:
        joint: name.
        what: the fault in words; None: it was restored.
        since, until: [s] when it happened, and when the controller knew or the run ended.
        noticed: whether it knew.
        distance, angle: [m, rad] from the tool to its target at ``until``, in the rows of the task.
        distance_before, angle_before: [m, rad] the same at ``since``.
    """

    joint: str
    what: str | None
    since: float
    until: float
    noticed: bool
    distance: float
    angle: float
    distance_before: float
    angle_before: float


@dataclass(frozen=True)
class Summary:
    """The main numbers of a run; ``str()`` returns them in words.

    Args:
        run: the run.
        finished: the run is complete and the tool ends at its goal: neither distance is above the allowed one.
        end: [s] time of the last tick.
        linear, angular: whether the task has rows in [m/s], in [rad/s]; missing parts are 0.
        goal_distance, goal_angle: from the tool to its goal at the end [m, rad], in the rows of the task.
        allowed_distance, allowed_angle: largest of these that count as arrived [m, rad].
        way, turn: length and angle of the commanded motion [m, rad].
        distance, angle: largest distance and angle from the target [m, rad], at the same time, or path time for a
            clock that follows the arm.
        gave_way: parts of the task, "position" and "orientation", with errors above the allowed ones.
        unnoticed: faults and restorations that the controller did not know of at once.
        beside: largest distance from the commanded path [m], at any time.
        task_error: largest weighted norm of the residual twist.
        rate: the largest rate as a fraction of its joint's limit, after derating; None if no joint has a limit.
        rate_joint: name of its joint.
        rate_value: [rad/s, m/s] the rate.
        statuses: share of the ticks for each status flag that was raised, 0 to 1, OK included.
        held: [s] for each working joint that was at a limit, the time at each limit.
        singular_values: of the working joints' weighted Jacobian at the end, descending.
        lost: (lost, rows) unit twists [m, rad] in which rates inside their limits give less than 1 mm/s or 0.1 deg/s
            at the end.
        why: why the tool did not arrive; None if it did, or if Ctrl-C ended the run.
    """

    run: Run = field(repr=False)
    finished: bool
    end: float
    linear: bool
    angular: bool
    goal_distance: float
    goal_angle: float
    allowed_distance: float
    allowed_angle: float
    way: float
    turn: float
    distance: Peak
    angle: Peak
    gave_way: tuple[str, ...]
    unnoticed: tuple[Unnoticed, ...]
    beside: float
    task_error: Peak
    rate: Peak | None
    rate_joint: str
    rate_value: float
    statuses: dict[str, float]
    held: dict[str, dict[str, float]]
    singular_values: FloatArray
    lost: FloatArray
    why: Why | None

    def __str__(self) -> str:
        return f"{self.run.scenario.title}\n{aligned(account(self))}"

    @property
    def longest(self) -> tuple[str, str, float] | None:
        """Joint, limit and time [s] of the joint that was longest at one limit; None if no joint was at one."""
        spans = [(time, joint, bound) for joint, found in self.held.items() for bound, time in found.items()]
        if not spans:
            return None
        time, joint, bound = max(spans, key=lambda span: span[0])
        return joint, bound, time


def summary(run: Run, *, allowed_distance: float | None, allowed_angle: float | None) -> Summary:
    """The summary of a run of at least one tick; arguments as for ``Run.summary``."""
    rows, scenario = run.task.indices, run.scenario
    goal = commanded_in(run)
    way, turn = goal.length()
    shift, angle = deviation(run)
    near, turned = allowed_errors((way, turn), allowed_distance, allowed_angle)
    rate, joint, value = _largest_rate(run)
    sigma, lost = _left_at_end(run)
    ends = (float(shift[-1]), float(angle[-1])) if scenario.clock == "time" else off_goal(run, goal)
    whole = len(run) > scenario.steps
    finished = whole and ends[0] <= near and ends[1] <= turned
    return Summary(
        run=run,
        finished=finished,
        end=float(run.time[-1]),
        linear=min(rows) < 3,
        angular=max(rows) >= 3,
        goal_distance=ends[0],
        goal_angle=ends[1],
        allowed_distance=near,
        allowed_angle=turned,
        way=way,
        turn=turn,
        distance=_peak(run.time, shift),
        angle=_peak(run.time, angle),
        gave_way=("position",) * bool(np.max(shift) > near) + ("orientation",) * bool(np.max(angle) > turned),
        unnoticed=tuple(_unnoticed(run, shift, angle)),
        beside=beside_path(run, goal),
        task_error=_peak(run.time, run.task_error),
        rate=rate,
        rate_joint=joint,
        rate_value=value,
        statuses=status_shares(run),
        held=held_back(run),
        singular_values=sigma,
        lost=lost,
        why=why_missed(run) if whole and not finished else None,
    )


def allowed_errors(way: tuple[float, float], distance: float | None, angle: float | None) -> tuple[float, float]:
    """The largest distance [m] and angle [rad] from the target; None: a share of the path's length [m] and turn [rad].

    Raises:
        InputError: if one is negative.
    """
    near = max(POSITION_SHARE * way[0], POSITION_FLOOR)
    turned = max(ANGLE_SHARE * way[1], ANGLE_FLOOR)
    if distance is not None:
        near = _door.positive("allowed_distance", distance, or_zero=True, allow_inf=True)
    if angle is not None:
        turned = _door.positive("allowed_angle", angle, or_zero=True, allow_inf=True)
    return float(near), float(turned)


def _unnoticed(run: Run, shift: FloatArray, angle: FloatArray) -> Iterator[Unnoticed]:
    """What the controller learned later, by time."""
    scenario, last = run.scenario, len(run) - 1
    for fault in sorted(scenario.faults, key=lambda fault: fault.at):
        joint = scenario.arm.joint_index(fault.joint)
        what = fault.kind.sentence(slides=bool(scenario.arm.kinds[joint]))
        for at, words in ((fault.at, what), (fault.until, None)):
            if not fault.known_after or at is None or scenario.tick_at(at) > last:
                continue
            first, known = scenario.tick_at(at), scenario.tick_at(at + fault.known_after)
            end = min(known, last)
            yield Unnoticed(
                joint=run.joint_names[joint],
                what=words,
                since=float(run.time[first]),
                until=float(run.time[end]),
                noticed=known <= last,
                distance=float(shift[end]),
                angle=float(angle[end]),
                distance_before=float(shift[first]),
                angle_before=float(angle[first]),
            )


def status_shares(run: Run) -> dict[str, float]:
    """Share of the ticks for each status flag that was raised, 0 to 1, largest first; OK for ticks without flags."""
    shares = {str(flag.name): float(np.mean((run.status & flag.value) != 0)) for flag in Status if flag}
    shares["OK"] = float(np.mean(run.status == 0))
    return dict(sorted(((k, v) for k, v in shares.items() if v > 0.0), key=lambda pair: -pair[1]))


def _peak(time: FloatArray, values: FloatArray) -> Peak:
    place = int(np.argmax(values))
    return Peak(float(values[place]), float(time[place]))


def _largest_rate(run: Run) -> tuple[Peak | None, str, float]:
    """The largest rate relative to its limit, or among all rates without limits."""
    share = rate_shares(run)
    has_limits = np.any(np.isfinite(run.scenario.controller().velocity_limits))
    limited = bool(np.any(share)) or bool(has_limits and not np.any(run.rates))
    tick, joint = np.unravel_index(np.argmax(share if limited else np.abs(run.rates)), share.shape)
    peak = Peak(float(share[tick, joint]), float(run.time[tick])) if limited else None
    return peak, run.joint_names[joint], float(run.rates[tick, joint])


def _left_at_end(run: Run) -> tuple[FloatArray, FloatArray]:
    """Singular values of the working joints at the end, and the directions that are lost there.

    Acceleration limits are ignored: they restrict a joint at one tick and not at later ones.
    """
    controller = run.scenario.controller()
    controller.set_limits(acceleration=np.inf)
    controller.set_null_motion(None)
    plan = run.scenario.schedule
    for tick in sorted(tick for tick in plan.changes if tick < len(run)):
        for joint, kind in plan.changes[tick]:
            if kind is None:
                controller.restore(joint)
            else:
                controller.fail(joint, kind)
    out = controller.step(run.q[-1], np.zeros(6))
    J, lower, upper = np.asarray(out.jacobian), np.asarray(out.lower), np.asarray(out.upper)
    rates = np.where(lower < upper, full_rates(np.maximum(np.abs(lower), np.abs(upper))), 0.0)
    lost = directions(J * rates, least_speeds(run.task.indices)).lost
    return np.asarray(out.singular_values()), np.ascontiguousarray(lost.T)
