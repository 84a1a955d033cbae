"""Figures 1 to 12 of the paper, each with the quantity that its caption names."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from stillreach.paper import examples, panels, plots
from stillreach.paper.evidence import Evidence
from stillreach.paper.panels import Picture
from stillreach.show import arm3d

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXAMPLE_1 = (examples.EXAMPLE_1_FREE, examples.EXAMPLE_1_FAILED)
EXAMPLE_2 = (examples.EXAMPLE_2_FREE, examples.EXAMPLE_2_PSEUDOINVERSE, examples.EXAMPLE_2_CLOSED_FORM)


def _arm(of: Evidence) -> Figure:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 5.0))
    ax: Any = figure.add_axes((-0.06, -0.06, 1.06, 1.18), projection="3d")
    run = of[examples.EXAMPLE_1_FREE]
    arm3d.draw(ax, run.scenario.arm, run.q[0], unit=examples.INCH)
    ax.view_init(elev=20, azim=-60)
    ax.set(xlabel="x [in]", ylabel="y [in]", zlabel="z [in]")
    return figure


def _tool(name: str) -> Callable[[Evidence], Figure]:
    """Position and attitude of a run, on axes that it shares with the other runs of its example."""

    def draw(of: Evidence) -> Figure:
        figure, (axes,) = panels.panels(2)
        example = EXAMPLE_1 if name in EXAMPLE_1 else EXAMPLE_2
        panels.tool(of[name], *axes, like=[of[other] for other in example])
        return figure

    return draw


def _angles(name: str) -> Callable[[Evidence], Figure]:
    def draw(of: Evidence) -> Figure:
        figure, (axes,) = panels.panels(2)
        panels.angles(of[name], axes)
        return figure

    return draw


def _rates(name: str) -> Callable[[Evidence], Figure]:
    def draw(of: Evidence) -> Figure:
        figure, (axes,) = panels.panels(2)
        panels.rates(of[name], axes)
        return figure

    return draw


def _rates_and_angles(of: Evidence) -> Figure:
    figure, (left, right) = panels.panels(2, 2)
    run = of[examples.EXAMPLE_2_CLOSED_FORM]
    panels.rates(run, left, limited=True)
    panels.angles(run, right)
    return figure


def _scale_factor(of: Evidence) -> Figure:
    figure, ((ax,),) = panels.panels(1, right=0.25)
    plots.damping([of[examples.EXAMPLE_2_CLOSED_FORM]], ax)
    ax.set_ylabel("scale factor κ")
    return figure


FREE = "Pseudoinverse solution for all joints free"
FAILED_1 = 'Pseudoinverse solution for joints 1, 6, 7 failed (the text; the caption prints "for all joints free")'
FAILED_2 = "Pseudoinverse solution for 3 failed joints"
ROBUST = "SR-Inverse solution for 3 failed joints"
TOOL, ANGLES, RATES = "End-effector position and attitude", "Joint angles", "Joint rates"

PRINTED = tuple(
    Picture(f"figure-{number:02}.png", f"Figure {number}: {caption}", draw)
    for number, (caption, draw) in enumerate(
        (
            ("Modular manipulator in initial configuration (example 1)", _arm),
            (f"{FREE}: {TOOL} (example 1)", _tool(examples.EXAMPLE_1_FREE)),
            (f"{FREE}: {ANGLES} (example 1)", _angles(examples.EXAMPLE_1_FREE)),
            (f"{FAILED_1}: {TOOL}", _tool(examples.EXAMPLE_1_FAILED)),
            (f"{FAILED_1}: {ANGLES}", _angles(examples.EXAMPLE_1_FAILED)),
            (f"{FREE}: {TOOL} (example 2)", _tool(examples.EXAMPLE_2_FREE)),
            (f"{FREE}: {RATES} (example 2)", _rates(examples.EXAMPLE_2_FREE)),
            (f"{FAILED_2}: {TOOL}", _tool(examples.EXAMPLE_2_PSEUDOINVERSE)),
            (f"{FAILED_2}: {RATES}", _rates(examples.EXAMPLE_2_PSEUDOINVERSE)),
            (f"{ROBUST}: {TOOL}", _tool(examples.EXAMPLE_2_CLOSED_FORM)),
            (
                f"{ROBUST}: {RATES} (left: the caption; grey: the limit) and joint angles (right: the text)",
                _rates_and_angles,
            ),
            (f"{ROBUST}: Scale factor", _scale_factor),
        ),
        start=1,
    )
)
"""The paper's figures with its captions."""
