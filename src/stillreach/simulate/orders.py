"""What a controller gets in a chunk of ticks: twists, and the poses that they lead to."""

from __future__ import annotations

import numpy as np

from stillreach._door import FloatArray
from stillreach.simulate.motion import checked_motion, commands
from stillreach.simulate.path import Stretch, held_between, led_to, stretches
from stillreach.simulate.scenario import Scenario


class Orders:
    """The orders of a scenario, chunk by chunk, from the first tick on.

    Args:
        scenario: whose motion and integrator.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._motion = checked_motion(scenario.motion)
        self._period = scenario.period
        self.stages = 2 if scenario.integrator == "rk4" else 1
        """Orders a step."""
        self.starts = scenario.part_starts()
        """The tick from which on each part of the motion is commanded."""
        self._target = scenario.task_pose(scenario.start)
        self._stretches = stretches(self._motion, self.starts, self._period, self._target)

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
        part = sum(start <= first for start in self.starts) - 1
        # the ends of the steps belong to the path, whether or not they are asked for
        stages = np.arange(self.stages * first, self.stages * end + 1, dtype=np.float64)
        count = 1 if last else len(stages) - (self.stages == 1)
        stretch = self._stretches.get(part)
        if stretch is None:
            return self._free(part, stages * (self._period / self.stages), count, last)
        poses, twists = self._along(stretch, stages / self.stages)
        if not last:
            self._target = poses[-1]
        return twists[:count], np.ascontiguousarray(poses[:count])

    def _free(self, part: int, times: FloatArray, count: int, last: bool) -> tuple[FloatArray, FloatArray]:
        """Orders of held twists and functions, which lead on from wherever the motion is."""
        twists = commands(self._motion, times[:count], part)
        if last:
            return twists, self._target[None]
        poses = led_to(self._target, self._motion, part, times)
        self._target = poses[-1]
        return twists, np.ascontiguousarray(poses[:count])

    def _along(self, stretch: Stretch, ticks: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses and twists of a course; with Euler steps the twist that leads to the next tick's pose is held."""
        poses, twists = stretch.at(ticks)
        return poses, held_between(poses, self._period) if self.stages == 1 else twists
