"""What a peer is given and what it must answer. No file of a peer imports stillreach: only `ours` does."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

BASE, TOOL = "base_link", "tool"
"""Links of the URDF file."""
TOLERANCE = 1e-6
"""[m, rad] largest entry of the difference of two poses (4, 4) that count as the same."""
CLOSE = 1e-8
"""Where a loop ends, by its own error."""
BUDGET = 0.05
"""[s] of processor time that a loop with random restarts may take for a pose."""
STEP, STEPS = 0.6, 40
"""Largest step [rad] of a loop's joint, and its most steps from one start: those of `arm.inverse`."""


@dataclass(frozen=True)
class Robot:
    """The arm: name, a URDF file, and its position limits (n,) [rad]."""

    name: str
    urdf: str
    lower: np.ndarray
    upper: np.ndarray


class PosePeer(Protocol):
    """Answers one pose at a time. Everything that can be prepared is prepared when it is made."""

    packages: tuple[str, ...]

    def __init__(self, robot: Robot) -> None: ...

    def solve(self, pose: np.ndarray, start: np.ndarray) -> np.ndarray | None:
        """Joint positions (n,) [rad] for a pose (4, 4) from a start (n,), or None."""


class Loop:
    """Starts for a loop: the given one, then random ones, until the time is up."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.random = robot, np.random.default_rng(7)

    def starts(self, first: np.ndarray) -> Iterator[np.ndarray]:
        """Start after start."""
        end = time.process_time() + BUDGET
        yield first
        while time.process_time() < end:
            yield self.random.uniform(self.robot.lower, self.robot.upper)

    def search(
        self, first: np.ndarray, step: Callable[[np.ndarray, bool], tuple[float, np.ndarray]]
    ) -> np.ndarray | None:
        """Runs `step(q, new) -> size of the error at q, the next q` from start after start."""
        for q in self.starts(first):
            best, stalls = np.inf, 0
            for count in range(STEPS):
                size, after = step(q, count == 0)
                if size < CLOSE:
                    return q
                stalls = 0 if size < 0.9 * best else stalls + 1
                if stalls > 6:
                    break
                best = min(best, size)
                q = np.clip(after, self.robot.lower, self.robot.upper)
        return None
