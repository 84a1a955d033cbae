"""Run a scenario: chunks of ticks in the compiled core, with Python between them."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from stillreach._core import frames
from stillreach._door import FloatArray
from stillreach.control import Controller
from stillreach.errors import InputError, SimulationInterrupted
from stillreach.plants import KinematicPlant, Moving
from stillreach.simulation.document import check_whole
from stillreach.simulation.orders import orders_of
from stillreach.simulation.progress import Progress
from stillreach.simulation.record import empty_record
from stillreach.simulation.run import Run
from stillreach.simulation.scenario import Scenario
from stillreach.simulation.schedule import Schedule, break_joints, tell
from stillreach.status import Health

FIRST_CHUNK = 64
CHUNK_SECONDS = 0.05
"""Duration of a chunk, after which progress and Ctrl-C are checked."""

NOT_COMPUTED = -1
"""Status of a tick that is not computed yet."""


def simulate(scenario: Scenario, *, progress: bool | None = None) -> Run:
    """Simulate an arm under a controller.

    Args:
        scenario: the scenario.
        progress: show a progress bar; None: on a terminal, after one second.

    Returns:
        The run: a row for each tick, the last one at the final state (steps + 1 rows).

    Raises:
        SimulationInterrupted: after Ctrl-C; ``.run`` of the error has all computed ticks.
        InputError: if a function of time did not return 6 finite numbers, or the scenario was read from a record
            without its function.
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
        self.plant, self.moving = _plant(scenario), _moving(scenario)
        self.orders = orders_of(scenario)
        self.chunk = FIRST_CHUNK
        self.tick = 0

    @property
    def done(self) -> int:
        """Number of computed ticks, also right after an interrupt."""
        missing = np.flatnonzero(self.record["status"][self.tick :] == NOT_COMPUTED)
        return self.tick + int(missing[0]) if len(missing) else self.ticks

    def advance(self) -> None:
        """One chunk, up to the next change of faults or motion; the tick at the final state is a chunk of its own."""
        tell(self.controller, self.plan.known.get(self.tick, ()))
        if self.plant:
            self.plant.change_faults(self.plan, self.tick)
        if self.moving:
            self.moving.change_faults(self.plan, self.tick)
        first, end = self.tick, self._chunk_end()
        last = first == self.ticks - 1
        began = time.perf_counter()
        twists, poses = self.orders.chunk(first, end, last=last)
        self.record["target"][first:end] = poses[:: self.orders.stages][: end - first]
        targets = frames(poses) if self.scenario.loop == "closed" else None
        rows = {name: array[first:end] for name, array in self.record.items() if name not in ("time", "target")}
        if self.moving:
            self.moving.chunk(self.controller, twists, targets, rows, last=last)
            self.record["pose"][first:end] = self.scenario.task_pose(self.record["q"][first:end])
        else:
            self._rollout(twists, targets, rows, last)
        self.record["path_time"][end - 1] = self.orders.follow(end - 1, float(self.record["scale"][end - 1]))
        self.tick = end
        self._adapt(end - first, time.perf_counter() - began)

    def _rollout(self, twists: FloatArray, targets: FloatArray | None, rows: dict[str, Any], last: bool) -> None:
        """A chunk in the compiled core."""
        ticks = len(rows["q"])
        self.controller.rollout(
            self.q,
            twists,
            targets,
            integrator=self.scenario.integrator,
            advance=not last,
            record=rows,
            **(self.plant.chunk(ticks) if self.plant else {}),
        )

    def run(self, *, interrupted: bool = False) -> Run:
        """The run with the ticks computed so far."""
        rows = {name: array[: self.done] for name, array in self.record.items()}
        return Run(scenario=self.scenario, interrupted=interrupted, **rows)

    def _chunk_end(self) -> int:
        breaks = (*self.plan.changes, *self.plan.known, *self.plan.starts, self.ticks - 1, self.ticks)
        ticks = int(min(self.chunk, self.orders.longest))
        return min(self.tick + ticks, *(tick for tick in breaks if tick > self.tick))

    def _adapt(self, ticks: int, seconds: float) -> None:
        """Chunks of about CHUNK_SECONDS, growing by at most a factor of 4 at a time."""
        wanted = ticks * CHUNK_SECONDS / max(seconds, 1e-9)
        self.chunk = int(np.clip(wanted, 1, 4 * self.chunk))


class _Plant:
    """The state of a kinematic plant between two chunks."""

    def __init__(self, plant: KinematicPlant, ticks: int, n: int, period: float) -> None:
        self._noise, self._tick = plant.errors(ticks, n), 0
        self._core = plant.simulated(n, period)

    def change_faults(self, plan: Schedule, tick: int) -> None:
        """The true faults that begin or end at a tick."""
        break_joints(self._core, plan.changes.get(tick, ()))

    def chunk(self, ticks: int) -> dict[str, Any]:
        """What a chunk of ticks needs: the plant, and the errors of its encoders."""
        first, self._tick = self._tick, self._tick + ticks
        return {"plant": self._core, "noise": None if self._noise is None else self._noise[first : self._tick]}


class _Moving:
    """An arm of any plant but the kinematic one, a tick at a time."""

    def __init__(self, moving: Moving, joints: int) -> None:
        self._moving = moving
        self._health = np.zeros(joints, dtype=np.int8)

    def change_faults(self, plan: Schedule, tick: int) -> None:
        """The true faults that begin or end at a tick."""
        for joint, kind in plan.changes.get(tick, ()):
            self._moving.fail(joint, kind)
            self._health[joint] = Health.HEALTHY if kind is None else kind.health

    def chunk(
        self,
        controller: Controller,
        twists: FloatArray,
        targets: FloatArray | None,
        rows: dict[str, Any],
        *,
        last: bool,
    ) -> None:
        """Some ticks; no step follows the last one of a run."""
        for tick in range(len(rows["q"])):
            one = slice(tick, tick + 1)
            row = {name: array[one] for name, array in rows.items()}
            true, seen = np.array(self._moving.q, dtype=np.float64), np.array(self._moving.measure(), dtype=np.float64)
            given = None if targets is None else targets[one]
            controller.rollout(seen, twists[one], given, advance=False, record=row)
            row["q"][0], row["measured"][0], row["health"][0] = true, seen, self._health
            if not last:
                self._moving.advance(row["rates"][0].copy())


def _moving(scenario: Scenario) -> _Moving | None:
    """The arm in motion of a plant that is not kinematic.

    Raises:
        InputError: if the integrator is not Euler's: a plant of its own moves from tick to tick.
    """
    plant = scenario.plant
    assert plant is not None
    if isinstance(plant, KinematicPlant):
        return None
    if scenario.integrator != "euler":
        raise InputError("integrator", repr(scenario.integrator), "'euler' with a plant that moves by itself")
    return _Moving(plant.begin(scenario.arm, scenario.start, scenario.period), scenario.arm.n)


def _plant(scenario: Scenario) -> _Plant | None:
    """The plant of a scenario; None where joints do what they are told and the controller knows every fault at once."""
    plant = scenario.plant
    if not isinstance(plant, KinematicPlant):
        return None
    if plant.exact and not any(fault.known_after for fault in scenario.faults):
        return None
    return _Plant(plant, scenario.steps + 1, scenario.arm.n, scenario.period)
