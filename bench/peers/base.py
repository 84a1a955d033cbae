"""What a peer is given and what it must answer. No file of a peer imports stillreach: only `ours` does."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

TOOL = "tool"
"""Name of the tool's link in the URDF file."""


@dataclass(frozen=True)
class Robot:
    """The arm with its failed joints, which stand still for the whole of the work.

    `urdf` is a file of the joints that work, the failed ones frozen where they stand; MuJoCo reads it, too. For
    kinematics written by hand, the chain of the same joints: placements (k, 4, 4) from one joint to the next,
    axes (k, 3), tool (4, 4).
    """

    urdf: str
    n: int
    working: np.ndarray
    locked: np.ndarray
    limit: float
    placements: np.ndarray
    axes: np.ndarray
    tool: np.ndarray


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
