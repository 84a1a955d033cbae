"""What a peer is given and what it must answer. No file of a peer imports stillreach: only `ours` does."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

TOOL = "tool"
"""Name of the tool's frame, link or site in the robot files."""


@dataclass(frozen=True)
class Robot:
    """The arm with its failed joints, which stand still for the whole of the work.

    `working.urdf` and `working.xml` (MJCF) in the folder hold the joints that work, the failed ones frozen where they
    stand; `arm.urdf` and `arm.xml` hold all of them. For whoever writes kinematics by hand, the chain of the working
    joints: placements (k, 4, 4) from one joint to the next, axes (k, 3), tool (4, 4).
    """

    folder: Path
    n: int
    working: np.ndarray
    locked: np.ndarray
    limit: float
    placements: np.ndarray
    axes: np.ndarray
    tool: np.ndarray

    def path(self, name: str) -> str:
        """Of one of the robot files."""
        return str(self.folder / name)


class TickPeer(Protocol):
    """Answers one tick at a time. Everything that can be prepared is prepared when it is made."""

    packages: tuple[str, ...]
    """Whose versions the table names."""

    def __init__(self, robot: Robot) -> None: ...

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """(6, working joints) of the tool point in base axes, [v; w], for q (n,): shows that the arm is the same."""

    def tick(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Rates (n,) [rad/s] for q (n,) [rad] and twist (6,) [m/s, rad/s]; the array may be used again."""


class BatchPeer(Protocol):
    """Answers many configurations at once."""

    packages: tuple[str, ...]

    def __init__(self, robot: Robot) -> None: ...

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """As of TickPeer, for one q (n,)."""

    def solve(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        """Rates (N, n) for q (N, n) and twist (N, 6)."""
