"""An arm as shapes to draw: links as capsules, joints as cylinders along their axes."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach._rotations import shortest_turn_from_z
from stillreach.arm.placements import moved, translation, turned
from stillreach.arm.structure import Structure

WIDTH = 0.012
"""Radius of a link, as a share of the arm's length."""
LEAST_LENGTH = 1e-6
"""[m] An arm below this length is drawn as if it were 1 m long."""


class Shape(NamedTuple):
    """A part of an arm to draw.

    Attributes:
        name: of the joint, or ``link 1``, ``link 2``, … from the base to the tool.
        joint: index of the joint that a cylinder stands for; None: the shape is a capsule, a link.
        pose: (4, 4) [m] of its middle in the base frame; its length lies along z.
        length: [m] a capsule's without its ends; 0 where two joints are at one point.
        radius: [m]
    """

    name: str
    joint: int | None
    pose: FloatArray
    length: float
    radius: float

    @property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """The two ends of the length, (3,) [m] each."""
        half = 0.5 * self.length * self.pose[:3, 2]
        return self.pose[:3, 3] - half, self.pose[:3, 3] + half


def shapes(arm: Structure, q: FloatArray) -> list[Shape]:
    """The links from the base to the tool, then the joints, at q (n,) [rad] or [m]."""
    points, axes = stations(arm, q)
    radius = thickness(points)
    links = [
        _between(f"link {k}", None, start, end, radius) for k, (start, end) in enumerate(pairwise(points), start=1)
    ]
    joints = [
        _between(
            moving.joint.name, moving.leader, point - 1.9 * radius * axis, point + 1.9 * radius * axis, 1.55 * radius
        )
        for moving, point, axis in zip(arm.chain, points[1:-1], axes, strict=True)
    ]
    return links + joints


def stations(arm: Structure, q: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Positions and axes of an arm's joints at q (n,) [rad] or [m].

    Returns:
        Points (k + 2, 3) [m]: the base, each of the k joints of ``arm.chain``, the tool; and those joints' axes (k, 3)
        in the base frame.
    """
    q = np.asarray(q, dtype=np.float64)
    T, points, axes = np.eye(4), [np.zeros(3)], []
    for joint, leader, factor, offset in arm.chain:
        T = T @ joint.placement
        points.append(T[:3, 3])
        axes.append(T[:3, :3] @ joint.axis)
        T = T @ moved(joint.kind, joint.axis, factor * q[leader] + offset)
    points.append((T @ arm.tool)[:3, 3])
    return np.array(points), np.array(axes)


def thickness(points: FloatArray) -> float:
    """Radius of the links of an arm through points (k, 3) [m]."""
    length = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    return WIDTH * (length if length > LEAST_LENGTH else 1.0)


def _between(name: str | None, joint: int | None, start: FloatArray, end: FloatArray, radius: float) -> Shape:
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    pose = translation(*(0.5 * (start + end))) @ turned(shortest_turn_from_z(along))
    return Shape(str(name), joint, pose, length, radius)
