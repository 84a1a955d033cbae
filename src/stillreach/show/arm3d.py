"""The arm in 3D: links as tubes, joints as cylinders along their axes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach.arm import Arm
from stillreach.arm.shapes import stations, thickness
from stillreach.show.style import HEALTH_COLOURS, in_picture, matplotlib_or_error
from stillreach.status import Health

SIDES = 20
LINK, JOINT = np.full(3, 0.92), np.full(3, 0.62)
"""Colours in full light."""


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
        failed: indices of joints to draw as failed, with their health unless all are LOCKED.
        alpha: opacity.
    """
    matplotlib_or_error("drawing an arm")
    from matplotlib.colors import to_rgb
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

    health = failed if isinstance(failed, Mapping) else dict.fromkeys(failed, Health.LOCKED)
    points = stations(arm, q)[0] / unit
    colours = {None: LINK} | {joint: np.array(to_rgb(HEALTH_COLOURS[state])) for joint, state in health.items()}
    faces = []
    for shape in arm.shapes(q):
        start, end = shape.ends
        tube = _tube(start / unit, end / unit, shape.radius / unit)
        faces += [(face, (*_lit(face, colours.get(shape.joint, JOINT)), alpha)) for face in tube]
    # one collection, so that near faces cover far ones
    lit = [colour for _, colour in faces]
    ax.add_collection3d(Poly3DCollection([face for face, _ in faces], facecolors=lit, edgecolors=lit, linewidths=0.4))
    if labels:
        _tool(ax, arm.forward(q), unit, 5.0 * thickness(points))
        for moving, point in zip(arm.chain, points[1:-1], strict=True):
            ax.text(*point, f"   {in_picture(str(moving.joint.name))}", fontsize=8, va="bottom")
    fit(ax, points)


def path(ax: Any, points: npt.ArrayLike, *, unit: float = 1.0, **line: Any) -> None:
    """A path of the tool, (T, 3) [m], as a line."""
    x, y, z = np.asarray(points, dtype=np.float64).T / unit
    ax.plot(x, y, z, **line)


def fit(ax: Any, points: np.ndarray) -> None:
    """One scale on all three axes, around points (k, 3) in the figure's unit."""
    least = 20 * thickness(points)
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
    """Side faces and caps of a cylinder as quadrangles, (faces, 4, 3); empty for length 0."""
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
    # also caps in quadrangles: matplotlib pads faces with fewer corners with uninitialised memory
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
