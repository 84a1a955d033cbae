"""The arm with the commanded and actual paths of its tool in 3D."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.arm.shapes import LEAST_LENGTH, stations
from stillreach.show import arm3d
from stillreach.show.moments import moments
from stillreach.show.style import COLOURS, HEALTH_COLOURS, TITLE_LETTERS, in_picture, new_figure, styled
from stillreach.simulation import Run
from stillreach.simulation.commanded import Commanded
from stillreach.status import Health

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DRAWN = 5000
"""Largest number of points of a line, approximately."""
VIEW = {"elev": 20, "azim": -60}
FILLED = 0.74
"""Fraction of its axes that a scene fills."""
NEAR = 0.006
"""Joints nearer to each other on the page, in units of a scene's projection, share one label."""
CORNER = 0.09
"""Fraction of the longest side around a shared corner of two axes, where only one has ticks."""


def scene(ax: Any, run: Run, goal: Commanded) -> None:
    """The arm at the start (pale) and end, failed joints named and in colour, with commanded and actual path."""
    arm = run.scenario.arm
    ax.computed_zorder = False  # later artists cover earlier ones
    health = {int(joint): Health(run.health[-1, joint]) for joint in np.flatnonzero(run.health[-1] != Health.HEALTHY)}
    arm3d.draw(ax, arm, run.q[0], labels=False, alpha=0.18)
    arm3d.draw(ax, arm, run.q[-1], labels=False, failed=health)
    first, _ = stations(arm, run.q[0])
    last, _ = stations(arm, run.q[-1])
    places = dict(zip(_moving_names(arm), last[1:-1], strict=True))
    path = run.pose[drawn_ticks(run), :3, 3]
    commanded_path(ax, goal)
    arm3d.path(ax, path, color=COLOURS[0], linewidth=1.8, zorder=3, label="path of the tool")
    for place, moment in enumerate(moments(run.scenario, run.time[-1])):
        if not moment.better:
            tick = min(int(np.searchsorted(run.time, moment.time - 1e-12)), len(run) - 1)
            label = "a joint fails" if place == 0 else None
            ax.plot(
                *run.pose[tick, :3, 3],
                "x",
                color=moment.colour,
                markersize=7,
                mew=1.8,
                label=label,
                ls="none",
                zorder=4,
            )
    fit(ax, np.concatenate([first, last, path, goal.poses[:, :3, 3]]))
    _name(
        ax,
        {
            in_picture(run.joint_names[joint]): (places[run.joint_names[joint]], HEALTH_COLOURS[state])
            for joint, state in health.items()
        },
    )
    ax.legend(loc="lower left", bbox_to_anchor=(0.15, -0.03), fontsize=8.5, ncols=2)


def arm_picture(arm: Arm, q: FloatArray, failed: Collection[int] = ()) -> Figure:
    """A figure of an arm at q (n,) [rad, m], its joints named, failed ones in colour."""
    with styled("arm.plot()"):
        figure = new_figure(6.4, 6.4)
        ax: Any = figure.add_axes((0.02, 0.02, 0.92, 0.92), projection="3d", computed_zorder=False)
        arm3d.draw(ax, arm, q, labels=False, failed=failed)
        points, _ = stations(arm, q)
        fit(ax, points)
        names = map(in_picture, _moving_names(arm))
        colours = [HEALTH_COLOURS[Health.LOCKED] if moving.leader in failed else "black" for moving in arm.chain]
        _name(ax, dict(zip(names, zip(points[1:-1], colours, strict=True), strict=True)))
        figure.suptitle(in_picture(arm.name, TITLE_LETTERS), fontsize=11)
    return figure


def _moving_names(arm: Arm) -> list[str]:
    """Names of all moving joints, including followers, from the base on."""
    return [str(moving.joint.name) for moving in arm.chain]


def _name(ax: Any, joints: Mapping[str, tuple[FloatArray, str]]) -> None:
    """Names beside joints, given by name as point (3,) and colour; of joints that are close on the page in one."""
    from matplotlib.patheffects import withStroke
    from mpl_toolkits.mplot3d.proj3d import proj_transform  # type: ignore[import-untyped]

    groups: list[tuple[FloatArray, FloatArray, str, list[str]]] = []
    for name, (point, colour) in joints.items():
        place = np.array(proj_transform(*point, ax.get_proj())[:2])
        near = next((group for group in groups if np.linalg.norm(group[1] - place) < NEAR), None)
        if near is None:
            groups.append((point, place, colour, [name]))
        else:
            near[3].append(name)
    for point, _, colour, names in groups:
        text = ax.text(*point, f"     {', '.join(names)}", color=colour, fontsize=9, fontweight="bold")
        text.set(zorder=5, path_effects=[withStroke(linewidth=2.5, foreground="white")])


def commanded_path(ax: Any, goal: Commanded) -> None:
    """The commanded path, dotted, and a ring at its end."""
    points = goal.poses[:, :3, 3]
    arm3d.path(ax, points, color="black", linewidth=1.1, linestyle=(0, (1.2, 1.6)), label="commanded path", zorder=3)
    ax.plot(*points[-1], "o", color="black", fillstyle="none", markersize=7, label="goal", zorder=4)


def fit(ax: Any, points: FloatArray) -> None:
    """One scale on all three axes, around points (k, 3), no side shorter than a third of the longest."""
    low, high = points.min(axis=0), points.max(axis=0)
    longest = float(np.max(high - low))
    half = np.maximum(high - low, longest / 3 if longest > LEAST_LENGTH else 0.1) * 0.54
    middle = (low + high) / 2
    low, high = middle - half, middle + half
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    x, y, z = high - low
    # width (with room for numbers) and height of the box on the page, seen from VIEW, in units of its diagonal
    page = max(1.15 * (0.87 * x + 0.5 * y), 0.94 * z + 0.17 * x + 0.3 * y) / float(np.linalg.norm(high - low))
    ax.set_box_aspect(high - low, zoom=FILLED / page)
    ax.view_init(**VIEW)
    ax.tick_params(axis="z", pad=9)
    ax.patch.set_alpha(0.0)  # does not cover its neighbours
    ticks = arm3d.round_ticks(high - low)
    corner = CORNER * float(np.max(high - low))
    cut = ((low[0], high[0] - corner), (low[1] + corner / 2, high[1]), (low[2], high[2]))  # x ends where y begins
    for name, axis, (first, last) in zip("xyz", (ax.xaxis, ax.yaxis, ax.zaxis), cut, strict=True):
        marks = [float(mark) for mark in ticks.tick_values(first, last) if first <= mark <= last]
        texts = [f"{mark:.6g}" for mark in marks[:-1]] + [_last_tick(name, mark) for mark in marks[-1:]]
        axis.set_ticks(marks, [text.replace("-", "\N{MINUS SIGN}") for text in texts])


def _last_tick(axis: str, mark: float) -> str:
    """The number [m] with the axis name, away from the axis: an axis label would cover numbers."""
    return f"{'' if axis == 'x' else '        '}{axis} = {mark:.6g} m"


def drawn_ticks(run: Run) -> np.ndarray:
    """The drawn ticks (K,): all, or for a long run evenly spaced ones and the last."""
    return np.append(np.arange(0, len(run) - 1, max(1, len(run) // DRAWN)), len(run) - 1)
