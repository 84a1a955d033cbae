"""What a scenario can hardly mean is told before it runs, unless it says that it means it."""

from dataclasses import replace

import numpy as np
import pytest

import stillreach as sr
from tests.refusals import refused

ARM = sr.arms.planar(2).with_limits(position=[(-2.0, 2.0), (-1.0, 3.0)])
WAIT = sr.ConstantTwist(np.zeros(6), 1.0)
IN_PLANE = sr.Task(rows="position")


def scenario(**settings):
    return sr.Scenario(**{"arm": ARM, "start": [0.3, 0.9], "motion": WAIT, "task": IN_PLANE, **settings})


@pytest.mark.parametrize("start", [[0.3, -45.0], [0.3, 3.001], [-np.pi, 0.0]])
def test_a_start_outside_the_position_limits_names_joint_limits_and_units(start):
    joint = int(not -2.0 <= start[0] <= 2.0) ^ 1
    with pytest.raises(sr.InputError) as told:
        scenario(start=start)
    message = str(told.value)
    limits = ["-2 … 2 rad (-114.6 … 114.6 deg)", "-1 … 3 rad (-57.3 … 171.9 deg)"]
    assert message.startswith(f"start: got {ARM.joint_names[joint]} at {start[joint]:.4g} rad (")
    assert limits[joint] in message
    assert "[units]" in message
    assert scenario(start=start, allow_outside=True).start[joint] == start[joint]


def test_the_limits_that_count_are_those_of_the_scenario():
    for limits in ([-4.0, 4.0], [[-4.0, 4.0], [-4.0, 4.0]]):
        assert scenario(start=[0.3, 3.5], position_limits=limits).start[1] == 3.5
    with refused("start", "j1", "0.3 rad"):
        scenario(position_limits=[0.5, 2.0])
    assert scenario(position_limits=[-np.inf, np.inf], start=[99.0, -99.0]).start[0] == 99.0


def test_a_start_at_a_limit_that_was_rounded_to_six_decimals_is_inside():
    assert scenario(start=[2.0 + 0.9e-6, -1.0 - 0.9e-6])
    with pytest.raises(sr.InputError, match="start"):
        scenario(start=[2.0 + 1.1e-6, 0.0])


def test_a_slide_is_told_of_in_metres():
    slide = sr.Arm([sr.Joint(name="rail", kind="prismatic", position_limits=(0.0, 2.0))])
    with refused("start", "rail", "200 m", "0 … 2 m"):
        scenario(arm=slide, start=[200.0])


GOALS = {
    "a line": (sr.Line([3.0, 0.0, 0.0], duration=1.0), "to", 3.0),
    "a shift": (sr.Line([0.0, 0.0, 4.0], relative=True, duration=1.0), "to", None),
    "a waypoint": (sr.Waypoints([[1.0, 0, 0], [0, 2.5, 0], [1.0, 0, 0]], duration=3.0), "points", 2.5),
    "a circle": (sr.Circle(centre=[1.0, 0.0, 0.0], axis=[0, 0, 1], relative=True, duration=1.0), "centre", None),
    "a row of a table": (sr.PoseTable([1.0, 2.0], [[1.0, 0, 0], [0, 0, -2.2]]), "points", 2.2),
}


@pytest.mark.parametrize(("goal", "key", "far"), GOALS.values(), ids=GOALS)
def test_a_goal_out_of_reach_is_told_before_the_run(goal, key, far):
    """Two links of 1 m reach 2 m."""
    with pytest.raises(sr.InputError) as told:
        scenario(motion=[WAIT, goal])
    assert str(told.value).startswith(f"motion[1].{key}: got a point ")
    assert "expected at most 2 m, as far as the arm reaches" in str(told.value)
    if far:
        assert f"a point {far:g} m from the base, " in str(told.value)
    run = sr.simulate(scenario(motion=[WAIT, goal], allow_outside=True))
    assert np.max(np.linalg.norm(run.pose[:, :3, 3], axis=1)) <= 2.0 + 1e-12


def test_the_reach_is_that_of_the_tasks_point_and_of_slides_within_their_limits():
    tool = np.eye(4)
    tool[0, 3] = 0.5
    goal = sr.Line([2.4, 0.0, 0.0], duration=1.0)
    assert scenario(motion=goal, task=sr.Task(rows="position", tool=tool))
    rail = sr.Joint(name="rail", kind="prismatic", axis=[1, 0, 0], position_limits=(-np.inf, np.inf))
    arm, start = sr.Arm([rail, *sr.arms.planar(2).joints], tool=sr.arms.planar(2).tool), [0.0, 0.3, 0.9]
    far = sr.Line([30.0, 0.0, 0.0], duration=1.0)
    assert scenario(arm=arm, start=start, motion=far)
    short = [[-1.0, 1.0], [-3.0, 3.0], [-3.0, 3.0]]
    with refused("motion[0].to", "3 m"):
        scenario(arm=arm, start=start, motion=far, position_limits=short)


def test_only_what_the_task_asks_for_counts():
    up = sr.Line([1.0, 1.0, 5.0], duration=1.0)
    assert scenario(motion=up, task=sr.Task(rows=[True, True, False, False, False, False]))
    assert scenario(motion=up, task=sr.Task(rows="orientation"))
    with refused("motion[0].to", "5.099 m", "y, z"):
        scenario(motion=up, task=sr.Task(rows=[False, True, True, False, False, False]))
    turning = sr.Task(rows=[False, False, True, False, False, False], frame="tool")
    assert scenario(motion=up, task=turning)  # the row turns with the tool


def test_a_twist_is_no_goal_and_what_comes_after_it_is_judged_by_its_own():
    out = sr.ConstantTwist([5.0, 0, 0, 0, 0, 0], 1.0)
    assert scenario(motion=out)
    assert scenario(motion=[out, sr.Line([1.0, 0.0, 0.0], duration=1.0)])


def test_a_stretched_arm_reaches_its_reach():
    assert scenario(motion=sr.Line([2.0 * np.cos(0.7), 2.0 * np.sin(0.7), 0.0], duration=1.0))


@pytest.mark.parametrize("value", [1, "yes", None])
def test_whether_it_is_allowed_is_true_or_false(value):
    with pytest.raises(sr.InputError, match="allow_outside"):
        scenario(allow_outside=value)


def test_a_variant_is_judged_again():
    allowed = scenario(start=[0.3, -45.0], allow_outside=True)
    assert replace(allowed, period=0.02).start[1] == -45.0
    with pytest.raises(sr.InputError, match="start"):
        replace(allowed, allow_outside=False)


FILE = """
position_limits = { j2 = [-1, 3] }
start.j1 = 0.3
start.j2 = -45
robot = { arm = "planar", n = 2 }
task = { rows = "position" }
[[motion]]
kind = "line"
to = [1500, 0, 0]
duration = 1
[[motion]]
kind = "waypoints"
duration = 1
points = [[1, 0, 0], [0, 0, 9]]
[[motion]]
kind = "pose-table"
file = "poses.csv"
"""


@pytest.fixture
def load(tmp_path):
    (tmp_path / "poses.csv").write_text("time,x,y,z\n1,7,0,0\n")

    def write_and_load(text):
        (tmp_path / "s.toml").write_text(text)
        return sr.Scenario.load(tmp_path / "s.toml")

    return write_and_load


def places(error):
    return [(mistake.line, mistake.place) for mistake in error.value.mistakes]


def test_a_file_tells_of_every_goal_out_of_reach_with_its_line(load):
    with pytest.raises(sr.errors.ScenarioFileError) as told:
        load(FILE.replace("-45", "0.9"))
    assert places(told) == [(9, "motion[0].to"), (14, "motion[1].points"), (15, "motion[2]")]
    assert told.value.mistakes[0].got == "a point 1500 m from the base"
    assert all("[units]" in mistake.expected for mistake in told.value.mistakes)


def test_a_file_tells_of_a_start_outside_with_its_line_and_of_other_mistakes_of_meaning(load):
    with pytest.raises(sr.errors.ScenarioFileError) as told:
        load(f"track_gain = 2\n{FILE}")
    assert places(told) == [(1, "track_gain"), (5, "start.j2")]
    assert "j2 at -45 rad (-2578 deg)" in told.value.mistakes[1].got
    with pytest.raises(sr.errors.ScenarioFileError) as listed:
        load(FILE.replace("start.j1 = 0.3\nstart.j2 = -45", "start = [0.3,\n -45]"))
    assert places(listed) == [(4, "start[1]")]


def test_a_joint_that_is_left_out_of_the_start_is_at_zero_and_may_be_outside(load):
    with pytest.raises(sr.errors.ScenarioFileError) as told:
        load(FILE.replace("start.j2 = -45", "").replace("[-1, 3]", "[1, 3]"))
    assert places(told) == [(3, "start.j2")]


def test_a_file_may_mean_it(load):
    allowed = load(f"allow_outside = true\n{FILE}")
    assert allowed.allow_outside
    assert allowed.start[1] == -45.0
    units = '[units]\nangle = "deg"\nlength = "mm"\n'
    assert not load(FILE.replace("[-1, 3]", "[-60, 180]").replace("[[motion]]", f"{units}[[motion]]", 1)).allow_outside


def test_every_ready_scenario_is_plausible():
    assert not any(sr.Scenario.load(name).allow_outside for name in sr.scenario_names())
