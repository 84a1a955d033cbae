"""What is read off a run, in the paper's inches and degrees."""

from __future__ import annotations

import numpy as np

from stillreach._rotations import pitch_yaw_roll
from stillreach.bounds import Bounds
from stillreach.laws import LeastError
from stillreach.paper.examples import EXACT, INCH, INCHES_AND_DEGREES, RATE_LIMIT
from stillreach.simulation import Run


def tool_start(run: Run) -> np.ndarray:
    """(3,) [in]."""
    place: np.ndarray = run.pose[0, :3, 3] / INCH
    return place


def tool_end(run: Run) -> np.ndarray:
    """(3,) [in]."""
    place: np.ndarray = run.pose[-1, :3, 3] / INCH
    return place


def displacement(run: Run) -> np.ndarray:
    """How far the tool moved, (3,) [in]."""
    moved: np.ndarray = tool_end(run) - tool_start(run)
    return moved


def commanded_displacement(run: Run) -> np.ndarray:
    """How far it was told to move, (3,) [in]."""
    return np.asarray((run.target[-1, :3, 3] - run.target[0, :3, 3]) / INCH)


def off_target(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """How far the tool is from where it was told to be, at every tick: (T,) [in] and (T,) [deg]."""
    distance = np.linalg.norm(run.pose[:, :3, 3] - run.target[:, :3, 3], axis=1) / INCH
    return distance, _angles_between(run.pose, run.target)


def deviation(run: Run) -> np.ndarray:
    """Actual minus commanded at the end: x, y, z [in], pitch, yaw, roll [deg]; for commands that keep the attitude."""
    angles = pitch_yaw_roll(run.pose[[0, -1]])
    turned = np.rad2deg((angles[1] - angles[0] + np.pi) % (2 * np.pi) - np.pi)
    return np.concatenate([displacement(run) - commanded_displacement(run), turned])


def largest_rate(run: Run) -> float:
    """The largest that any joint ever had [deg/s]."""
    return float(np.rad2deg(np.max(np.abs(run.rates))))


def passes(run: Run, limit: float) -> float:
    """When the largest rate first passes a limit [deg/s], between two ticks on a straight line [s]; NaN if never."""
    largest = np.rad2deg(np.max(np.abs(run.rates), axis=1))
    above = np.flatnonzero(largest > limit)
    if not len(above):
        return float("nan")
    k = int(above[0])
    if k == 0:
        return float(run.time[0])
    part = (limit - largest[k - 1]) / (largest[k] - largest[k - 1])
    return float(run.time[k - 1] + part * (run.time[k] - run.time[k - 1]))


def off_the_line(run: Run) -> float:
    """Largest distance of the tool from the straight line that it was told to follow [in]."""
    along = commanded_displacement(run) / np.linalg.norm(commanded_displacement(run))
    moved = (run.pose[:, :3, 3] - run.pose[0, :3, 3]) / INCH
    return float(np.max(np.linalg.norm(moved - np.outer(moved @ along, along), axis=1)))


def apart(one: Run, other: Run) -> tuple[float, float]:
    """Largest distance [in] and angle [deg] between the tools of two runs of equal ticks."""
    distance = np.max(np.linalg.norm(one.pose[:, :3, 3] - other.pose[:, :3, 3], axis=1)) / INCH
    return float(distance), float(np.max(_angles_between(one.pose, other.pose)))


def _angles_between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Angle between the attitudes of poses (T, 4, 4), (T,) [deg]."""
    between = np.linalg.norm(one[:, :3, :3] - other[:, :3, :3], axis=(1, 2))  # √8 |sin(angle / 2)|
    return np.asarray(np.rad2deg(2.0 * np.arcsin(np.minimum(between / np.sqrt(8.0), 1.0))))


def first_damped(run: Run) -> float:
    """When the damping factor is first above 0 [s]; NaN if never."""
    damped = np.flatnonzero(run.damping > 0)
    return float(run.time[damped[0]]) if len(damped) else float("nan")


def rate_used_while_damped(run: Run) -> float:
    """Median of the largest rate over the ticks with damping [deg/s]; NaN without one."""
    damped = run.damping > 0
    return float(np.rad2deg(np.median(np.max(np.abs(run.rates[damped]), axis=1)))) if damped.any() else float("nan")


def median_damping(run: Run) -> float:
    """Median damping factor over the ticks with damping; NaN without one."""
    damped = run.damping > 0
    return float(np.median(run.damping[damped])) if damped.any() else float("nan")


def largest_jump_of_damping(run: Run) -> float:
    """Largest change of the damping factor from one tick to the next."""
    return float(np.max(np.abs(np.diff(run.damping))))


def error_of_the_task(run: Run) -> float:
    """Size of the residual in inches and degrees, summed over time: what the rates left undone."""
    units = np.repeat([INCHES_AND_DEGREES.length, INCHES_AND_DEGREES.angle], 3)
    return float(np.diff(run.time) @ np.linalg.norm(run.residual[:-1] / units, axis=1))


def variation_of_the_rates(run: Run) -> float:
    """Sum over time and joints of the changes of the rates [deg/s]: what the drives feel."""
    return float(np.rad2deg(np.sum(np.abs(np.diff(run.rates, axis=0)))))


def error_above_the_optimum(run: Run, faster: float) -> np.ndarray:
    """By which part the least possible task error is below the one of exact damping, where that one damps.

    Both are asked the same question: the poses and faults of a run, its command so many times as fast, the paper's
        rate limit.
    """
    arm = run.scenario.arm
    exact, least = EXACT, LeastError(price=None, weights=INCHES_AND_DEGREES)
    saved = []
    for J, command, health in zip(arm.jacobian(run.q), faster * run.command, run.health, strict=True):
        bounds = Bounds.symmetric(np.deg2rad(RATE_LIMIT), n=arm.n).lock(np.flatnonzero(health))
        damped = exact.solve(J, command, bounds)
        if damped.damping > 0:
            saved.append(1.0 - least.solve(J, command, bounds).task_error / damped.task_error)
    return np.array(saved)
