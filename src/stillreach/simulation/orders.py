"""What a controller gets in a chunk of ticks: twists, and the poses that they lead to."""

from __future__ import annotations

import numpy as np

from stillreach._door import FloatArray
from stillreach.simulation.motion import TICK_TOLERANCE, commands
from stillreach.simulation.path import Stretch, held_between, led_to
from stillreach.simulation.scenario import Scenario

LEAST_SHARE = 1e-3
"""A chord over at least this share of a step says where a tool that stands still is to go."""


def orders_of(scenario: Scenario) -> Orders:
    """The orders of a scenario, by its clock."""
    return ArmOrders(scenario) if scenario.clock == "arm" else Orders(scenario)


class Orders:
    """The orders of a scenario, chunk by chunk, from the first tick on.

    Args:
        scenario: whose motion and integrator.
    """

    longest: float = np.inf
    """Ticks in a chunk, at most."""

    def __init__(self, scenario: Scenario) -> None:
        self._plan = scenario.schedule
        self._period = scenario.period
        self.stages = 2 if scenario.integrator == "rk4" else 1
        """Orders a step."""
        self._target = self._plan.T_start

    def chunk(self, first: int, end: int, *, last: bool) -> tuple[FloatArray, FloatArray]:
        """The orders at the stages of the steps from tick ``first`` to tick ``end``.

        All are of one part of the motion: a part begins with a step, so that no step crosses the jump between two.

        Args:
            first: tick of the first step; where the chunk before this one ended.
            end: tick that the last step leads to.
            last: there is no step after this tick: its orders only.

        Returns:
            Twists (K, 6) and poses (K, 4, 4) where the tool should be; K is 1 for the last tick, one a step for
            Euler's, and with the half steps and the end of the last step for Runge-Kutta.
        """
        part = self._plan.part(first)
        # the ends of the steps belong to the path, whether or not they are asked for
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
        """After a chunk: the path time [s] of its last tick, which was answered with a scale."""
        return tick * self._period

    def _free(self, part: int, times: FloatArray, count: int, last: bool) -> tuple[FloatArray, FloatArray]:
        """Orders of held twists and functions, which lead on from wherever the motion is."""
        twists = commands(self._plan.motion, times[:count], part)
        if last:
            return twists, self._target[None]
        poses = led_to(self._target, self._plan.motion, part, times)
        self._target = poses[-1]
        return twists, np.ascontiguousarray(poses[:count])

    def _along(self, stretch: Stretch, ticks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses and twists of a course; with Euler steps the twist that leads to the next tick's pose is held."""
        poses, twists = stretch.at(ticks)
        return poses, held_between(poses, self._period) if self.stages == 1 else twists


class ArmOrders(Orders):
    """The orders of a motion that waits for the arm: a tick takes it on by its scale times a tick."""

    longest = 1

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        self._now = 0.0
        """Where the motion is, in ticks,"""
        self._reach = 1.0
        """how far the order of this tick leads, less than a tick at the end of a part,"""
        self._share = 1.0
        """and the scale of the last tick, as which the next is likely to be."""

    def chunk(self, first: int, end: int, *, last: bool) -> tuple[FloatArray, FloatArray]:
        """The order of tick ``first``: the direction of what the arm is likely to do, at full speed."""
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
        """The path time [s] of the tick that was answered; the motion goes on by what it did of its order."""
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
