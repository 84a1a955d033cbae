"""The common work of a batch: independent rows of the paper's arm, of which a known part is over the limit."""

from dataclasses import dataclass

import numpy as np

import stillreach as sr
from bench.workload import LIMIT, arm

ROWS, PART_OVER = 100_000, 0.15
FAIL_IN_TURN = ("j2", "j4", "j7", "j6", "j9", "j10", "j1", "j3", "j5")
"""The joints that fail as fewer work: the first three are the common work's."""
INSIDE, OVER = (0.05, 0.95), (1.05, 2.0)
"""Largest rate of the pseudoinverse over the limit, in rows that keep inside it and in those that do not."""


@dataclass(frozen=True)
class Rows:
    """q (N, n) [rad], twist (N, 6) [m/s, rad/s], bounds (n,) or (N, n) [rad/s]; over (N,): over the limit."""

    q: np.ndarray
    twist: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    over: np.ndarray

    def __len__(self) -> int:
        return len(self.q)

    def bounds(self, part: slice) -> sr.Bounds | tuple[np.ndarray, np.ndarray]:
        """Those of some rows, as `solve_batch` takes them."""
        return sr.Bounds(self.lower, self.upper) if self.lower.ndim == 1 else (self.lower[part], self.upper[part])

    def bounds_by_row(self) -> "Rows":
        """The same rows, with the same bounds written out for each of them."""
        shape = self.q.shape
        lower, upper = (np.array(np.broadcast_to(side, shape)) for side in (self.lower, self.upper))
        return Rows(self.q, self.twist, lower, upper, self.over)


def make_rows(
    count: int = ROWS, *, working: int = 8, part: float = PART_OVER, mixed: bool = False, seed: int = 6
) -> Rows:
    """Random rows with that many working joints; the pseudoinverse of exactly `part` of them is over the limit.

    Args:
        count: N.
        working: of the 11 joints.
        part: of the rows.
        mixed: other joints failed in each row, and so bounds by row.
        seed: of the random numbers.
    """
    random, robot = np.random.default_rng([seed, working]), arm()
    q, twist = random.uniform(-2.0, 2.0, (count, robot.n)), random.normal(size=(count, 6))
    failed = np.array([robot.joint_index(name) for name in FAIL_IN_TURN[: robot.n - working]], dtype=int)
    joints = np.tile(np.setdiff1d(np.arange(robot.n), failed), (count, 1))
    if mixed:
        joints = np.sort(np.argsort(random.random(q.shape), axis=1)[:, :working], axis=1)
    over = random.permutation(count) < round(part * count)
    times = np.where(over, random.uniform(*OVER, count), random.uniform(*INSIDE, count))
    twist *= (times * LIMIT / largest_rate(robot, q, twist, joints))[:, None]
    upper = np.zeros((count, robot.n))
    np.put_along_axis(upper, joints, LIMIT, axis=1)
    upper = upper if mixed else upper[0]
    return Rows(q, twist, -upper, upper, over)


def largest_rate(robot: sr.Arm, q: np.ndarray, twist: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """(N,) of the pseudoinverse of the columns `joints` (N, k), by the normal equations of its smaller side."""
    largest = np.empty(len(q))
    for first in range(0, len(q), 4096):
        part = slice(first, first + 4096)
        J = np.take_along_axis(robot.jacobian(q[part]), joints[part, None, :], axis=2)
        Jt, b = J.transpose(0, 2, 1), twist[part, :, None]
        wide = joints.shape[1] >= 6
        rates = Jt @ np.linalg.solve(J @ Jt, b) if wide else np.linalg.solve(Jt @ J, Jt @ b)
        largest[part] = np.max(np.abs(rates), axis=(1, 2))
    return largest
