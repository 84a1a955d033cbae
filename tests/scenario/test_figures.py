"""Each of the paper's figures shows the quantity that its caption names, in the paper's units and line styles."""

import numpy as np
import pytest

from stillreach.paper import examples
from stillreach.paper.added import ADDED
from stillreach.paper.figures import PICTURES
from stillreach.paper.printed import PRINTED
from stillreach.show.style import styled

FREE_1, FAILED_1 = examples.EXAMPLE_1_FREE, examples.EXAMPLE_1_FAILED
FREE_2, UNLIMITED, ROBUST = examples.EXAMPLE_2_FREE, examples.EXAMPLE_2_PSEUDOINVERSE, examples.EXAMPLE_2_CLOSED_FORM
TOOL, ANGLES, RATES = "End-effector position and attitude", "Joint angles", "Joint rates"
CAPTIONS = {
    2: (FREE_1, TOOL),
    3: (FREE_1, ANGLES),
    4: (FAILED_1, TOOL),
    5: (FAILED_1, ANGLES),
    6: (FREE_2, TOOL),
    7: (FREE_2, RATES),
    8: (UNLIMITED, TOOL),
    9: (UNLIMITED, RATES),
    10: (ROBUST, TOOL),
    11: (ROBUST, RATES),
    12: (ROBUST, "Scale factor"),
}
"""Figure, run and quantity, as the captions and section 6 of the paper print them."""


@pytest.fixture(scope="module")
def drawn(saved):
    """drawn(file): the figure of a file."""
    figures = {}

    def draw(file):
        if file not in figures:
            with styled("the test"):
                figures[file] = {picture.file: picture for picture in PICTURES}[file].draw(saved)
        return figures[file]

    return draw


def curves(ax):
    """Times, values and style of each named line."""
    return {
        line.get_label(): (line.get_xdata(), line.get_ydata(), line.get_linestyle())
        for line in ax.lines
        if not line.get_label().startswith("_")
    }


def rotation(pitch, yaw, roll):
    """R_y(pitch) R_z(yaw) R_x(roll), angles (T,) [deg]."""
    (a, b, c), (s, t, u) = (np.cos(np.deg2rad([pitch, yaw, roll])), np.sin(np.deg2rad([pitch, yaw, roll])))
    zero, one = np.zeros_like(a), np.ones_like(a)

    def matrices(rows):
        return np.moveaxis(np.array(rows), -1, 0)

    about_y = matrices([[a, zero, s], [zero, one, zero], [-s, zero, a]])
    about_z = matrices([[b, -t, zero], [t, b, zero], [zero, zero, one]])
    about_x = matrices([[one, zero, zero], [zero, c, -u], [zero, u, c]])
    return about_y @ about_z @ about_x


def check_tool(run, place, turn):
    """Position in inches, attitude in degrees; solid, dashed, dotted."""
    assert (place.get_ylabel(), turn.get_ylabel()) == ("tool position [in]", "attitude [deg]")
    position, attitude = curves(place), curves(turn)
    assert (list(position), list(attitude)) == (["x", "y", "z"], ["pitch", "yaw", "roll"])
    for panel in (position, attitude):
        assert [style for _, _, style in panel.values()] == ["-", "--", ":"]
        for times, _, _ in panel.values():
            np.testing.assert_allclose(times, run.time)
    np.testing.assert_allclose(np.stack([values for _, values, _ in position.values()], 1), run.pose[:, :3, 3] / 0.0254)
    matrices = rotation(*(values for _, values, _ in attitude.values()))
    np.testing.assert_allclose(matrices, run.pose[:, :3, :3], atol=1e-12)


def check_joints(values, axes, unit):
    """All joints' values in degrees, pitches above and rolls below."""
    pitches, rolls = (curves(ax) for ax in axes)
    assert (list(pitches), list(rolls)) == ([f"j{k}" for k in range(2, 11, 2)], [f"j{k}" for k in range(1, 12, 2)])
    for name, (_, shown, _) in (pitches | rolls).items():
        np.testing.assert_allclose(shown, np.rad2deg(values[:, int(name[1:]) - 1]), atol=1e-12)
    for ax in axes:
        assert f"[{unit}]" in ax.get_ylabel()
        low, high = ax.get_ylim()
        assert all(low <= np.min(shown) and np.max(shown) <= high for _, shown, _ in curves(ax).values())


@pytest.mark.parametrize("number", CAPTIONS)
def test_a_figure_shows_what_its_caption_names(saved, drawn, number):
    name, quantity = CAPTIONS[number]
    picture, run = PRINTED[number - 1], saved[name]
    assert picture.file == f"figure-{number:02}.png"
    assert picture.caption.startswith(f"Figure {number}: ")
    assert quantity in picture.caption
    axes = drawn(picture.file).axes
    assert axes[-1].get_xlabel() == "time [s]"
    if quantity == TOOL:
        check_tool(run, *axes)
    elif quantity == ANGLES:
        check_joints(run.q, axes, "deg")
    elif quantity == RATES:
        check_joints(run.rates, axes[0::2] if number == 11 else axes, "deg/s")
    else:
        np.testing.assert_array_equal(axes[0].lines[0].get_ydata(), run.damping)


def test_figure_11_also_shows_the_angles_that_the_text_speaks_of(saved, drawn):
    check_joints(saved[ROBUST].q, drawn("figure-11.png").axes[1::2], "deg")


def test_figure_1_shows_the_arm_where_example_1_starts(saved, drawn):
    (ax,) = drawn("figure-01.png").axes
    tool = saved[FREE_1].pose[0, :3, 3] / 0.0254
    assert ax.name == "3d"
    for value, (low, high) in zip(tool, (ax.get_xlim(), ax.get_ylim(), ax.get_zlim()), strict=True):
        assert low <= value <= high
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()) == ("x [in]", "y [in]", "z [in]")


@pytest.mark.parametrize(
    ("file", "names"),
    [("figure-02-beside-04.png", (FREE_1, FAILED_1)), ("figure-06-beside-08.png", (FREE_2, UNLIMITED))],
)
def test_figures_that_the_text_compares_stand_side_by_side_on_the_same_axes(saved, drawn, file, names):
    axes = drawn(file).axes
    for column, name in enumerate(names):
        check_tool(saved[name], axes[column], axes[2 + column])
    for left, right in (axes[:2], axes[2:]):
        assert left.get_ylim() == right.get_ylim()
        assert left.get_position().y0 == right.get_position().y0


def test_what_the_paper_does_not_have_comes_after_its_figures_under_names_of_its_own():
    assert PICTURES == PRINTED + ADDED
    assert len(PRINTED) == 12
    numbered = {picture.file for picture in PRINTED}
    assert not numbered & {picture.file for picture in ADDED}


@pytest.mark.parametrize("picture", PICTURES, ids=lambda picture: picture.file)
def test_labels_are_whole_and_hold_no_markup(drawn, picture):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    with styled("the test"):
        figure = drawn(picture.file)
        FigureCanvasAgg(figure).draw()
        for ax in figure.axes:
            labels = [ax.xaxis.label, ax.yaxis.label, ax.title, *ax.get_xticklabels(), *ax.get_yticklabels()]
            assert not [label.get_text() for label in labels if set(label.get_text()) & set("$\\{}^")]
            extent = ax.get_tightbbox()  # all that is drawn, legend included
            assert extent.x0 >= 0.0 or ax.name == "3d"
            assert extent.y0 >= 0.0 or ax.name == "3d"
            assert extent.x1 <= figure.bbox.x1 or ax.name == "3d"
            assert extent.y1 <= figure.bbox.y1 or ax.name == "3d"
