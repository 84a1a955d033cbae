"""The positions of a survey: judged by arms whose reach has a closed form."""

import re

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError

zarr = pytest.importorskip("zarr", reason="needs the extra survey")
PLANE = sr.Task(rows=(True, True, False, False, False, False))
SPACE = sr.Task(rows="position")
CLOSE = 1e-3
"""[m] Positions this near to a rim are not judged."""


def shoulder(*links):
    """A joint about z, and for each link one about y; without limits."""
    joints = [sr.Joint(axis=[0.0, 0.0, 1.0])]
    for place, _ in enumerate(links):
        placement = np.eye(4)
        placement[0, 3] = links[place - 1] if place else 0.0
        joints.append(sr.Joint(placement=placement, axis=[0.0, 1.0, 0.0]))
    tool = np.eye(4)
    tool[0, 3] = links[-1]
    return sr.Arm(joints, tool=tool)


def radii(cells):
    """(cells,) [m] of the middles, from the first joint."""
    return np.linalg.norm(cells.points() - np.array(cells.centre), axis=1)


def test_the_cells_cover_the_reach():
    arm = sr.arms.planar(3)
    region = sr.tolerance.surveys.positions.region_of(arm, PLANE)
    cells = region.slice
    assert region.cloud is None
    assert (cells.axes, cells.half) == ((0, 1), 3.0)
    points = cells.points().reshape(40, 40, 3)
    np.testing.assert_allclose(points[0, 1] - points[0, 0], [6.0 / 40, 0.0, 0.0])  # the last axis is x
    np.testing.assert_allclose(points[1, 0] - points[0, 0], [0.0, 6.0 / 40, 0.0])
    np.testing.assert_allclose(points[0, 0, :2], -3.0 + 3.0 / 40)
    assert cells.edges(0)[[0, -1]].tolist() == [-3.0, 3.0]
    inside = np.zeros(1600, dtype=bool)
    inside[cells.inside()] = True
    np.testing.assert_array_equal(inside, radii(cells) <= 3.0)


@pytest.fixture(scope="module")
def planar(tmp_path_factory):
    """Unit links without limits, always locked at the same place: 1 cell a configuration."""
    q = np.array([0.4, 1.1, 2.0])
    folder = tmp_path_factory.mktemp("planar") / "x"
    settings = {"q": np.tile(q, (1300, 1)), "k": 1, "metrics": "positions", "task": PLANE, "chunk": 500}
    return q, sr.tolerance.survey(sr.arms.planar(3), folder, **settings)


def test_before_and_after_each_loss_the_tool_reaches_known_rings(planar):
    """With a joint locked two links of known lengths are left: they reach a ring, around a known point."""
    q, found = planar
    cells = found.region.slice
    z = cells.points()[:, 0] + 1j * cells.points()[:, 1]
    whole = np.abs(z) < 3.0
    np.testing.assert_array_equal(found.total("slice_before").ravel() == 1, whole)
    tried = found.total("slice_tried").ravel()
    assert tried.sum() == 1300
    np.testing.assert_array_equal(tried > 0, whole)
    assert tried.max() == 2  # in an order that comes to all of them before it begins anew
    second, third = abs(1.0 + np.exp(1j * q[1])), abs(1.0 + np.exp(1j * q[2]))
    rings = [
        (np.exp(1j * q[0]), 0.0, 2.0),
        (0.0, abs(second - 1.0), second + 1.0),
        (0.0, abs(third - 1.0), third + 1.0),
    ]
    for joint, (centre, low, high) in enumerate(rings):
        away = np.abs(z - centre)
        clear = whole & (np.minimum(np.abs(away - low), np.abs(away - high)) > CLOSE)
        expected = np.where((away > low) & (away < high), tried, 0)
        np.testing.assert_array_equal(found.total("slice_after")[joint].ravel()[clear], expected[clear])
        assert 0 < np.count_nonzero(expected[clear]) < clear.sum()
        assert found.positions[joint] == pytest.approx(expected.sum() / 1300, abs=0.01)


def test_the_words_are_those_of_the_numbers(planar):
    _, found = planar
    left = found.positions
    worst, best = (found.arm.joint_names[place] for place in (int(left.argmin()), int(left.argmax())))
    assert f"{100 * left.min():.0f} % stay within reach without {worst}" in found.verdict
    assert f"{100 * left.max():.0f} % without {best}" in found.verdict
    assert found.head == ("lost", "positions reached")
    assert found.table()[0] == (worst, f"{100 * left.min():.0f} %")
    assert found.facts()["positions_after"] == dict(zip(found.arm.joint_names, left.tolist(), strict=True))


def test_positions_in_space_of_arms_with_a_known_shell(tmp_path):
    """Links of 1 and 0.5 m reach a shell; a third joint of the plane may lock anywhere if it is the last one's own."""
    arm = shoulder(1.0, 0.5)
    found = sr.tolerance.survey(arm, tmp_path / "two", samples=300, k=1, metrics="positions", task=SPACE)
    cells = found.region.cloud
    assert (cells.axes, cells.half) == ((0, 1, 2), 1.5)
    away = radii(cells)
    expected = (away > 0.5) & (away < 1.5)
    clear = np.minimum(np.abs(away - 0.5), np.abs(away - 1.5)) > CLOSE
    np.testing.assert_array_equal(found.total("cloud_before").ravel()[clear] == 1, expected[clear])
    assert found.total("cloud_tried").sum() == 300
    assert found.total("cloud_after").sum() == 0  # two joints reach a surface, which passes by the middles of cells
    plane = found.region.slice
    assert plane.axes == (0, 2)
    np.testing.assert_array_equal(plane.points()[:, 1], 0.0)


def test_a_joint_whose_axis_the_tool_is_on_costs_no_position(tmp_path):
    found = sr.tolerance.survey(
        sr.arms.panda().with_tool(np.eye(4)),
        tmp_path / "x",
        samples=120,
        k=1,
        metrics="positions",
        task=SPACE,
        starts=20,
    )
    assert found.positions[6] == 1.0  # the tool is on the axis of joint 7
    assert found.positions.min() < 0.7
    assert found.ranking[0] == int(found.positions.argmin())


def test_only_joints_that_fail_alone_are_tried(tmp_path):
    arm = sr.arms.planar(4)
    settings = {"samples": 50, "metrics": "positions", "task": PLANE}
    found = sr.tolerance.survey(arm, tmp_path / "x", failures=["j2", ("j1", "j3")], **settings)
    assert np.isfinite(found.positions).tolist() == [False, True, False, False]
    assert found.singles == (1,)
    pairs = sr.tolerance.survey(arm, tmp_path / "y", failures=[("j1", "j3")], **settings)
    assert np.isnan(pairs.positions).all()
    assert "No position around it was tried." in pairs.verdict


def test_levels_by_how_often_a_position_is_reached():
    from stillreach.show.positions import ALWAYS, LOST, OFTEN, OUTSIDE, SELDOM, UNTRIED, Seen, levels

    before = np.array([0, 1, 1, 1, 1, 1, 1]) > 0
    own = Seen(None, before, np.array([0, 0, 3, 3, 2, 3, 3]), np.array([[0, 0, 0, 1, 1, 2, 3]]))
    assert levels(own, 0).tolist() == [OUTSIDE, UNTRIED, LOST, SELDOM, OFTEN, OFTEN, ALWAYS]
    assert levels(own, None).tolist() == [OUTSIDE, *[ALWAYS] * 6]


def test_few_configurations_are_drawn_in_larger_cells(planar, tmp_path):
    from stillreach.show.positions import seen

    _, whole = planar
    assert seen(whole, "slice").cells.count == 40
    found = sr.tolerance.survey(sr.arms.planar(3), tmp_path / "x", samples=150, k=1, metrics="positions", task=PLANE)
    own = seen(found, "slice")
    assert own.cells.count == 10  # of the first cells each is in another block of 4 x 4
    assert np.count_nonzero(own.before & (own.tried == 0)) <= 0.1 * own.before.sum()
    assert own.tried.sum() == 150
    np.testing.assert_array_equal(own.after.sum(axis=(1, 2)), found.total("slice_after").sum(axis=(1, 2)))
    fine, side = found.total("slice_tried"), 40 // own.cells.count
    for row, column in ((0, 0), (3, 2), (4, 4)):  # each the sum of its block
        block = fine[row * side : (row + 1) * side, column * side : (column + 1) * side]
        assert own.tried[row, column] == block.sum()


def test_an_outline_holds_the_cells_of_its_level():
    pytest.importorskip("jinja2")
    from stillreach.show.left import outline

    codes = np.random.default_rng(3).integers(0, 3, (7, 9))
    for level in range(3):
        drawn = np.zeros((7, 9), dtype=bool)
        for a, row, b, below, back in re.findall(r"M(\d+) (\d+)H(\d+)V(\d+)H(\d+)Z", outline(codes, level)):
            assert (int(below), back) == (int(row) + 1, a)
            drawn[6 - int(row), int(a) : int(b)] = True  # the page counts rows from above
        np.testing.assert_array_equal(drawn, codes == level)


def test_pictures_have_a_panel_for_all_joints_and_each_loss(planar, tmp_path):
    pytest.importorskip("matplotlib").use("agg")
    _, found = planar
    figure = found.plot("slice")
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    order = np.argsort(found.positions)
    assert titles[0] == "all joints"
    assert [title.split(":")[0] for title in titles[1:]] == [f"without {found.arm.joint_names[j]}" for j in order]
    worst = figure.axes[1].collections[0].get_array()  # 0: never reached, 2: lost, 5: reached
    tried = found.total("slice_tried").ravel() > 0
    lost = np.count_nonzero(tried & (found.total("slice_after")[order[0]].ravel() == 0))
    assert np.count_nonzero(worst == 2) == lost > 0
    assert "positions reached, in any attitude [%]" in [axes.get_xlabel() for axes in found.plot().axes]
    with pytest.raises(InputError, match="expected the position in all three axes"):
        found.plot("cloud")
    space = sr.tolerance.survey(
        shoulder(1.0, 0.8, 0.4), tmp_path / "x", samples=30, k=1, metrics="positions", task=SPACE
    )
    clouds = space.plot("cloud")
    assert [axes.get_zlabel() for axes in clouds.axes] == ["z [m]"] * 4
    dots = sum(len(drawn.get_offsets()) for drawn in clouds.axes[0].collections)
    blocks = space.total("cloud_before").reshape(4, 4, 4, 4, 4, 4).max(axis=(1, 3, 5))  # 30 tries: larger cells
    _, back, right = np.nonzero(blocks)
    assert dots == np.count_nonzero(~((right >= 2) & (back < 2)))


@pytest.mark.parametrize(
    ("task", "arm", "said"),
    [
        (sr.Task(rows="orientation"), sr.arms.panda(), "positions of a task of wx, wy, wz in the base frame"),
        (sr.Task(rows=PLANE.rows, frame="tool"), sr.arms.panda(), "positions of a task of vx, vy in the tool frame"),
        (None, sr.Arm([sr.Joint(kind="prismatic"), *sr.arms.panda().joints]), "an arm whose reach is endless"),
    ],
)
def test_tasks_without_positions_are_refused(task, arm, said, tmp_path):
    with pytest.raises(InputError, match=f"metrics: got .*{said}"):
        sr.tolerance.survey(arm, tmp_path / "x", samples=5, k=1, metrics="positions", task=task)
    assert list(tmp_path.iterdir()) == []


def test_a_survey_without_positions_has_no_pictures_of_them(tmp_path):
    found = sr.tolerance.survey(sr.arms.planar(3), tmp_path / "x", samples=5, k=1, metrics="relative", task=PLANE)
    for ask in (lambda: found.plot("slice"), lambda: found.plot("cloud"), lambda: found.positions):
        with pytest.raises(InputError, match="expected a survey with positions"):
            ask()
    with pytest.raises(InputError, match="what: got 'cut'"):
        found.plot("cut")
