"""Why a tool did not arrive: time, direction, and what the arm could do instead.

Each tick of the run is solved again for the least error inside its bounds. The residual is the normal of a plane that
no rates inside the bounds cross, so the largest motion along it is known, by gain and not by rank.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach._door import FloatArray
from stillreach._words import direction as in_words
from stillreach._words import joined
from stillreach.batch import BatchSolution, solve_batch
from stillreach.laws import KeepDirection, Law, LeastError
from stillreach.simulation.commanded import in_axes
from stillreach.simulation.record import HEALTHS
from stillreach.status import Health
from stillreach.task import UNIT_WEIGHTS, Task

if TYPE_CHECKING:
    from stillreach.simulation.run import Run

MISSED = 0.01
"""A tick misses its command if the relative residual is above this,"""
NOTHING = 1e-9
"""and the residual is above this, in weighted units."""
HARDLY = 0.1
"""An arm can hardly move along a direction if it can do at most this fraction of the command along it."""
GAP = 0.02
"""Ranges of ticks with a smaller gap, relative to the run, are joined."""
ROUNDING = 1e-9
"""Relative; a smaller effect of a joint along a direction counts as none."""


@dataclass(frozen=True)
class Why:
    """Why a tool did not arrive.

    Args:
        sentence: the reason in words.
        since, until: [s] the first tick that missed its command, and the first one after the last; until is None for
            the end of the run, both where no tick missed its command.
        at: [s] the tick that the following attributes refer to.
        direction: (m,) unit twist in the task's rows, in the units of its weights, along which the bounds allow too
            little; None if they allow the whole command.
        possible: the largest motion along it that rates inside the bounds make, relative to the commanded one; below 0
            if a runaway joint moves the tool the other way.
        instead: what the arm could have done instead: "position", "orientation", "slower" or None.
    """

    sentence: str
    since: float | None = None
    until: float | None = None
    at: float | None = None
    direction: FloatArray | None = None
    possible: float | None = None
    instead: str | None = None


def why_missed(run: Run) -> Why:
    """Why the tool of a complete run did not arrive."""
    unknown = _unknown(run)
    if unknown is not None:
        return unknown
    misses, scenario = _Misses(run), run.scenario
    stretch = misses.main(misses.impossible)
    if stretch is not None:
        return _impossible(misses, stretch)
    stretch = misses.main(misses.missed)
    if stretch is not None:
        return _given_up(misses, stretch)
    done = "every tick executes the commanded twist"
    if scenario.loop == "open":
        return Why(f"{done}; the error comes from the open loop with steps of {1000 * scenario.period:g} ms")
    return Why(f"{done}; the feedback needs more time or more gain")


def _unknown(run: Run) -> Why | None:
    """The reason of a run at whose end the controller does not know the state of a joint."""
    late = [int(joint) for joint in np.flatnonzero(run.health[-1] != run.known[-1])]
    if not late:
        return None
    first = int(np.flatnonzero(run.health[:, late[0]] != run.known[:, late[0]])[0])
    names = joined([run.joint_names[joint] for joint in late], "and")
    is_, its = ("is", "its") if len(late) == 1 else ("are", "their")
    states = joined([HEALTHS[int(run.health[-1, joint])] for joint in late], "and")
    return Why(
        f"{names} {is_} {states}, and at the end the controller does not know {its} state", float(run.time[first])
    )


class _Misses:
    """The residuals of a run's ticks, and the part that was impossible."""

    def __init__(self, run: Run) -> None:
        controller = run.scenario.controller()
        controller.set_null_motion(None)
        self.run, self.task, self.weights = run, controller.task, controller.law.weights
        self.best = LeastError(price=None, weights=self.weights)
        self.row_weights = np.asarray(controller.step(run.scenario.start, np.zeros(6)).row_weights)
        wanted = in_axes(self.task, run.command, run.pose)[:, self.task.indices]
        self.wanted = wanted @ self.row_weights.T
        """(T, m) commands in weighted units."""
        left = solve_batch(
            run.scenario.arm, self.best, run.q, run.command, (run.lower, run.upper), task=self.task, want="residual"
        ).residual
        self.left = np.asarray(left) @ self.row_weights.T
        """(T, m) residuals of the best rates."""
        size = np.linalg.norm(self.wanted, axis=1)
        self.undone = np.linalg.norm(self.left, axis=1)
        least = MISSED * size + NOTHING
        self.runaway = np.any(run.health == Health.RUNAWAY, axis=1)
        braking = (size == 0.0) & ~self.runaway  # after the end of the motion
        self.missed = (run.task_error > least) & ~braking
        self.impossible = self.missed & (self.undone > least)
        along = np.einsum("tm,tm->t", self.left, self.wanted)
        part = np.divide(self.undone**2, along, out=np.full(len(run), np.inf), where=along > 0.0)
        self.hardly = self.impossible & (1.0 - part <= HARDLY)
        self.against = self.impossible & (1.0 - part < -ROUNDING)  # the tool moves against the command
        self.share = np.divide(run.task_error, size, out=np.ones(len(run)), where=size > 0.0)

    def main(self, ticks: np.ndarray) -> tuple[int, int] | None:
        """First and last tick of the range at the end of the run, or else of the one with the largest residual."""
        found = self._stretches(ticks)
        if not found:
            return None
        if found[-1][1] >= len(self.run) - 1 - self._gap:
            return found[-1]
        return max(found, key=lambda stretch: float(np.sum(self.run.task_error[stretch[0] : stretch[1] + 1])))

    def ends(self, stretch: tuple[int, int]) -> float | None:
        """[s] the first tick after a range; None at the end of the run."""
        return None if stretch[1] >= len(self.run) - 1 - self._gap else float(self.run.time[stretch[1] + 1])

    def barrier(self, tick: int) -> tuple[FloatArray, float]:
        """The direction along which the bounds allow too little, and the possible fraction of the command.

        The residual of the best rates is the normal of a plane that no rates inside the bounds cross.
        """
        run = self.run
        normal = self.row_weights.T @ self.left[tick]
        J = np.asarray(self.again(tick, self.best, self.task, "jacobian").jacobian)[0]
        most = _most_along(J, run.lower[tick], run.upper[tick], normal)
        asked = float(self.left[tick] @ self.wanted[tick])
        units = self.weights or self.task.weights or UNIT_WEIGHTS
        direction = normal * np.where(np.less(self.task.indices, 3), units.length, units.angle)
        possible = most / asked if asked > 0.0 else -np.inf if most < 0.0 else 0.0
        return direction / np.linalg.norm(direction), possible

    def again(self, tick: int, law: Law, task: Task, want: str) -> BatchSolution:
        """The solution of a tick of the run with another law or task."""
        run, one = self.run, slice(tick, tick + 1)
        bounds = (run.lower[one], run.upper[one])
        return solve_batch(run.scenario.arm, law, run.q[one], run.command[one], bounds, task=task, want=want)

    @property
    def _gap(self) -> int:
        return max(5, round(GAP * len(self.run)))

    def _stretches(self, ticks: np.ndarray) -> list[tuple[int, int]]:
        places = np.flatnonzero(ticks)
        if not len(places):
            return []
        breaks = np.flatnonzero(np.diff(places) > self._gap)
        firsts, lasts = np.append(places[0], places[breaks + 1]), np.append(places[breaks], places[-1])
        return list(zip(firsts.tolist(), lasts.tolist(), strict=True))


def _most_along(J: FloatArray, lower: FloatArray, upper: FloatArray, direction: FloatArray) -> float:
    """The largest direction · (J rates), direction (m,), of all rates between lower and upper (n,)."""
    push = direction @ J
    pushes = np.abs(push) > ROUNDING * np.linalg.norm(J, axis=0) * np.linalg.norm(direction)
    return float(np.sum(push[pushes] * np.where(push > 0.0, upper, lower)[pushes]))


def _impossible(misses: _Misses, stretch: tuple[int, int]) -> Why:
    """The sentence if the bounds did not allow the command: direction and possible fraction."""
    inside = np.zeros(len(misses.run), dtype=bool)
    inside[stretch[0] : stretch[1] + 1] = True
    worst = misses.undone * inside
    hardly = misses.hardly & inside
    if np.sum(worst[hardly]) >= 0.5 * np.sum(worst):
        stretch = misses.main(hardly) or stretch
        hardly[: stretch[0]] = hardly[stretch[1] + 1 :] = False
        still = hardly & ~(misses.against & ~misses.runaway)  # where it is not because the arm brakes
        tick = int(np.argmax(still if np.sum(worst[still]) >= 0.5 * np.sum(worst[hardly]) else hardly))
    else:
        tick = int(np.argmax(worst))
    direction, possible = misses.barrier(tick)
    runaway, first = bool(misses.runaway[tick]), stretch[0]
    if possible < 0.0 and runaway:  # from its beginning, not from that of what was missed before
        first += int(np.flatnonzero(~misses.runaway[first:tick])[-1] + 1) if not all(misses.runaway[first:tick]) else 0
    since, until = float(misses.run.time[first]), misses.ends(stretch)
    instead, slower = _instead(misses, tick)
    text = _limited(since, until, _along(misses, direction), possible, runaway)
    text += _could(instead, slower, until is not None)
    if until is not None:
        text += "; open loop does not correct the error" if misses.run.scenario.loop == "open" else ""
    return Why(text, since, until, float(misses.run.time[tick]), direction, possible, instead)


def _limited(since: float, until: float | None, direction: str, possible: float, runaway: bool) -> str:
    """When the arm could do too little along a direction."""
    past = until is not None
    moves = "moved" if past else "moves"
    if possible < 0.0 and not runaway:
        return f"{_when(since, until)} the braking arm {moves} the tool against {direction}"
    if possible < 0.0:
        return (
            f"{_when(since, until)} a runaway joint {moves} the tool against {direction}, and the others cannot stop it"
        )
    if possible <= HARDLY:
        return f"{_when(since, until)} the arm {'could' if past else 'can'} hardly move along {direction}"
    slow = f"{'was' if past else 'is'} too slow along {direction}: at most {100 * possible:.3g} % of what is commanded"
    return f"{_when(since, until)} the arm {slow}"


def _when(since: float, until: float | None) -> str:
    return f"from {since:g} s on" if until is None else f"from {since:g} to {until:g} s"


def _could(instead: str | None, slower: float, past: bool) -> str:
    could = "could have" if past else "could"
    if instead == "slower":
        return f"; at {100 * slower:.3g} % of the speed it {could}"
    if instead is not None:
        return f"; without {'orientation' if instead == 'position' else 'position'} it {could}"
    return ""


def _given_up(misses: _Misses, stretch: tuple[int, int]) -> Why:
    """The sentence if the bounds allowed the command, but the law did less."""
    since, until = float(misses.run.time[stretch[0]]), misses.ends(stretch)
    tick = stretch[0] + int(np.argmax(misses.run.task_error[stretch[0] : stretch[1] + 1]))
    leaves = f"{type(misses.run.scenario.law).__name__} {'leaves' if until is None else 'left'}"
    share = f"up to {100 * misses.share[tick]:.3g} % of the commanded twist"
    text = f"{_when(since, until)} {leaves} {share} undone, although rates inside the bounds could do it"
    return Why(text, since, until, float(misses.run.time[tick]))


def _instead(misses: _Misses, tick: int) -> tuple[str | None, float]:
    """The part of the task that was possible at a tick, and the possible fraction of the whole."""
    task = misses.task
    scale = float(_number(misses.again(tick, KeepDirection(weights=misses.weights), task, "scale").scale))
    if HARDLY <= scale < 1.0:
        return "slower", scale
    wanted = in_axes(task, misses.run.command[tick : tick + 1], misses.run.pose[tick : tick + 1])[0]
    parts = {"position": [row for row in task.indices if row < 3], "orientation": [r for r in task.indices if r >= 3]}
    for name, rows in parts.items():
        size = float(np.linalg.norm(wanted[rows]))
        if len(rows) == task.m or size <= MISSED * np.linalg.norm(wanted):
            continue  # the whole task, or no command
        part = Task(rows=tuple(row in rows for row in range(6)), frame=task.frame, tool=task.tool)
        left = misses.again(tick, LeastError(price=None), part, "task_error").task_error
        if _number(left) <= MISSED * size + NOTHING:
            return name, scale
    return None, scale


def _along(misses: _Misses, direction: FloatArray) -> str:
    """A direction in words, with the axes unless they are the base's."""
    return in_words(direction, misses.task.indices) + ("" if misses.task.frame == "base" else " (tool axes)")


def _number(values: Any) -> float:
    return float(np.asarray(values)[0])
