"""What every peer is asked: one arm, three joints locked, twists of which half are more than the limits allow.

The answers known beforehand, by linear programming and bounded least squares in SciPy, are what a peer is judged by.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog, lsq_linear

from bench.workload import LIMIT, arm, locked_joints, paths

PATH = 32
"""Ticks of one path: the arm moves on by less than it may in a millisecond, the tool is told one direction."""


@dataclass(frozen=True)
class Problem:
    """Ticks along short paths; locked joints stand still.

    q (ticks, n) [rad], twist (ticks, 6) [m/s, rad/s], jacobian (ticks, 6, n) and pose (ticks, 4, 4) of the tool in base
    axes, locked (failed joints,) indices, feasible (ticks,): whether any rates inside the limits do the whole twist,
    least (ticks,): the smallest error ‖twist - J rates‖ that rates inside the limits leave. limit () [rad/s].
    """

    q: np.ndarray
    twist: np.ndarray
    jacobian: np.ndarray
    pose: np.ndarray
    locked: np.ndarray
    feasible: np.ndarray
    least: np.ndarray
    limit: np.ndarray

    def __len__(self) -> int:
        return len(self.q)

    @property
    def working(self) -> np.ndarray:
        """Indices of the joints that work."""
        return np.setdiff1d(np.arange(self.q.shape[1]), self.locked)


def make_problem(ticks: int = 1024, seed: int = 4) -> Problem:
    """Random poses, from each of them a path of small steps; all twists scaled so that half are infeasible."""
    q, twist = paths(max(1, round(ticks / PATH)), PATH, seed)
    return solved(q, twist)[0]


def make_batch(rows: int, judged: int = 256, seed: int = 5) -> tuple[Problem, np.ndarray, np.ndarray]:
    """Random rows: q (rows, n) and twist (rows, 6), and what is known of the first of them."""
    q, twist = paths(rows, 1, seed)
    problem, scale = solved(q[:judged], twist[:judged])
    return problem, q, scale * twist


def solved(q: np.ndarray, twist: np.ndarray) -> tuple[Problem, float]:
    """The problem with its twists scaled so that half are infeasible, and by how much they are."""
    robot, locked = arm(), locked_joints()
    J = robot.jacobian(q)
    columns = np.delete(J, locked, axis=2)
    fraction = np.array([largest_fraction(a, b, LIMIT) for a, b in zip(columns, twist, strict=True)])
    scale = between(fraction)
    feasible, twist = fraction >= scale, scale * twist
    least = np.array(
        [0.0 if done else least_error(a, b, LIMIT) for done, a, b in zip(feasible, columns, twist, strict=True)]
    )
    return Problem(q, twist, J, robot.forward(q), locked, feasible, least, np.array(LIMIT)), scale


def between(values: np.ndarray) -> float:
    """A number that half of the values lie above, as far from its neighbours as it can be."""
    ordered = np.sort(values)
    middle = max(1, len(ordered) // 2)
    return float(np.mean(ordered[middle - 1 : middle + 1]))


def largest_fraction(J: np.ndarray, twist: np.ndarray, limit: float) -> float:
    """The largest s with J x = s twist for some |x| <= limit, by linear programming."""
    goal = np.append(np.zeros(J.shape[1]), -1.0)
    bounds = [(-limit, limit)] * J.shape[1] + [(0.0, None)]
    found = linprog(goal, A_eq=np.column_stack([J, -twist]), b_eq=np.zeros(len(twist)), bounds=bounds)
    if not found.success:
        raise RuntimeError(f"linear program: {found.message}")
    return float(found.x[-1])


def least_error(J: np.ndarray, twist: np.ndarray, limit: float) -> float:
    """The smallest ‖twist - J x‖ of any |x| <= limit, by bounded least squares."""
    found = lsq_linear(J, twist, bounds=(-limit, limit), method="bvls", max_iter=500, tol=1e-14)
    return float(np.linalg.norm(twist - J @ found.x))
