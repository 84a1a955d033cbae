"""What a survey is about: configurations in chunks, sets of joints that fail, and metrics."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.arm.dexterity import checked_task
from stillreach.arm.limits import sampling_range
from stillreach.errors import InputError
from stillreach.simulation.document import settings_text
from stillreach.task import Task
from stillreach.tolerance.losses import MOST_FACETS, MOST_SETS, all_sets, facets
from stillreach.tolerance.speeds import MOST_NORMALS
from stillreach.tolerance.surveys.positions import Region, region_of

FORMAT = 2
"""Of the arrays and attributes of a survey; others are rejected."""
METRICS = {
    "relative": "relative manipulability without each set of joints",
    "speed": "the speed in every direction, before and after",
    "depth": "how many joints, whichever they are, can fail without the loss of a direction",
    "reach": "the share of poses that is reached, before and after",
    "positions": "the positions around the arm that are reached, before and after each single loss",
}
USUAL = ("relative", "speed", "depth")
"""Metrics where none are named."""
SLOW = {"speed", "depth"}
"""Those that go over all facets of the velocities of a configuration."""
KEEP = ("reduced", "all")
CHUNK, SMALL_CHUNK = 250_000, 2_000
"""Configurations of a chunk; the second where each takes longer or more memory: searches, ``keep="all"``, long arms."""
BLOCK = 8192
"""Configurations at once."""
MOST = 10**13
"""Configurations of a survey."""


@dataclass(frozen=True)
class Plan:
    """A survey before it runs.

    Args:
        arm: the arm.
        task: the task.
        kind: "samples", "grid", "poses" or "q".
        count: configurations.
        grid: steps of each joint; () unless it is a grid.
        given: poses (count, 4, 4) [m] or configurations (count, n) [rad, m]; None unless there are some.
        digest: of these.
        sets: joints that fail together, by index and by size.
        k: the largest number of joints that fail.
        every: whether these are all sets of up to k joints.
        metrics: words of METRICS.
        seed: of random configurations.
        chunk: configurations of a chunk.
        keep: "reduced" or "all".
        starts: most searches for a pose.
    """

    arm: Arm
    task: Task
    kind: str
    count: int
    grid: tuple[int, ...]
    given: FloatArray | None
    digest: str
    sets: tuple[tuple[int, ...], ...]
    k: int
    every: bool
    metrics: tuple[str, ...]
    seed: int
    chunk: int
    keep: str
    starts: int

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.count // self.chunk)

    def size(self, index: int) -> int:
        """Configurations of a chunk."""
        return min(self.chunk, self.count - index * self.chunk)

    def own(self, index: int) -> FloatArray | None:
        """The poses or configurations of a chunk, where they are given."""
        return None if self.given is None else self.given[index * self.chunk : index * self.chunk + self.size(index)]

    def alone(self) -> Plan:
        """The plan without the poses or configurations, which may be large."""
        return replace(self, given=None)

    @property
    def singles(self) -> tuple[int, ...]:
        """The joints that fail alone, by index."""
        return tuple(joints[0] for joints in self.sets if len(joints) == 1)

    @cached_property
    def region(self) -> Region | None:
        """Where the survey looks for positions; None without that metric."""
        return region_of(self.arm, self.task) if "positions" in self.metrics else None

    def blocks(self, index: int) -> Iterator[FloatArray]:
        """The configurations (B, n) of a chunk [rad, m], random or of the grid, some at a time."""
        low, high = sampling_range(self.arm.kinds, *self.arm.position_limits.T)
        random = np.random.default_rng([self.seed, index])
        for first in range(0, self.size(index), BLOCK):
            count = min(BLOCK, self.size(index) - first)
            if self.kind == "samples":
                yield low + (high - low) * random.random((count, self.arm.n))
            else:
                yield self._of_grid(index * self.chunk + first, count, low, high)

    def goals(self, index: int) -> Iterator[FloatArray]:
        """Random configurations (B, n) whose poses are to be reached [rad, m], one for each of a chunk."""
        low, high = sampling_range(self.arm.kinds, *self.arm.position_limits.T)
        random = np.random.default_rng([self.seed, index, 1])
        for first in range(0, self.size(index), BLOCK):
            yield low + (high - low) * random.random((min(BLOCK, self.size(index) - first), self.arm.n))

    def _of_grid(self, first: int, count: int, low: FloatArray, high: FloatArray) -> FloatArray:
        places = np.stack(np.unravel_index(np.arange(first, first + count), self.grid), axis=1)
        turns = (self.arm.kinds == 0) & ~np.isfinite(self.arm.position_limits).any(axis=1)
        steps = np.array(self.grid)
        gaps = np.where(turns, steps, steps - 1)
        shares = np.where(gaps > 0, places / np.maximum(gaps, 1), 0.5)
        return np.ascontiguousarray(low + (high - low) * shares)

    @property
    def document(self) -> dict[str, Any]:
        """What makes a survey this one, in JSON's own types."""
        names = self.arm.joint_names
        sets: Any = {"k": self.k} if self.every else [[names[joint] for joint in joints] for joints in self.sets]
        return {
            "robot": hashlib.sha256(settings_text(self.arm).encode()).hexdigest(),
            "task": json.loads(settings_text(self.task)),
            "configurations": {"kind": self.kind, "count": self.count, "grid": list(self.grid), "poses": self.digest},
            "failures": sets,
            "metrics": list(self.metrics),
            "seed": self.seed,
            "chunk": self.chunk,
            "keep": self.keep,
            "starts": self.starts,
        }


def plan_of(
    arm: Any,
    *,
    samples: Any,
    grid: Any,
    poses: Any,
    q: Any,
    k: Any,
    failures: Any,
    metrics: Any,
    task: Any,
    seed: Any,
    chunk: Any,
    keep: Any,
    starts: Any,
) -> Plan:
    """A plan from the arguments of ``survey``; raises InputError where one is invalid."""
    if not isinstance(arm, Arm):
        raise InputError("arm", _door.describe(arm), "an Arm")
    checked_task(task)
    chosen = Task() if task is None else task
    words = _metrics(arm, chosen, metrics)
    kind, count, steps, given = _configurations(arm, samples, grid, poses, q)
    sets, most = _sets(arm, k, failures)
    kept = _door.choice("keep", keep, KEEP)
    long = bool(SLOW & set(words)) and facets(arm.n, chosen.m) > MOST_NORMALS
    slow = long or kept == "all" or kind == "poses" or bool({"reach", "positions"} & set(words))
    plan = Plan(
        arm=arm,
        task=chosen,
        kind=kind,
        count=count,
        grid=steps,
        given=given,
        digest="" if given is None else hashlib.sha256(given.tobytes()).hexdigest(),
        sets=sets,
        k=most,
        every=failures is None,
        metrics=words,
        seed=_door.count("seed", seed, minimum=0),
        chunk=min((SMALL_CHUNK if slow else CHUNK) if chunk is None else _door.count("chunk", chunk), count),
        keep=kept,
        starts=_door.count("starts", starts),
    )
    _ = plan.region  # raises where there is none for this task
    return plan


def _metrics(arm: Arm, task: Task, metrics: Any) -> tuple[str, ...]:
    many = facets(arm.n, task.m)
    if metrics is None:
        return USUAL if many <= MOST_FACETS else tuple(word for word in USUAL if word not in SLOW)
    words = _words(metrics)
    if SLOW & set(words) and many > MOST_FACETS:
        got = f"speed or depth of an arm with {arm.n} joints and {task.m} rows, {many:,} facets a configuration"
        raise InputError(
            "metrics", got, f"at most {MOST_FACETS:,}, which 31 joints stay below in six rows; the others have no limit"
        )
    return words


def _words(metrics: Any) -> tuple[str, ...]:
    given = [metrics] if isinstance(metrics, str) else metrics
    if not isinstance(given, Iterable) or not (listed := list(given)):
        raise InputError("metrics", _door.describe(metrics), f"some of {', '.join(METRICS)}")
    words = {_door.choice("metrics", word, tuple(METRICS)) for word in listed}
    return tuple(word for word in METRICS if word in words)


def _configurations(
    arm: Arm, samples: Any, grid: Any, poses: Any, q: Any
) -> tuple[str, int, tuple[int, ...], FloatArray | None]:
    """Their kind and number, the steps of a grid, and poses or configurations that are given."""
    wanted = {"samples": samples, "grid": grid, "poses": poses, "q": q}
    named = [name for name, value in wanted.items() if value is not None]
    if len(named) > 1:
        raise InputError(named[1], f"a value beside {named[0]}", f"one of {', '.join(wanted)}")
    steps: tuple[int, ...] = ()
    given = None
    if grid is not None:
        if isinstance(grid, str) or not isinstance(grid, Iterable | int | np.integer):
            raise InputError("grid", _door.describe(grid), "a number of steps, or one for each joint")
        listed = list(grid) if isinstance(grid, Iterable) else [grid] * arm.n
        steps = tuple(_door.count("grid", step) for step in listed)
        if len(steps) != arm.n:
            raise InputError("grid", f"{len(steps)} numbers", f"a number of steps, or {arm.n}, one for each joint")
        count = math.prod(steps)
    elif poses is not None:
        given = _door.array("poses", poses, "rigid transforms (N, 4, 4)")
        if given.ndim != 3 or given.shape[1:] != (4, 4) or not len(given):
            raise InputError("poses", _door.describe(poses), "rigid transforms (N, 4, 4)")
        count = len(given)
    elif q is not None:
        given = _door.array("q", q, f"configurations (N, {arm.n})")
        if given.ndim != 2 or given.shape[1] != arm.n or not len(given):
            raise InputError("q", _door.describe(q), f"configurations (N, {arm.n})")
        count = len(given)
    else:
        count = _door.count("samples", 100_000 if samples is None else samples)
    if count > MOST:
        raise InputError(named[0], f"{count} configurations", f"at most {MOST}")
    return named[0] if named else "samples", count, steps, given


def _sets(arm: Arm, k: Any, failures: Any) -> tuple[tuple[tuple[int, ...], ...], int]:
    """Sets of joints that fail together, by size, and the largest size."""
    if failures is None:
        most = _door.count("k", min(2, arm.n) if k is None else k)
        if most > arm.n:
            raise InputError("k", f"{most}", f"at most the {arm.n} joints of the arm")
        return tuple(all_sets(arm.n, most)), most
    if k is not None:
        raise InputError("k", _door.describe(k), "None beside failures, which name the sets")
    if isinstance(failures, str) or not isinstance(failures, Iterable):
        raise InputError("failures", _door.describe(failures), 'sets of joints, such as ["j1", ("j2", "j4")]')
    found: dict[tuple[int, ...], None] = {}
    for one in failures:
        joints: list[Any] = list(one) if isinstance(one, Iterable) and not isinstance(one, str) else [one]
        found[tuple(sorted({arm.joint_index(joint) for joint in joints}))] = None
    sets = sorted(found, key=lambda joints: (len(joints), joints))
    if not sets or not sets[0] or len(sets) > MOST_SETS:
        raise InputError("failures", f"{len(sets)} sets", f"1 to {MOST_SETS} sets of at least one joint")
    all_sets(arm.n, len(sets[-1]))  # which one pass over the sets goes through
    return tuple(sets), len(sets[-1])
