"""Courses: motions that say where the tool is to be at each time, from the pose that they begin at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self

import numpy as np

from stillreach._door import FloatArray
from stillreach._forms import Flag, Number, Word
from stillreach._kinds import Kind, key
from stillreach._messages import shown
from stillreach._reading import Reading
from stillreach._rotations import exp, log
from stillreach.errors import InputError
from stillreach.simulation.profile import PROFILES, progress

ARC_POINTS = 3601
PROFILE_KEY = key(Word(*PROFILES), "Speed along it; the last two start and end at rest")
RAMP_KEY = key(
    Number(above=0.0, most=0.5), "Part of the time in which trapezoidal speeds up, and slows down again; 0.25 if absent"
)
RELATIVE_KEY = key(Flag(), "Positions are shifts and orientations turns from the pose at the beginning")


class Plan(Protocol):
    """A course from a known start."""

    @property
    def knots(self) -> FloatArray:
        """(K,) times [s] after the beginning, among which the point is at its farthest from the base."""

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses (K, 4, 4) [m] and twists (K, 6) [m/s, rad/s] at times (K,) [s] since the course began."""


class Course(Kind):
    """Base of the motions that lead from pose to pose."""

    duration: float
    goal: ClassVar[str] = "points"
    """The argument that says where it leads."""

    def plan(self, T_start: FloatArray) -> Plan:
        """The course from a pose (4, 4) [m].

        Raises:
            InputError: it cannot begin there.
        """
        raise TypeError(f"{type(self).__name__} is a base class; use one of the courses")

    @classmethod
    def read(cls, values: dict[str, Any], reading: Reading) -> Self:
        """From a file; there a ramp goes with the profile that has one."""
        if "ramp" in values and values.get("profile") != "trapezoidal":
            raise InputError("ramp", shown(values["ramp"]), 'none, or profile = "trapezoidal"')
        return super().read(values, reading)


@dataclass(frozen=True, eq=False)
class Legs:
    """From pose to pose: the point on straight lines, the attitude about one axis a leg (the shortest turn).

    Args:
        times: (K + 1,) [s], rising, the first 0: when each pose is reached.
        poses: (K + 1, 4, 4) [m].
        profile, ramp: of each leg.
    """

    times: FloatArray
    poses: FloatArray
    profile: str
    ramp: float

    @property
    def knots(self) -> FloatArray:
        """When each pose is reached; in between, the point is on straight lines."""
        return self.times[1:]

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses and twists at some times."""
        leg = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        length = self.times[leg + 1] - self.times[leg]
        way, slope = progress(self.profile, self.ramp, np.clip((times - self.times[leg]) / length, 0.0, 1.0))
        first, last = self.poses[leg], self.poses[leg + 1]
        shift = last[:, :3, 3] - first[:, :3, 3]
        turn = log(last[:, :3, :3] @ np.swapaxes(first[:, :3, :3], 1, 2))
        poses = first.copy()
        poses[:, :3, 3] += way[:, None] * shift
        poses[:, :3, :3] = exp(way[:, None] * turn) @ first[:, :3, :3]
        return poses, np.hstack([shift, turn]) * (slope / length)[:, None]


@dataclass(frozen=True, eq=False)
class Arc:
    """The point on a circle; the attitude turns with it or stays.

    Args:
        T_start: (4, 4) [m].
        centre: (3,) [m] a point on the axis.
        axis: (3,) direction, of length 1; the turn is right-handed about it.
        angle: [rad] of the whole turn.
        duration: [s].
        profile, ramp: of the turn.
        follow: whether the attitude turns with the point.
    """

    T_start: FloatArray
    centre: FloatArray
    axis: FloatArray
    angle: float
    duration: float
    profile: str
    ramp: float
    follow: bool

    @property
    def knots(self) -> FloatArray:
        """Times that are close to each other: the farthest point can be anywhere."""
        return np.linspace(0.0, self.duration, ARC_POINTS)[1:]

    def at(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses and twists at some times."""
        way, slope = progress(self.profile, self.ramp, np.clip(times / self.duration, 0.0, 1.0))
        turns = exp((way * self.angle)[:, None] * self.axis)
        arms = turns @ (self.T_start[:3, 3] - self.centre)
        poses = np.tile(self.T_start, (len(times), 1, 1))
        poses[:, :3, 3] = self.centre + arms
        if self.follow:
            poses[:, :3, :3] = turns @ self.T_start[:3, :3]
        rate = (slope * self.angle / self.duration)[:, None] * self.axis
        return poses, np.hstack([np.cross(rate, arms), rate if self.follow else np.zeros_like(rate)])


def turned_and_shifted(T_start: FloatArray, poses: FloatArray) -> FloatArray:
    """Where moves (K, 4, 4) lead from a pose: shifts and turns along base axes, p = p_start + d, R = R_move R_start."""
    led = poses.copy()
    led[:, :3, 3] += T_start[:3, 3]
    led[:, :3, :3] = poses[:, :3, :3] @ T_start[:3, :3]
    return led
