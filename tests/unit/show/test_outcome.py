"""The pictures of runs: what is written on them, and what their bars and lines say."""

import warnings
from dataclasses import replace
from io import BytesIO
from itertools import combinations, pairwise, product

import numpy as np
import pytest
from matplotlib import colors, image
from matplotlib.text import Text
from matplotlib.transforms import Bbox

import stillreach as sr
from stillreach.show.moments import moments
from stillreach.show.scene import drawn_ticks, fit
from stillreach.show.timeline import STATES

FAULTS = [
    sr.Fault("j4", at=0.4, kind=sr.Locked()),
    sr.Fault("j2", at=0.4, kind=sr.Locked()),
    sr.Fault("j6", at=0.8, kind=sr.Derated(0.25), until=1.2),
    sr.Fault("j9", at=1.5, kind=sr.Runaway(np.deg2rad(3.0))),
]


def scenario(**settings) -> sr.Scenario:
    start = np.deg2rad([0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0])
    motion = sr.ConstantTwist([-0.2, 0, 0, 0, 0, 0], duration=2.0)
    defaults = {"start": start, "motion": motion, "faults": FAULTS, "period": 0.02, "name": "four faults"}
    return sr.Scenario(arm=sr.arms.nasa_modular(), **{**defaults, **settings})


def drawn(of: sr.Scenario):
    run = sr.simulate(of)
    return run.plot(), run


def written(figure) -> str:
    texts = [text.get_text() for ax in figure.axes for text in ax.texts]
    texts += [text.get_text() for text in figure.texts]
    return "\n".join(texts)


def bars(ax, state: str) -> dict[int, list[tuple[float, float]]]:
    """Begin and end of the bars of one colour, by row."""
    found: dict[int, list[tuple[float, float]]] = {}
    for collection in ax.collections:
        if np.allclose(collection.get_facecolor()[0], colors.to_rgba(STATES[state])):
            for path in collection.get_paths():
                low, high = path.get_extents().min, path.get_extents().max
                found.setdefault(round((low[1] + high[1]) / 2), []).append((low[0], high[0]))
    return found


def test_moments_are_named_with_their_joints():
    texts = [(moment.time, moment.text, moment.better) for moment in moments(scenario(), 2.0)]
    assert texts == [
        (0.4, "j4, j2 locked", False),
        (0.8, "j6 derated to 25 %", False),
        (1.2, "j6 works again", True),
        (1.5, "j9 runs away, 3 deg/s", False),
    ]
    assert len(moments(scenario(), 0.5)) == 1


ODD_NAMES = (
    *("a" * 300, "$x_{", "_hidden", "two\nlines", "left arm 1", "left arm 2"),
    *(f"j{k}" for k in range(7, 12)),
)


def test_names_that_are_long_or_odd_do_no_harm():
    arm = sr.Arm(
        [replace(joint, name=name) for joint, name in zip(sr.arms.nasa_modular().joints, ODD_NAMES, strict=True)]
    )
    faults = [sr.Fault(name, at=0.5) for name in ODD_NAMES[:6]]
    odd = replace(scenario(faults=[]), arm=arm, faults=faults, name="$" + "t" * 300)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure, _ = drawn(odd)
        figure.savefig(BytesIO())
        laws = {"one": sr.LeastError(), "$other": sr.LeastError()}
        sr.compare(replace(odd, duration=0.1), laws).plot().savefig(BytesIO())
    (legend,) = [ax.get_legend() for ax in figure.axes if ax.get_ylabel().startswith("rate")]
    named = [text.get_text() for text in legend.get_texts()]
    assert "aaaaaaaaaaaa…aaaaaaaaaaaaa fails" in named
    assert {"$x_{ fails", " _hidden fails", "two lines fails"} <= set(named)
    (moment,) = moments(odd, 2.0)
    assert moment.text.endswith("two lines, left arm 1, left arm 2 locked")


def test_title_units_moments_and_failed_joints_are_on_the_picture():
    figure, _ = drawn(scenario())
    text = written(figure)
    assert "four faults" in text
    for words in ("j4, j2 locked", "j6 derated to 25 %", "j6 works again", "j9 runs away, 3 deg/s"):
        assert words in text
    labels = [ax.get_ylabel() for ax in figure.axes]
    expected = ("off target [mm]", "off target [deg]", "rate [% of limit]", "joints [deg]")
    assert all(name in labels for name in expected)
    assert "time [s]" in [ax.get_xlabel() for ax in figure.axes]
    space = next(ax for ax in figure.axes if ax.name == "3d")
    for name in "xyz":
        assert [label.get_text().strip() for label in getattr(space, f"get_{name}ticklabels")()][-1].startswith(
            f"{name} = "
        )
    names = {name for ax in figure.axes for name in ax.get_legend_handles_labels()[1]}
    assert {"commanded path", "path of the tool", "goal", "j4 fails", "j9 fails"} <= names
    scene_texts = {text.get_text().strip() for text in figure.axes[0].texts}
    assert {"j2", "j4", "j9"} <= scene_texts  # what is broken at the end; j6 works again
    assert "j6" not in scene_texts


@pytest.mark.parametrize("kind", [sr.Locked(), sr.Derated(0.25), sr.Runaway(0.05)])
def test_a_failed_joint_has_one_colour_in_the_whole_picture(kind):
    """A derated joint was red in space and amber in its bar."""
    figure, _ = drawn(scenario(faults=[sr.Fault("j6", at=0.8, kind=kind)]))
    state = type(kind).__name__.lower()
    (name,) = [text for text in figure.axes[0].texts if text.get_text().strip() == "j6"]
    (moment,) = [text for text in figure.axes[1].texts if text.get_text().startswith("j6")]
    assert colors.to_hex(name.get_color()) == colors.to_hex(moment.get_color()) == STATES[state]
    assert 5 in bars(figure.axes[4], state)
    hue, saturation, _ = colors.rgb_to_hsv(colors.to_rgb(STATES[state]))
    faces = [colors.rgb_to_hsv(face[:3]) for shape in figure.axes[0].collections for face in shape.get_facecolor()]
    drums = [face for face in faces if face[1] > 0.1]  # the rest of the arm is grey
    assert drums
    np.testing.assert_allclose([face[:2] for face in drums], [[hue, saturation]] * len(drums), atol=0.01)


def test_a_failed_joint_behind_a_follower_is_named_where_it_is():
    """Its name stood beside the follower."""
    up = np.eye(4)
    up[2, 3] = 0.5
    follower = sr.Follower(sr.Joint(name="f", placement=up, axis=(0, 1, 0)), leader="a", place=1)
    joints = [sr.Joint(name="a", axis=(0, 1, 0)), sr.Joint(name="b", placement=up, axis=(0, 1, 0))]
    arm = sr.Arm(joints, tool=up, followers=[follower])
    motion = sr.ConstantTwist([0.1, 0, 0, 0, 0, 0], duration=0.2)
    task = sr.Task(rows="position")
    figure, run = drawn(sr.Scenario(arm=arm, start=[0.3, 0.3], motion=motion, task=task, faults=[sr.Fault("b")]))
    (name,) = [text for text in figure.axes[0].texts if text.get_text().strip() == "b"]
    angle = run.q[-1, 0]  # of the first link, and twice that of the second
    expected = [0.5 * (np.sin(angle) + np.sin(2 * angle)), 0.0, 0.5 * (np.cos(angle) + np.cos(2 * angle))]
    np.testing.assert_allclose(name.get_position_3d(), expected, atol=1e-12)


@pytest.mark.parametrize("name", ["jammed-rail", "planar-runaway", "snake-loses-five", "hot-drives", "paper-example-2"])
def test_no_text_in_space_covers_another(name, monkeypatch):
    """Names of axes stood on their numbers, and names of neighbouring joints on each other."""
    boxes, draw = {}, Text.draw

    def watched(text, renderer):
        if text.get_text().strip() and text.get_visible():
            words, box = text.get_text(), text.get_window_extent(renderer)
            blank = 0.5 * box.width * (1.0 - len(words.lstrip()) / len(words))  # a space is half a letter
            boxes[text] = Bbox([[box.x0 + blank, box.y0], [box.x1, box.y1]]).shrunk(0.95, 0.7)  # letters, not lines
        draw(text, renderer)

    of = sr.Scenario.load(name)
    figure, _ = drawn(replace(of, period=5 * of.period))
    monkeypatch.setattr(Text, "draw", watched)
    figure.savefig(BytesIO())
    space = figure.axes[0].bbox.padded(0.0, 0.0)
    inside = {text: box for text, box in boxes.items() if space.contains(*box.min) and space.contains(*box.max)}
    assert len(inside) > 10
    pairs = combinations(inside.items(), 2)
    assert not [(one.get_text(), other.get_text()) for (one, a), (other, b) in pairs if a.overlaps(b)]


def test_the_reason_of_a_tool_that_did_not_arrive_is_on_the_picture():
    of = scenario(faults=[sr.Fault(joint, at=1.0) for joint in range(11)])
    figure, run = drawn(of)
    assert run.summary().why.sentence in written(figure)


def test_bars_begin_and_end_with_the_faults():
    figure, _ = drawn(scenario())
    timeline = figure.axes[4]
    assert bars(timeline, "locked") == {
        3: [(pytest.approx(0.4), pytest.approx(2.0))],
        1: [(pytest.approx(0.4), pytest.approx(2.0))],
    }
    assert bars(timeline, "runaway") == {8: [(pytest.approx(1.5), pytest.approx(2.0))]}
    spans = sorted(bars(timeline, "derated").get(5, []) + bars(timeline, "at rate limit").get(5, []))
    assert spans[0][0] == pytest.approx(0.8)
    assert spans[-1][1] == pytest.approx(1.2)


def test_the_lines_are_those_of_the_run():
    of = scenario(task=sr.Task(rows="position"))
    figure, run = drawn(of)
    off = figure.axes[1].get_lines()[0]
    goal = run.pose[0, :3, 3] + np.outer(run.time, [-0.2, 0.0, 0.0])
    np.testing.assert_allclose(off.get_ydata(), 1000 * np.linalg.norm(goal - run.pose[:, :3, 3], axis=1), atol=1e-9)
    assert "off target [deg]" not in [ax.get_ylabel() for ax in figure.axes]  # the task asks for no attitude
    lines = {line.get_label(): line.get_ydata() for line in figure.axes[2].get_lines()}
    np.testing.assert_allclose(lines["j9 fails"], run.rates[:, 8] / np.deg2rad(50.0) * 100, atol=1e-12)


def test_slides_are_in_millimetres_and_arms_without_limits_in_their_own_units():
    arm = sr.Arm([sr.Joint(kind="prismatic"), sr.Joint(), sr.Joint(placement=np.eye(4))])
    of = sr.Scenario(arm=arm, start=[0, 0, 0], motion=sr.ConstantTwist([0, 0, 0.1, 0, 0, 0.1], duration=0.2))
    figure, run = drawn(of)
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert "rate [deg/s, mm/s]" in labels
    assert "joints [deg, mm]" in labels
    lines = {line.get_label(): line.get_ydata() for line in figure.axes[3].get_lines()}
    np.testing.assert_allclose(lines["j1"], 1000 * run.q[:, 0])


def test_an_arm_of_thirty_joints_names_those_that_matter():
    of = sr.Scenario(
        arm=sr.arms.snake(30),
        start=np.full(30, 0.1),
        motion=sr.ConstantTwist([0, 0.1, 0, 0, 0, 0], duration=0.5),
        faults=[sr.Fault("j17", at=0.2)],
    )
    figure, _ = drawn(of)
    names = figure.axes[2].get_legend_handles_labels()[1]
    assert "j17 fails" in names
    assert "22 more" in names
    ticks = [text.get_text() for text in figure.axes[4].get_yticklabels()]
    assert "j17" in ticks
    assert len(ticks) < 16


@pytest.mark.parametrize(("failing", "named"), [((14, 15), "j15, j16"), (range(9, 15), "j10 … j15")])
def test_neighbours_among_many_joints_are_named_together(failing, named):
    of = sr.Scenario(
        arm=sr.arms.snake(30),
        start=np.full(30, 0.1),
        motion=sr.ConstantTwist([0, 0.1, 0, 0, 0, 0], duration=0.5),
        faults=[sr.Fault(joint, at=0.2) for joint in failing],
    )
    figure, _ = drawn(of)
    figure.canvas.draw()
    labels = figure.axes[4].get_yticklabels()
    assert named in [label.get_text() for label in labels]
    boxes = sorted((box.y0, box.y1) for box in (label.get_window_extent() for label in labels))
    assert all(low <= high for (_, low), (high, _) in pairwise(boxes))


@pytest.mark.parametrize("extent", [(3.0, 3.0, 0.5), (3.0, 0.2, 0.2), (0.2, 3.0, 0.2), (0.3, 0.3, 3.0)])
def test_a_scene_is_inside_the_picture(extent):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 7.6))
    ax = figure.add_axes((-0.06, 0.015, 0.49, 0.87), projection="3d")
    corners = np.array(list(product(*((0.0, side) for side in extent))))
    fit(ax, corners)
    buffer = BytesIO()
    figure.savefig(buffer, dpi=50)
    buffer.seek(0)
    ink = np.any(image.imread(buffer)[..., :3] < 1.0, axis=2)
    assert np.mean(ink) > 0.01
    for edge in (ink[:, :2], ink[:2], ink[-2:], ink[:, int(0.475 * ink.shape[1]) :]):
        assert not np.any(edge)


def test_long_runs_are_thinned_from_first_to_last():
    run = sr.simulate(scenario(faults=[], period=0.0001))
    ticks = drawn_ticks(run)
    assert (ticks[0], ticks[-1]) == (0, len(run) - 1)
    assert 4000 < len(ticks) < 12000
    assert np.all(np.diff(ticks) > 0)
    short = sr.simulate(scenario(faults=[], period=0.5))
    assert list(drawn_ticks(short)) == list(range(len(short)))


def test_laws_are_told_apart_and_one_that_runs_wild_does_not_set_the_scale():
    laws = {"least-error": sr.LeastError(), "pseudoinverse": sr.Pseudoinverse()}
    of = scenario(motion=sr.ConstantTwist([0, 0, 4.0, 0, 0, 0], duration=2.0), velocity_limits=0.05)
    figure = sr.compare(of, laws).plot()
    text = written(figure)
    assert "pseudoinverse reaches" in text
    assert "four faults" in text
    rates = next(ax for ax in figure.axes if ax.get_ylabel() == "largest rate [% of its limit]")
    assert rates.get_ylim()[1] < 200
    names = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert [name.partition(":")[0] for name in names] == list(laws)
    assert len({line.get_color() for line in rates.get_lines() if len(line.get_xdata()) > 2}) == 2


def test_a_picture_of_any_run_can_be_saved():
    one_tick = scenario(duration=0.001)
    for of in (one_tick, scenario(faults=[sr.Fault(j) for j in range(11)])):
        figure, _ = drawn(of)
        file = BytesIO()
        figure.savefig(file, format="png", dpi=30)
        assert np.ptp(image.imread(BytesIO(file.getvalue()))[..., :3]) > 0.5
