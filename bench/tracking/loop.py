"""A closed loop of any law or solver: a target that moves, feedback on its pose, Euler steps, joints that fail."""

from collections.abc import Callable
from dataclasses import dataclass

import daqp
import numpy as np
from scipy.spatial.transform import Rotation

import stillreach as sr

GAIN = 2.0
"""[1/s] of the feedback."""
QP_DAMPING = 1e-6
Step = Callable[[sr.Controller, np.ndarray, np.ndarray], np.ndarray]
"""From a controller that knows the faults, q and the twist to the rates."""


@dataclass(frozen=True)
class Path:
    """A tool that swings about where it starts: `size` (3,) [m] and `turn` (3,) [rad], sines of `pace` (6,) [rad/s].

    `shift` (6,) [rad] are the phases; the path begins at the start.
    """

    start: np.ndarray
    size: np.ndarray
    turn: np.ndarray
    pace: np.ndarray
    shift: np.ndarray

    def goal(self, t: float) -> np.ndarray:
        """(4, 4) pose at a time."""
        at = np.sin(self.pace * t + self.shift) - np.sin(self.shift)
        T = self.start.copy()
        T[:3, 3] += self.size * at[:3]
        T[:3, :3] = Rotation.from_rotvec(self.turn * at[3]).as_matrix() @ T[:3, :3]
        return T

    def twist(self, t: float) -> np.ndarray:
        """(6,) its derivative; the tool turns about one axis."""
        speed = self.pace * np.cos(self.pace * t + self.shift)
        return np.append(self.size * speed[:3], self.turn * speed[3])


def circle(start: np.ndarray, radius: float = 0.1, seconds: float = 8.0) -> Path:
    """A level circle, the attitude kept."""
    pace = np.full(6, 2.0 * np.pi / seconds)
    return Path(start, np.array([radius, radius, 0.0]), np.zeros(3), pace, np.array([np.pi / 2, 0, 0, 0, 0, 0]))


@dataclass(frozen=True)
class Record:
    """What a loop did, tick by tick: tool (ticks, 3) [m], off (ticks,) [m] and turned (ticks,) [rad] from the goal."""

    rates: np.ndarray
    tool: np.ndarray
    off: np.ndarray
    turned: np.ndarray

    @property
    def variation(self) -> float:
        """[rad/s] of the rates, summed over joints."""
        return float(np.sum(np.abs(np.diff(self.rates, axis=0, prepend=0.0))))

    def sign_changes(self, above: np.ndarray) -> int:
        """How often a joint turned round within a tick, with both rates above `above` (n,)."""
        before, after = self.rates[:-1], self.rates[1:]
        least = np.minimum(np.abs(before), np.abs(after))
        return int(np.sum((before * after < 0.0) & (least > above)))


def by_law(ctl: sr.Controller, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
    """The controller's own law."""
    return ctl.step(q, twist).rates


def by_box_qp(ctl: sr.Controller, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
    """A damped QP in the same bounds: what a peer does."""
    asked = ctl.step(q, twist)
    lower, upper = asked.lower, asked.upper
    rates, works = lower.copy(), lower < upper
    if np.any(works):
        J = asked.jacobian[:, works]
        H = J.T @ J + QP_DAMPING * np.eye(J.shape[1])
        f = -J.T @ (twist - asked.jacobian[:, ~works] @ lower[~works])
        unit = 1.0 / np.sqrt(np.diag(H))  # its tolerances are absolute
        box = (np.ascontiguousarray(upper[works] / unit), np.ascontiguousarray(lower[works] / unit))
        scaled = np.ascontiguousarray(H * unit[:, None] * unit)
        z, _, flag, _ = daqp.solve(scaled, f * unit, np.zeros((0, len(f))), *box, primal_tol=1e-10, dual_tol=1e-10)
        if flag < 1:
            raise RuntimeError(f"daqp gave up: {flag}")
        rates[works] = np.clip(z * unit, lower[works], upper[works])
    return rates


def follow(
    ctl: sr.Controller,
    q: np.ndarray,
    path: Path,
    ticks: int,
    period: float,
    *,
    events: dict[int, list[Callable[[sr.Controller], None]]] | None = None,
    step: Step = by_law,
) -> Record:
    """The loop; `events` happen before their ticks."""
    q, rates, tool, off, turned = q.copy(), np.zeros((ticks, len(q))), np.zeros((ticks, 3)), [], []
    at, due = ctl.arm.forward(q), events or {}
    for k in range(ticks):
        for event in due.get(k, []):
            event(ctl)
        goal = path.goal(k * period)
        rates[k] = step(ctl, q, GAIN * error(goal, at) + path.twist(k * period))
        q += period * rates[k]
        at = ctl.arm.forward(q)
        left = error(path.goal((k + 1) * period), at)
        tool[k] = at[:3, 3]
        off.append(np.linalg.norm(left[:3]))
        turned.append(np.linalg.norm(left[3:]))
    return Record(rates, tool, np.array(off), np.array(turned))


def error(goal: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(6,) from a pose to another, along base axes."""
    turn = Rotation.from_matrix(goal[:3, :3] @ at[:3, :3].T).as_rotvec()
    return np.append(goal[:3, 3] - at[:3, 3], turn)
