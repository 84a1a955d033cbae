"""What a run shows over time, one function a panel; each draws into the axes that it is given."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach._rotations import pitch_yaw_roll
from stillreach.show.style import SCREEN, Look, matplotlib_or_error, styled, unwrapped_degrees
from stillreach.show.words import TITLE_LETTERS, in_picture
from stillreach.simulation.run import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NO_ERROR = 1e-9
"""A panel of task errors reaches at least so high: rounding errors are no error."""


def angles(run: Run, ax: Axes, *, joints: Iterable[int] | None = None, look: Look = SCREEN) -> None:
    """Joint values over time [deg], slides in [mm].

    Args:
        run: the run.
        ax: where to draw.
        joints: indices of the joints to show; None is all.
        look: line styles and units.
    """
    _joint_lines(ax, run, run.q, joints, look)
    ax.set_ylabel("joint angle [deg]" if _all_revolute(run) else "joint value [deg], slides [mm]")


def rates(
    run: Run, ax: Axes, *, joints: Iterable[int] | None = None, limit: float | None = None, look: Look = SCREEN
) -> None:
    """Joint rates over time [deg/s], slides in [mm/s].

    Args:
        run: the run.
        ax: where to draw.
        joints: indices of the joints to show; None is all.
        limit: draws lines at plus and minus this rate [deg/s].
        look: line styles and units.
    """
    _joint_lines(ax, run, run.rates, joints, look)
    if limit is not None:
        for value in (-limit, limit):
            ax.axhline(value, color="0.6", linewidth=0.8, zorder=0.5)
    ax.set_ylabel("joint rate [deg/s]" if _all_revolute(run) else "joint rate [deg/s], slides [mm/s]")


def position(run: Run, ax: Axes, *, look: Look = SCREEN) -> None:
    """Position of the tool over time.

    Args:
        run: the run.
        ax: where to draw.
        look: line styles and units.
    """
    _lines(ax, run.time, run.pose[:, :3, 3] / look.length, ("x", "y", "z"), look.component)
    ax.set_ylabel(f"tool position [{look.length_name}]")


def attitude(run: Run, ax: Axes, *, look: Look = SCREEN) -> None:
    """Attitude of the tool over time: pitch, yaw, roll [deg] with R = R_y(pitch) R_z(yaw) R_x(roll).

    Args:
        run: the run.
        ax: where to draw.
        look: line styles and units.
    """
    shown = unwrapped_degrees(pitch_yaw_roll(run.pose))
    _lines(ax, run.time, shown, ("pitch", "yaw", "roll"), look.component)
    ax.set_ylabel("attitude [deg]")


def task_error(runs: Run | Sequence[Run], ax: Axes, *, names: Sequence[str] = ("",), look: Look = SCREEN) -> None:
    """Weighted task error over time, of one or several runs."""
    for place, run in enumerate(_several(runs)):
        ax.plot(run.time, run.task_error, label=names[place], **look.compared(place))
    ax.set_ylim(0.0, max(ax.get_ylim()[1], NO_ERROR))
    ax.set_ylabel("weighted task error")
    _finish(ax, named=len(names) > 1)


def damping(
    runs: Run | Sequence[Run], ax: Axes, *, names: Sequence[str] = ("",), log: bool = False, look: Look = SCREEN
) -> None:
    """Damping factor over time, of one or several runs; on a logarithmic axis zero is not drawn."""
    for place, run in enumerate(_several(runs)):
        shown = np.where(run.damping > 0, run.damping, np.nan) if log else run.damping
        ax.plot(run.time, shown, label=names[place], **look.compared(place))
    if log:
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")  # the default one writes formulas, which are off
    else:
        ax.set_ylim(0.0, ax.get_ylim()[1])
    ax.set_ylabel("damping factor κ")
    _finish(ax, named=len(names) > 1)


def largest_rate(
    runs: Run | Sequence[Run],
    ax: Axes,
    *,
    names: Sequence[str] = ("",),
    limit: float | None = None,
    look: Look = SCREEN,
) -> None:
    """Largest joint rate over time [deg/s] of one or several runs of revolute arms, with the limit [deg/s]."""
    for place, run in enumerate(_several(runs)):
        ax.plot(run.time, np.rad2deg(np.max(np.abs(run.rates), axis=1)), label=names[place], **look.compared(place))
    if limit is not None:
        ax.axhline(limit, color="0.6", linewidth=0.8, zorder=0.5)
    ax.set_ylabel("largest rate [deg/s]")
    _finish(ax, named=len(names) > 1)


def legend(ax: Axes) -> None:
    """The legend beside the panel, where it hides no line."""
    count = len(ax.get_legend_handles_labels()[1])
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.03), ncols=1 + count // 12, borderaxespad=0.3)


def overview(run: Run, look: Look = SCREEN) -> Figure:
    """Everything of a run in one figure: joint values, rates, tool position and attitude, task error, damping.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    with styled("run.plot()"):
        matplotlib_or_error("run.plot()")
        from matplotlib import pyplot

        figure, axes = pyplot.subplots(3, 2, figsize=(11, 8), sharex=True, layout="constrained")
        panels: tuple[tuple[Any, Any], ...] = ((angles, rates), (position, attitude), (task_error, damping))
        for row, pair in zip(axes, panels, strict=True):
            for ax, panel in zip(row, pair, strict=True):
                panel(run, ax, look=look)
        axes[0, 0].legend().remove()  # the rates' legend beside it names the same lines
        for ax in axes[1]:
            ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1)
        figure.suptitle(in_picture(str(run.attrs.get("title", "")), TITLE_LETTERS), fontsize=11, x=0.01, ha="left")
    return figure


def _several(runs: Run | Sequence[Run]) -> Sequence[Run]:
    return (runs,) if isinstance(runs, Run) else runs


def _all_revolute(run: Run) -> bool:
    return all(unit == "rad" for unit in run.joint_units)


def _joint_lines(ax: Axes, run: Run, values: np.ndarray, joints: Iterable[int] | None, look: Look) -> None:
    """Lines of the chosen joints in degrees and millimetres (per second)."""
    chosen = list(range(len(run.joint_names)) if joints is None else joints)
    factors = np.array([1000.0 if run.joint_units[j] == "m" else np.rad2deg(1.0) for j in chosen])
    _lines(ax, run.time, values[:, chosen] * factors, [in_picture(run.joint_names[j]) for j in chosen], look.line)


def _lines(
    ax: Axes, time: np.ndarray, columns: np.ndarray, names: Sequence[str], style: Callable[[int], dict[str, Any]]
) -> None:
    for place, name in enumerate(names):
        ax.plot(time, columns[:, place], label=name, **style(place))
    _finish(ax, named=True)


def _finish(ax: Axes, *, named: bool) -> None:
    """Time axis and legend."""
    spec = ax.get_subplotspec()
    if spec is None or spec.is_last_row():
        ax.set_xlabel("time [s]")
    ax.margins(x=0.0)
    ax.locator_params(axis="x", nbins=10, steps=[1, 2, 5, 10])
    if named:
        legend(ax)
