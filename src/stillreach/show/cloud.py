"""A workspace as points: what is reached before a failure, and what also after it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stillreach.show.style import in_picture, matplotlib_or_error, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stillreach.tolerance.workspace import Workspace

KINDS = (("not reached", "#c9ced6", "."), ("reached until a joint fails", "#f0963c", "x"), ("tolerant", "#1b4f8a", "o"))


def cloud(found: Workspace) -> Figure:
    """Points of a workspace, seen along z and along y.

    Raises:
        MissingExtraError: if matplotlib is not installed.
    """
    matplotlib_or_error("a picture of a workspace")
    points = found.poses[:, :3, 3]
    code = np.where(found.tolerant, 2, np.where(found.before, 1, 0))
    with styled("a picture of a workspace"):
        figure = new_figure(9.0, 4.8)
        title = f"{in_picture(found.arm.name)}: {100 * found.share:.3g} % of {len(points)} poses are tolerant"
        figure.suptitle(title, x=0.02, ha="left")
        for place, (across, up) in enumerate(((0, 1), (0, 2))):
            axes = figure.add_subplot(1, 2, place + 1)
            for kind, (label, colour, marker) in enumerate(KINDS):
                here = code == kind
                axes.scatter(points[here, across], points[here, up], s=9, c=colour, marker=marker, lw=0.8, label=label)
            axes.set(xlabel=f"{'xyz'[across]} [m]", ylabel=f"{'xyz'[up]} [m]")
            axes.set_axisbelow(True)
            axes.set_aspect("equal", adjustable="datalim")
        figure.legend(*axes.get_legend_handles_labels(), loc="lower center", ncols=3)
        figure.subplots_adjust(left=0.08, right=0.98, top=0.9, bottom=0.2, wspace=0.25)
    return figure
