"""The arm as a body in space: links as tubes, joints as drums along their axes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach.arm import Arm
from stillreach.arm.placements import moved
from stillreach.show.style import HEALTH_COLOURS, in_picture, matplotlib_or_error
from stillreach.status import Health

SIDES = 20
LEAST_LENGTH = 1e-6
LINK, JOINT = np.full(3, 0.92), np.full(3, 0.62)
"""Colours in full light."""


def stations(arm: Arm, q: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Where the joints of an arm sit at q (n,) [rad] or [m].

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


def draw(
    ax: Any,
    arm: Arm,
    q: npt.ArrayLike,
    *,
    unit: float = 1.0,
    labels: bool = True,
    failed: Mapping[int, Health] | Collection[int] = (),
    alpha: float = 1.0,
) -> None:
    """Draw the arm into 3D axes, and fit the axes around it.

    Args:
        ax: axes with ``projection="3d"``.
        arm: the arm.
        q: (n,) joint values [rad] or [m].
        unit: [m] of the axes.
        labels: write the joints' names beside them, and draw the axes of the tool.
        failed: indices of joints to draw as failed, with their health where that is not LOCKED for all of them.
        alpha: opacity.
    """
    matplotlib_or_error("drawing an arm")
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

    health = failed if isinstance(failed, Mapping) else dict.fromkeys(failed, Health.LOCKED)
    points, axes = stations(arm, q)
    points = points / unit
    width = _thickness(points)
    shapes = [(_tube(start, end, width), LINK) for start, end in pairwise(points)]
    for moving, point, axis in zip(arm.chain, points[1:-1], axes, strict=True):
        along = 1.9 * width * axis
        colour = np.array(to_rgb(HEALTH_COLOURS[health[moving.leader]])) if moving.leader in health else JOINT
        shapes.append((_tube(point - along, point + along, 1.55 * width), colour))
    faces = [(face, (*_lit(face, colour), alpha)) for tube, colour in shapes for face in tube]
    # one collection, so that near faces hide far ones
    colours = [colour for _, colour in faces]
    ax.add_collection3d(
        Poly3DCollection([face for face, _ in faces], facecolors=colours, edgecolors=colours, linewidths=0.4)
    )
    if labels:
        _tool(ax, arm.forward(q), unit, 5.0 * width)
        for moving, point in zip(arm.chain, points[1:-1], strict=True):
            ax.text(*point, f"   {in_picture(str(moving.joint.name))}", fontsize=8, va="bottom")
    fit(ax, points)


def path(ax: Any, points: npt.ArrayLike, *, unit: float = 1.0, **line: Any) -> None:
    """A path of the tool, (T, 3) [m], as a line."""
    x, y, z = np.asarray(points, dtype=np.float64).T / unit
    ax.plot(x, y, z, **line)


def fit(ax: Any, points: np.ndarray) -> None:
    """One scale on all three axes, around points (k, 3) in the figure's unit."""
    least = 20 * _thickness(points)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = np.maximum(np.ptp(points, axis=0) + least, 2 * least) / 2
    low, high = middle - half, middle + half
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(high - low, zoom=0.88)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(round_ticks(high - low))


def round_ticks(sides: np.ndarray) -> Any:
    """A locator of round ticks, about four along the longest of the sides (3,)."""
    from matplotlib.ticker import MultipleLocator

    return MultipleLocator(_round_step(float(np.max(sides)) / 4))


def _tube(start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
    """Side faces and both caps of a cylinder as quadrangles, (faces, 4, 3); none for one without length."""
    axis = end - start
    length = np.linalg.norm(axis)
    if length == 0.0:
        return np.empty((0, 4, 3))
    axis = axis / length
    across = np.cross(axis, (1.0, 0.0, 0.0) if abs(axis[0]) < 0.9 else (0.0, 1.0, 0.0))
    across /= np.linalg.norm(across)
    turn = np.linspace(0.0, 2 * np.pi, SIDES + 1)
    ring = radius * (np.outer(np.cos(turn), across) + np.outer(np.sin(turn), np.cross(axis, across)))
    a, b, middle = ring[:-1], ring[1:], np.zeros((SIDES, 3))
    sides = np.stack([start + a, start + b, end + b, end + a], axis=1)
    # caps in quadrangles, too: matplotlib pads faces of unequal corners with memory that it has not set
    caps = [np.stack([point + middle, point + a, point + b, point + b], axis=1) for point in (start, end)]
    return np.concatenate([sides, *caps])


def _lit(face: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """Colour of a face with light from the upper left, (3,)."""
    normal = np.cross(face[1] - face[0], face[2] - face[0])
    facing = abs(float(normal @ (-0.45, -0.55, 0.70))) / max(float(np.linalg.norm(normal)), 1e-300)
    return np.asarray(colour * (0.72 + 0.28 * facing))


def _tool(ax: Any, T: np.ndarray, unit: float, size: float) -> None:
    """The axes of the tool."""
    origin = T[:3, 3] / unit
    for k, name in enumerate("xyz"):
        ax.plot(*np.stack([origin, origin + size * T[:3, k]]).T, color="black", linewidth=1.0)
        ax.text(*(origin + 1.3 * size * T[:3, k]), name, fontsize=7, ha="center", va="center")


def _round_step(length: float) -> float:
    """The largest of ..., 1, 2, 5, 10, ... that is not above a length."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(max(step * power for step in (1, 2, 5) if step * power <= length * (1 + 1e-9)))


def _thickness(points: np.ndarray) -> float:
    """Radius of a link, for an arm of this length; one whose joints are all in one place is drawn as if 1 m long."""
    length = float(np.sum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    return 0.012 * (length if length > LEAST_LENGTH else 1.0)
