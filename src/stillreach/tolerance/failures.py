"""Failures to rehearse: the kinds by word, and the cases that they make with joints and moments."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach.errors import InputError
from stillreach.faults import Confined, Derated, Fault, FaultKind, Locked, OneWay, Runaway
from stillreach.simulation import Scenario

Made = Callable[[Scenario, int, float], FaultKind]
"""A fault of a joint (index) that stands at a value [rad, m] when it fails."""

SLOWED, CREEP = 0.3, 0.1
ROOM = np.deg2rad(5.0), 0.05
"""[rad], [m] to either side that a confined joint can still move."""
MOST_CASES = 10_000_000


def _confined(scenario: Scenario, joint: int, at: float) -> FaultKind:
    room = ROOM[int(scenario.arm.kinds[joint])]
    return Confined(at - room, at + room)


def _given(kind: FaultKind, scenario: Scenario, joint: int, at: float) -> FaultKind:
    return kind


def _runaway(sign: float) -> Made:
    def made(scenario: Scenario, joint: int, at: float) -> FaultKind:
        limit = float(scenario.controller().velocity_limits[joint, 1])
        if not np.isfinite(limit):
            name = scenario.arm.joint_names[joint]
            raise InputError("kinds", f"runaway for {name}, which has no velocity limit", "a limit, or a Runaway(rate)")
        return Runaway(sign * CREEP * limit)

    return made


KINDS: dict[str, tuple[Made, str]] = {
    "locked": (partial(_given, Locked()), "stands still"),
    "derated": (partial(_given, Derated(SLOWED)), "at 30 % of its speed"),
    "confined": (_confined, "5 deg or 50 mm to either side of where it stands"),
    "one-way+": (partial(_given, OneWay(1.0)), "forwards only"),
    "one-way-": (partial(_given, OneWay(-1.0)), "backwards only"),
    "runaway+": (_runaway(1.0), "runs at 10 % of its limit, forwards"),
    "runaway-": (_runaway(-1.0), "runs at 10 % of its limit, backwards"),
}
"""The kinds of failures by word, each with its meaning."""


@dataclass(frozen=True)
class Failures:
    """The cases of a rehearsal: each kind for each set of joints at each tick.

    Args:
        kinds: (K,) their names.
        made: (K,) what makes the fault of a joint.
        sets: (S,) indices of the joints that fail together.
        ticks: (T,) at which they fail, rising.
        known_after: [s] until the controller knows; inf: it never does.
    """

    kinds: tuple[str, ...]
    made: tuple[Made, ...]
    sets: tuple[tuple[int, ...], ...]
    ticks: npt.NDArray[np.int64]
    known_after: float

    @classmethod
    def of(cls, scenario: Scenario, kinds: Any, k: Any, joints: Any, onsets: Any, known_after: Any) -> Failures:
        """The cases of a rehearsal; raises InputError where an argument is invalid."""
        words, made = _kinds(kinds)
        own = {scenario.arm.joint_index(fault.joint) for fault in scenario.faults}
        chosen = [joint for joint in range(scenario.arm.n) if joint not in own]
        if joints is not None:
            if isinstance(joints, str) or not isinstance(joints, Iterable):
                raise InputError("joints", _door.describe(joints), "a list of names or indices")
            chosen = list(dict.fromkeys(scenario.arm.joint_index(joint) for joint in joints))
        count = _door.count("k", k)
        if count > len(chosen):
            raise InputError("k", f"{count}", f"at most the {len(chosen)} joints that may fail")
        ticks = _ticks(scenario, onsets)
        sets = tuple(combinations(chosen, count))
        if len(words) * len(sets) * len(ticks) > MOST_CASES:
            got = f"{len(words)} kinds x {len(sets)} sets of joints x {len(ticks)} moments"
            raise InputError("onsets", got, f"at most {MOST_CASES} failures")
        delay = _door.positive("known_after", known_after, or_zero=True, allow_inf=True)
        return cls(words, made, sets, ticks, delay)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Kinds, sets of joints, moments."""
        return len(self.kinds), len(self.sets), len(self.ticks)

    def faults(self, scenario: Scenario, place: tuple[int, int, int], q: np.ndarray) -> list[Fault]:
        """The faults of a case, whose joints stand at q (n,)."""
        at = float(self.ticks[place[2]]) * scenario.period
        broken = self.broken(scenario, place, q)
        return [Fault(joint, at=at, kind=kind, known_after=self.known_after) for joint, kind in broken]

    def broken(self, scenario: Scenario, place: tuple[int, int, int], q: np.ndarray) -> Iterator[tuple[int, FaultKind]]:
        """The joints that fail in a case, and how."""
        make = self.made[place[0]]
        return ((joint, make(scenario, joint, float(q[joint]))) for joint in self.sets[place[1]])


def _kinds(kinds: Any) -> tuple[tuple[str, ...], tuple[Made, ...]]:
    given = [kinds] if isinstance(kinds, str | FaultKind) else kinds
    choices = f"words of {', '.join(KINDS)}, or faults such as Derated(0.2)"
    if not isinstance(given, Iterable):
        raise InputError("kinds", _door.describe(kinds), choices)
    found: dict[str, Made] = {}
    for kind in given:
        if isinstance(kind, FaultKind):
            found[repr(kind)] = partial(_given, kind)
        elif isinstance(kind, str) and kind in KINDS:
            found[kind] = KINDS[kind][0]
        else:
            raise InputError("kinds", _door.describe(kind), choices)
    if not found:
        raise InputError("kinds", "none", choices)
    return tuple(found), tuple(found.values())


def _ticks(scenario: Scenario, onsets: Any) -> npt.NDArray[np.int64]:
    """The ticks at which joints fail."""
    last = scenario.steps
    if isinstance(onsets, int | np.integer) and not isinstance(onsets, bool):
        count = min(_door.count("onsets", onsets), last)
        return np.unique(np.floor(np.linspace(0, last, count, endpoint=False)).astype(np.int64))
    moments = _door.array("onsets", onsets, "a number of moments, or moments [s]")
    if moments.ndim != 1 or not len(moments) or not np.all((moments >= 0.0) & (moments <= last * scenario.period)):
        got = _door.describe(onsets) if moments.ndim != 1 else f"{moments.tolist()[:5]}"
        raise InputError("onsets", got, f"moments from 0 to the end at {last * scenario.period:g} s")
    return np.unique([scenario.tick_at(float(at)) for at in moments])
