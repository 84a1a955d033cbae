"""Lines, circles and waypoints: courses whose shape is given by a few points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._forms import TIME, Either, Number, Word
from stillreach._kinds import key
from stillreach._lists import NOT_ALL_ZERO, RISING, List
from stillreach._reading import Reading
from stillreach._rotations import log, orientation
from stillreach.errors import InputError
from stillreach.simulation.course import (
    PROFILE_KEY,
    RAMP_KEY,
    RELATIVE_KEY,
    Arc,
    Course,
    Legs,
    turned_and_shifted,
)
from stillreach.simulation.orientation import ORIENTATION
from stillreach.simulation.profile import PROFILES, RAMP, checked_profile

ATTITUDES = ("keep", "follow")
MOST_POINTS = 2000
POINT = List(*[Number("length")] * 3)
DURATION = key(TIME, "How long")


@dataclass(frozen=True, eq=False)
class Waypoints(Course):
    """From point to point on straight lines, from attitude to attitude by the shortest turn.

    Args:
        points: (K, 3) [m] in the base frame.
        orientations: K attitudes, each a matrix (3, 3), a rotation vector (3,) [rad] or None (as before it); None keeps
            the attitude throughout.
        times: (K,) [s] since the beginning, rising: when each is reached.
        duration: [s] of the whole instead, shared among the legs by their length; a turn of 1 rad counts as 1 m.
        profile: speed on each leg: "constant" (passes through the points), "trapezoidal" or "minimum-jerk" (stop
            there).
        ramp: part of each leg's time in which "trapezoidal" speeds up, and slows down again.
        relative: points are shifts and orientations are turns from the pose at the beginning, along base axes.

    Raises:
        InputError: if an argument is invalid, or not exactly one of times and duration is given.
    """

    word = "waypoints"

    points: FloatArray = field(metadata=key(List(POINT, most=MOST_POINTS), "The points"))
    orientations: tuple[FloatArray | None, ...] | None = field(
        metadata=key(
            List(Either(ORIENTATION, Word("keep", none="keep")), least=0, most=MOST_POINTS),
            'An attitude, or "keep", for each point',
        )
    )
    times: FloatArray | None = field(
        metadata=key(List(TIME, most=MOST_POINTS, check=RISING), "When each point is reached, since this motion began")
    )
    duration: float = field(metadata=key(TIME, "How long in all, in place of times"))
    profile: str = field(metadata=key(Word(*PROFILES), "Speed on each leg; the last two stop at each point"))
    ramp: float = field(metadata=RAMP_KEY)
    relative: bool = field(metadata=RELATIVE_KEY)

    def __init__(
        self,
        points: npt.ArrayLike,
        *,
        orientations: Sequence[npt.ArrayLike | None] | None = None,
        times: npt.ArrayLike | None = None,
        duration: float | None = None,
        profile: str = "constant",
        ramp: float = RAMP,
        relative: bool = False,
    ) -> None:
        places = _door.matrix("points", points, (None, 3))
        if len(places) == 0:
            raise InputError("points", "none", "one or more points (K, 3)")
        if (times is None) == (duration is None):
            raise InputError("times", "both" if times is not None else "neither", "either times or a duration")
        moments = None if times is None else rising("times", times, len(places), above=0.0)
        length = _door.positive("duration", duration) if moments is None else float(moments[-1])
        turns = _orientations(orientations, len(places))
        set_fields(self, points=places, orientations=turns, times=moments, duration=length, relative=relative)
        _set_speed(self, profile, ramp)

    def plan(self, T_start: FloatArray) -> Legs:
        """The legs from a pose (4, 4) [m]."""
        moves = np.tile(np.eye(4), (len(self.points), 1, 1))
        moves[:, :3, 3] = self.points
        attitude = np.eye(3) if self.relative else T_start[:3, :3]
        for move, turn in zip(moves, self.orientations or (None,) * len(moves), strict=True):
            attitude = attitude if turn is None else turn
            move[:3, :3] = attitude
        poses = np.concatenate([T_start[None], turned_and_shifted(T_start, moves) if self.relative else moves])
        times = self._shared(poses) if self.times is None else np.concatenate([[0.0], self.times])
        return Legs(times, poses, self.profile, self.ramp)

    def _shared(self, poses: FloatArray) -> FloatArray:
        """When each pose is reached, by the length of the legs; a leg that leads nowhere takes next to no time."""
        shifts = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
        turns = np.linalg.norm(log(poses[1:, :3, :3] @ np.swapaxes(poses[:-1, :3, :3], 1, 2)), axis=1)
        lengths = shifts + turns
        lengths += 1e-9 * np.max(lengths) + (np.max(lengths) == 0.0)
        times = np.concatenate([[0.0], np.cumsum(lengths)])
        shared: FloatArray = times * (self.duration / times[-1])
        return shared


@dataclass(frozen=True, eq=False)
class Line(Course):
    """Straight to a point, turning evenly to an attitude by the shortest way.

    Args:
        to: (3,) [m] in the base frame; None stays at the point.
        orientation: a matrix (3, 3) or a rotation vector (3,) [rad]; None keeps the attitude.
        duration: [s].
        profile: speed along it: "constant", "trapezoidal" or "minimum-jerk".
        ramp: part of the time in which "trapezoidal" speeds up, and slows down again.
        relative: ``to`` is a shift and ``orientation`` a turn from the pose at the beginning, along base axes.

    Raises:
        InputError: if an argument is invalid.
    """

    word = "line"
    goal = "to"

    to: FloatArray | None = field(metadata=key(POINT, "The point; stays there if absent"))
    orientation: FloatArray | None = field(metadata=key(ORIENTATION, "The attitude at the end; kept if absent"))
    duration: float = field(metadata=DURATION)
    profile: str = field(metadata=PROFILE_KEY)
    ramp: float = field(metadata=RAMP_KEY)
    relative: bool = field(metadata=RELATIVE_KEY)

    def __init__(
        self,
        to: npt.ArrayLike | None = None,
        *,
        duration: float,
        orientation: npt.ArrayLike | None = None,
        profile: str = "constant",
        ramp: float = RAMP,
        relative: bool = False,
    ) -> None:
        point = None if to is None else _door.vector("to", to, 3, one_for_all=False, labels=_door.POINT)
        turn = None if orientation is None else _turn("orientation", orientation)
        set_fields(self, to=point, orientation=turn, duration=_door.positive("duration", duration), relative=relative)
        _set_speed(self, profile, ramp)

    @classmethod
    def read(cls, values: dict[str, Any], reading: Reading) -> Self:
        """From a file; there it leads somewhere."""
        if "to" not in values and "orientation" not in values:
            raise InputError("to", "missing key", "a point to go to, an orientation, or both")
        return super().read(values, reading)

    def plan(self, T_start: FloatArray) -> Legs:
        """The one leg from a pose (4, 4) [m]."""
        here = np.zeros(3) if self.relative else T_start[:3, 3]
        way = Waypoints(
            np.array([here if self.to is None else self.to]),
            orientations=(self.orientation,),
            duration=self.duration,
            profile=self.profile,
            ramp=self.ramp,
            relative=self.relative,
        )
        return way.plan(T_start)


@dataclass(frozen=True, eq=False)
class Circle(Course):
    """Round an axis, from wherever the point is; its distance from the axis is the radius.

    Args:
        centre: (3,) [m] a point on the axis, in the base frame.
        axis: (3,) its direction; the turn is right-handed about it.
        angle: [rad] of the whole turn: 2π is once round, more or negative angles will do.
        duration: [s].
        attitude: "keep", or "follow" (the tool turns with the point).
        profile: speed along it: "constant", "trapezoidal" or "minimum-jerk".
        ramp: part of the time in which "trapezoidal" speeds up, and slows down again.
        relative: ``centre`` is a shift from the point at the beginning, along base axes.

    Raises:
        InputError: if an argument is invalid.
    """

    word = "circle"
    goal = "centre"

    centre: FloatArray = field(metadata=key(POINT, "A point on the axis"))
    axis: FloatArray = field(
        metadata=key(
            List(*[Number()] * 3, check=NOT_ALL_ZERO), "Direction of the axis; the turn is right-handed about it"
        )
    )
    angle: float = field(metadata=key(Number("angle"), "How far; once round if absent"))
    duration: float = field(metadata=DURATION)
    attitude: str = field(metadata=key(Word(*ATTITUDES), "Whether the tool turns with the circle"))
    profile: str = field(metadata=PROFILE_KEY)
    ramp: float = field(metadata=RAMP_KEY)
    relative: bool = field(metadata=RELATIVE_KEY)

    def __init__(
        self,
        *,
        centre: npt.ArrayLike,
        axis: npt.ArrayLike,
        duration: float,
        angle: float = 2.0 * np.pi,
        attitude: str = "keep",
        profile: str = "constant",
        ramp: float = RAMP,
        relative: bool = False,
    ) -> None:
        set_fields(
            self,
            centre=_door.vector("centre", centre, 3, one_for_all=False, labels=_door.POINT),
            axis=_door.unit_vector("axis", axis),
            angle=_door.scalar("angle", angle),
            duration=_door.positive("duration", duration),
            attitude=_door.choice("attitude", attitude, ATTITUDES),
            relative=relative,
        )
        _set_speed(self, profile, ramp)

    def plan(self, T_start: FloatArray) -> Arc:
        """The arc from a pose (4, 4) [m].

        Raises:
            InputError: the point is on the axis.
        """
        point = T_start[:3, 3]
        centre = point + self.centre if self.relative else self.centre
        off = point - centre
        radius = float(np.linalg.norm(off - (off @ self.axis) * self.axis))
        if radius <= 1e-9 * (1.0 + float(np.linalg.norm(off))):
            raise InputError("centre", "a point on an axis through the start of the circle", "a circle with a radius")
        return Arc(
            T_start, centre, self.axis, self.angle, self.duration, self.profile, self.ramp, self.attitude == "follow"
        )


def set_fields(course: Course, **fields: Any) -> None:
    """Fill the fields of a frozen course; ``relative`` is true or false and nothing else."""
    if not isinstance(fields["relative"], bool):
        raise InputError("relative", _door.describe(fields["relative"]), "True or False")
    for name, value in fields.items():
        object.__setattr__(course, name, value)


def _set_speed(course: Course, profile: str, ramp: float) -> None:
    word, number = checked_profile(profile, ramp)
    object.__setattr__(course, "profile", word)
    object.__setattr__(course, "ramp", number)


def rising(name: str, value: npt.ArrayLike, n: int, *, above: float = -np.inf) -> FloatArray:
    """Times (n,) [s] that rise strictly, the first above (or, with no bound, at) a time; InputError otherwise."""
    times = _door.vector(name, value, n, one_for_all=False)
    falls = np.flatnonzero(np.diff(np.concatenate([[above], times])) <= 0.0)
    if len(falls):
        raise InputError(name, f"{times[falls[0]]:g} at index {falls[0]}", f"{n} rising times above {above:g} s")
    return times


def _orientations(value: Any, count: int) -> tuple[FloatArray | None, ...] | None:
    """One attitude or None for each point."""
    if value is None:
        return None
    if not isinstance(value, list | tuple | np.ndarray) or len(value) != count:
        raise InputError("orientations", _door.describe(value), f"{count} orientations, one for each point")
    return tuple(None if turn is None else _turn(f"orientations[{k}]", turn) for k, turn in enumerate(value))


def _turn(name: str, value: Any) -> FloatArray:
    return _door.frozen(orientation(name, value))
