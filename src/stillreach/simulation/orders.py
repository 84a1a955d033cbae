"""Commands for a chunk of ticks: twists and target poses."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stillreach._door import FloatArray
from stillreach.simulation.motion import TICK_TOLERANCE, ConstantTwist, commands
from stillreach.simulation.path import Stretch, held_between, led_to
from stillreach.simulation.scenario import Scenario

LEAST_SHARE = 1e-3
"""Smallest fraction of a step for the chord that gives the direction of a tool at rest."""


class Part(NamedTuple):
    """The commands between two changes of the motion; the last part is the tick at the end.

    Args:
        first, end: its ticks, the second one not included.
        twists: (K, 6) at the stages of its steps, as ``Orders.chunk`` has them.
        poses: (K, 4, 4) [m] target poses there.
    """

    first: int
    end: int
    twists: FloatArray
    poses: FloatArray

    @property
    def targets(self) -> FloatArray:
        """(end - first, 4, 4) [m] the target pose of each of its ticks."""
        ticks = self.end - self.first
        return self.poses[:: 2 if len(self.poses) > ticks else 1][:ticks]


def parts_of(scenario: Scenario) -> tuple[Part, ...]:
    """All commands of a scenario, on the clock "time"."""
    orders, last = Orders(scenario), scenario.steps
    breaks = sorted({0, *(start for start in scenario.schedule.starts if start < last), last})
    return tuple(
        Part(first, end, *map(np.ascontiguousarray, orders.chunk(first, end, last=first == last)))
        for first, end in zip(breaks, [*breaks[1:], last + 1], strict=True)
    )


def orders_of(scenario: Scenario) -> Orders:
    """The commands of a scenario, for its clock."""
    return ArmOrders(scenario) if scenario.clock == "arm" else Orders(scenario)


class Orders:
    """The commands of a scenario, by chunks, from the first tick on.

    Args:
        scenario: with motion and integrator.
    """

    longest: float = np.inf
    """Largest number of ticks in a chunk."""

    def __init__(self, scenario: Scenario) -> None:
        self._plan = scenario.schedule
        self._period = scenario.period
        self.stages = 2 if scenario.integrator == "rk4" else 1
        """Commands for each step."""
        self._target = self._plan.T_start
        self._part, self._since, self._T_part = -1, 0.0, self._target
        """The part of the last chunk without a course, when it began [s], and the pose then."""

    def chunk(self, first: int, end: int, *, last: bool) -> tuple[FloatArray, FloatArray]:
        """The commands at the stages of the steps from tick ``first`` to tick ``end``.

        All belong to one part of the motion: parts begin with a step, so no step crosses the jump between two parts.

        Args:
            first: tick of the first step, the end of the previous chunk.
            end: tick that the last step leads to.
            last: no step follows this tick: return its commands only.

        Returns:
            Twists (K, 6) and target poses (K, 4, 4) of the tool; K is 1 for the last tick, one for each step for
            Euler, and with the half steps and the end of the last step for Runge-Kutta.
        """
        part = self._plan.part(first)
        # the path includes the ends of the steps, even if not requested
        stages = np.arange(self.stages * first, self.stages * end + 1, dtype=np.float64)
        count = 1 if last else len(stages) - (self.stages == 1)
        stretch = self._plan.stretches.get(part)
        if stretch is None:
            return self._free(part, stages * (self._period / self.stages), count, last)
        poses, twists = self._along(stretch, stages / self.stages)
        if not last:
            self._target = poses[-1]
        return twists[:count], np.ascontiguousarray(poses[:count])

    def follow(self, tick: int, scale: float) -> float:
        """Update after a chunk; returns the path time [s] of its last tick, whose scale is given."""
        return tick * self._period

    def _free(self, part: int, times: FloatArray, count: int, last: bool) -> tuple[FloatArray, FloatArray]:
        """Commands of constant twists and functions; the same to the last bit, however ticks are cut into chunks."""
        twists = commands(self._plan.motion, times[:count], part)
        if last:
            return twists, self._target[None]
        if part != self._part:
            self._part, self._since, self._T_part = part, times[0], self._target
        steady = part >= len(self._plan.motion) or isinstance(self._plan.motion[part], ConstantTwist)
        begun = self._T_part if steady else self._target
        poses = led_to(begun, self._plan.motion, part, times, self._since)
        self._target = poses[-1]
        return twists, np.ascontiguousarray(poses[:count])

    def _along(self, stretch: Stretch, ticks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses and twists of a course; Euler steps use the constant twist to the next tick's pose."""
        poses, twists = stretch.at(ticks)
        return poses, held_between(poses, self._period) if self.stages == 1 else twists


class ArmOrders(Orders):
    """The commands of a motion that waits for the arm: each tick advances it by scale times the period."""

    longest = 1

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        self._now = 0.0
        """Position in the motion, in ticks."""
        self._reach = 1.0
        """Length of this tick's command; below one tick at the end of a part."""
        self._share = 1.0
        """Scale of the last tick, the estimate for the next."""

    def chunk(self, first: int, end: int, *, last: bool) -> tuple[FloatArray, FloatArray]:
        """The command of tick ``first``: the direction of the expected step, at full speed."""
        part, reach = self._plan.part(self._now), max(self._share, LEAST_SHARE)
        self._reach = min(1.0, self._end(part) - self._now)
        stretch = self._plan.stretches.get(part)
        if stretch is None:
            twists = commands(self._plan.motion, np.array([self._now * self._period]), part) * self._reach
        else:
            poses, _ = stretch.at(self._now + np.array([0.0, reach * self._reach]))
            self._target = poses[0]
            twists = held_between(poses, self._period * reach)
        return twists, self._target[None].copy()

    def follow(self, tick: int, scale: float) -> float:
        """Returns the path time [s] of the last tick; advances the motion by the executed part of its command."""
        part, before = self._plan.part(self._now), self._now
        self._share, self._now = scale, before + scale * self._reach
        if self._end(part) - self._now < TICK_TOLERANCE:
            self._now = self._end(part)
        stretch = self._plan.stretches.get(part)
        if stretch is None:
            times = np.array([before, self._now]) * self._period
            self._target = led_to(self._target, self._plan.motion, part, times)[-1]
        else:
            self._target = stretch.at(np.array([self._now]))[0][0]
        return before * self._period

    def _end(self, part: int) -> float:
        starts = self._plan.starts
        return float(starts[part + 1]) if part + 1 < len(starts) else np.inf
