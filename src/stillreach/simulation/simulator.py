"""Run a scenario: chunks of ticks in the compiled core, and between them whatever Python has to do."""

from __future__ import annotations

import time

import numpy as np

from stillreach.errors import SimulationInterrupted
from stillreach.simulation.document import check_whole
from stillreach.simulation.orders import orders_of
from stillreach.simulation.progress import Progress
from stillreach.simulation.record import empty_record
from stillreach.simulation.run import Run
from stillreach.simulation.scenario import Scenario

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
        InputError: a function of time in the motion answered with something else than 6 finite numbers; a scenario
            that was read from a record, which held no function.
    """
    simulation = _Simulation(scenario)
    try:
        with Progress(scenario.name or "simulating", simulation.ticks, progress) as bar:
            while simulation.tick < simulation.ticks:
                simulation.advance()
                bar.update(simulation.tick)
    except SimulationInterrupted:
        raise
    except KeyboardInterrupt:
        raise SimulationInterrupted(simulation.run(interrupted=True)) from None
    return simulation.run()


class _Simulation:
    """The state of a simulation between two chunks."""

    def __init__(self, scenario: Scenario) -> None:
        check_whole(scenario)
        self.scenario = scenario
        self.ticks = scenario.steps + 1
        self.controller = scenario.controller()
        self.record = empty_record(self.ticks, scenario.arm.n)
        for name in ("time", "path_time"):
            self.record[name][:] = np.arange(self.ticks) * scenario.period
        self.record["status"][:] = NOT_COMPUTED
        self.q = scenario.start.copy()
        self.plan = scenario.schedule
        self.orders = orders_of(scenario)
        self.chunk = FIRST_CHUNK
        self.tick = 0

    @property
    def done(self) -> int:
        """Number of ticks that the core has answered, also when an interrupt came right after it had."""
        missing = np.flatnonzero(self.record["status"][self.tick :] == NOT_COMPUTED)
        return self.tick + int(missing[0]) if len(missing) else self.ticks

    def advance(self) -> None:
        """One chunk, up to the next change of faults or motion; the tick at the final state is one of its own."""
        self.plan.change_faults(self.controller, self.tick)
        first, end = self.tick, self._chunk_end()
        last = first == self.ticks - 1
        began = time.perf_counter()
        twists, poses = self.orders.chunk(first, end, last=last)
        self.record["target"][first:end] = poses[:: self.orders.stages][: end - first]
        targets = poses if self.scenario.loop == "closed" else None
        rows = {name: array[first:end] for name, array in self.record.items() if name not in ("time", "target")}
        self.controller.rollout(
            self.q, twists, targets, integrator=self.scenario.integrator, advance=not last, record=rows
        )
        self.record["path_time"][end - 1] = self.orders.follow(end - 1, float(self.record["scale"][end - 1]))
        self.tick = end
        self._adapt(end - first, time.perf_counter() - began)

    def run(self, *, interrupted: bool = False) -> Run:
        """What was computed so far."""
        rows = {name: array[: self.done] for name, array in self.record.items()}
        return Run(scenario=self.scenario, interrupted=interrupted, **rows)

    def _chunk_end(self) -> int:
        breaks = (*self.plan.changes, *self.plan.starts, self.ticks - 1, self.ticks)
        ticks = int(min(self.chunk, self.orders.longest))
        return min(self.tick + ticks, *(tick for tick in breaks if tick > self.tick))

    def _adapt(self, ticks: int, seconds: float) -> None:
        """Chunks of about CHUNK_SECONDS, growing by at most a factor of 4 at a time."""
        wanted = ticks * CHUNK_SECONDS / max(seconds, 1e-9)
        self.chunk = int(np.clip(wanted, 1, 4 * self.chunk))
