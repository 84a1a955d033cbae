"""Run a scenario: chunks of ticks in the compiled core, and between them whatever Python has to do."""

from __future__ import annotations

import time

import numpy as np

from stillreach._door import FloatArray
from stillreach.control import Controller
from stillreach.errors import SimulationInterrupted
from stillreach.simulate.events import fault_changes
from stillreach.simulate.fields import empty_record
from stillreach.simulate.labels import run_attributes
from stillreach.simulate.motion import checked_motion, commands
from stillreach.simulate.progress import Progress
from stillreach.simulate.run import Run
from stillreach.simulate.scenario import Scenario

FIRST_CHUNK = 64
CHUNK_SECONDS = 0.05
"""Work between two looks at the clock and the keyboard."""

NOT_COMPUTED = -1
"""Status of a tick that the core has not answered yet."""


def simulate(scenario: Scenario, *, progress: bool | None = None) -> Run:
    """Simulate an arm under a controller.

    Args:
        scenario: what to run.
        progress: show a progress bar; None shows one on a terminal when it takes longer than a second.

    Returns:
        The run: a row for each tick, the last one at the final state (steps + 1 rows).

    Raises:
        SimulationInterrupted: Ctrl-C; ``.run`` of the error holds every tick computed so far.
        InputError: a function of time in the motion answered with something else than 6 finite numbers.
    """
    simulation = _Simulation(scenario)
    try:
        with Progress(scenario.name or "simulating", simulation.ticks, progress) as bar:
            while simulation.done < simulation.ticks:
                simulation.advance()
                bar.update(simulation.done)
    except SimulationInterrupted:
        raise
    except KeyboardInterrupt:
        raise SimulationInterrupted(simulation.run(interrupted=True)) from None
    return simulation.run()


class _Simulation:
    """The state of a simulation between two chunks."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.ticks = scenario.steps + 1
        self.controller = Controller(
            scenario.arm,
            law=scenario.law,
            task=scenario.task,
            period=scenario.period,
            rate_limits=scenario.rate_limits,
            position_limits=scenario.position_limits,
            acceleration_limits=scenario.acceleration_limits,
        )
        self.record = empty_record(self.ticks, scenario.arm.n)
        self.record["time"][:] = np.arange(self.ticks) * scenario.period
        self.record["status"][:] = NOT_COMPUTED
        self.q = scenario.start.copy()
        self.changes = fault_changes(scenario)
        self.starts = scenario.part_starts()
        self.chunk = FIRST_CHUNK
        self.tick = 0

    @property
    def done(self) -> int:
        """Number of ticks that the core has answered, also when an interrupt came right after it had."""
        missing = np.flatnonzero(self.record["status"][self.tick :] == NOT_COMPUTED)
        return self.tick + int(missing[0]) if len(missing) else self.ticks

    def advance(self) -> None:
        """One chunk, up to the next tick at which a fault or the motion changes."""
        for joint, kind in self.changes.get(self.tick, ()):
            if kind is None:
                self.controller.restore(joint)
            else:
                self.controller.fail(joint, kind)
        first, end = self.tick, self._chunk_end()
        began = time.perf_counter()
        twists = self._commands(first, end)
        rows = {name: array[first:end] for name, array in self.record.items() if name != "time"}
        self.controller.rollout(self.q, twists, integrator=self.scenario.integrator, record=rows)
        self.tick = end
        self._adapt(end - first, time.perf_counter() - began)

    def run(self, *, interrupted: bool = False) -> Run:
        """What was computed so far."""
        rows = {name: array[: self.done] for name, array in self.record.items()}
        return Run(
            **rows,
            joint_names=self.scenario.arm.joint_names,
            joint_units=tuple("m" if kind else "rad" for kind in self.scenario.arm.kinds),
            attrs=run_attributes(self.scenario, interrupted=interrupted),
        )

    def _chunk_end(self) -> int:
        breaks = [tick for tick in (*self.changes, *self.starts) if tick > self.tick]
        return min([self.tick + self.chunk, self.ticks, *breaks])

    def _commands(self, first: int, end: int) -> FloatArray:
        """Commands at the stages of the chunk's steps: its ticks, with half steps and the last step's end for Runge-Kutta.

        All are of one part of the motion. A part begins with a step, so that no step crosses the jump between two.
        """
        part = sum(start <= first for start in self.starts) - 1
        if self.scenario.integrator == "euler":
            times = self.record["time"][first:end]
        else:
            times = np.arange(2 * first, 2 * end + 1) * (self.scenario.period / 2)
        return commands(checked_motion(self.scenario.motion), times, part)

    def _adapt(self, ticks: int, seconds: float) -> None:
        """Chunks of about CHUNK_SECONDS, growing by at most a factor of 4 at a time."""
        wanted = ticks * CHUNK_SECONDS / max(seconds, 1e-9)
        self.chunk = int(np.clip(wanted, 1, 4 * self.chunk))
