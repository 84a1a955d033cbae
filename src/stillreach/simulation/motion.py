"""What the tool is told to do over time: constant twists and courses one after the other, or a function of time.

A commanded twist is [v; w] along base axes (see ``stillreach.simulation.path`` for where it leads).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._forms import TIME, Number
from stillreach._kinds import Kind, key
from stillreach._lists import List
from stillreach.errors import InputError
from stillreach.simulation.course import Course
from stillreach.simulation.pose_table import PoseTable
from stillreach.simulation.shapes import Circle, Line, Waypoints

TICK_TOLERANCE = 1e-9
"""A moment this fraction of a period before a tick counts as that tick: 0.1 + 0.2 is later than 0.3."""


@dataclass(frozen=True, eq=False)
class ConstantTwist(Kind):
    """A constant commanded twist, held for a time.

    Args:
        twist: (6,) [v; w] along base axes [m/s, rad/s].
        duration: how long it is held [s]; None is to the end of the scenario.

    Raises:
        InputError: if an argument is invalid.
    """

    word = "twist"

    twist: FloatArray = field(
        metadata=key(
            List(*[Number("length/s")] * 3, *[Number("angle/s")] * 3), "vx, vy, vz, wx, wy, wz, along base axes"
        )
    )
    duration: float | None = field(metadata=key(TIME, "How long; to the end if absent (the last motion only)"))

    def __init__(self, twist: npt.ArrayLike, duration: float | None = None) -> None:
        object.__setattr__(self, "twist", _door.vector("twist", twist, 6, labels=_door.TWIST))
        object.__setattr__(self, "duration", None if duration is None else _door.positive("duration", duration))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ConstantTwist):
            return NotImplemented
        return self.duration == other.duration and np.array_equal(self.twist, other.twist)

    def __hash__(self) -> int:
        return hash((self.duration, self.twist.tobytes()))

    def __repr__(self) -> str:
        held = "" if self.duration is None else f", duration={self.duration:g}"
        return f"ConstantTwist([{', '.join(f'{value:g}' for value in self.twist)}]{held})"


@dataclass(frozen=True, eq=False, repr=False)
class Wait(ConstantTwist):
    """The tool stays where it is: a constant twist of zeros.

    Args:
        duration: how long [s].

    Raises:
        InputError: if an argument is invalid.
    """

    word = "wait"

    def __init__(self, duration: float) -> None:
        super().__init__(np.zeros(6), _door.positive("duration", duration))


MOTIONS: tuple[type[ConstantTwist | Course], ...] = (ConstantTwist, Wait, Line, Circle, Waypoints, PoseTable)
"""Every motion that is not a function of time."""

Motion: TypeAlias = ConstantTwist | Course | Callable[[float], npt.ArrayLike]
"""A part of a motion: a held twist, a course, or a function from the time since
the scenario's start [s] to a twist (6,)."""


def checked_motion(motion: Any) -> tuple[Motion, ...]:
    """The parts of a motion, from one part or several.

    Args:
        motion: one of MOTIONS, a function of time, or a sequence of twists and courses. The last part may be
            a function or a ConstantTwist without a duration.

    Raises:
        InputError: it is something else, or a part follows one that never ends.
    """
    names = ", ".join(kind.__name__ for kind in MOTIONS)
    expected = f"a {names}, a function of time, or a list of these whose last part may be a function"
    if isinstance(motion, ConstantTwist | Course) or callable(motion):
        return (motion,)
    if not isinstance(motion, Iterable) or isinstance(motion, str | np.ndarray):
        raise InputError("motion", _door.describe(motion), expected)
    parts = tuple(motion)
    for place, part in enumerate(parts):
        if not (isinstance(part, ConstantTwist | Course) or callable(part)):
            raise InputError("motion", f"{_door.describe(part)} at place {place}", expected)
        if np.isinf(_length(part)) and place < len(parts) - 1:
            raise InputError("motion", f"a part without an end at place {place} of {len(parts)}", expected)
    return parts


def ends(motion: Sequence[Motion]) -> FloatArray:
    """(parts,) [s] when each part ends; the last is infinite where it has no end."""
    return np.cumsum([_length(part) for part in motion])


def _length(part: Motion) -> float:
    """How long a part lasts [s]."""
    duration = part.duration if isinstance(part, ConstantTwist | Course) else None
    return np.inf if duration is None else float(duration)


def commands(motion: Sequence[Motion], times: FloatArray, part: int) -> FloatArray:
    """The commanded twists at some times that all lie in one part, which is no course.

    Args:
        motion: the parts.
        times: (K,) [s].
        part: index of the part; ``len(motion)`` is the rest after the last end.

    Returns:
        (K, 6) [m/s, rad/s].

    Raises:
        InputError: a function of time answered with something else than 6 finite numbers.
    """
    if part >= len(motion):
        return np.zeros((len(times), 6))
    item = motion[part]
    if isinstance(item, Course):
        raise TypeError("a course is planned, not sampled")
    if isinstance(item, ConstantTwist):
        return np.repeat(item.twist[None, :], len(times), axis=0)
    # one number must not stand for six here
    rows = [
        _door.vector(f"motion({t:g})", _called(item, float(t)), 6, one_for_all=False, labels=_door.TWIST) for t in times
    ]
    return np.array(rows)


def _called(function: Callable[[float], npt.ArrayLike], t: float) -> npt.ArrayLike:
    """A user's function at a time; what it raises carries a note of where."""
    try:
        return function(t)
    except Exception as error:
        error.add_note(f"raised by the scenario's motion at t = {t:g} s")
        raise
