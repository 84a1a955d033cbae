"""The scenarios that come with the package do what their descriptions say."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

import stillreach as sr
from stillreach._rotations import log
from stillreach.simulation.commanded import commanded

FOLDER = Path(sr.__file__).parent / "scenarios"


def text(name):
    return (FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def result(name):
    """A run, and how far the tool is from where it should be: distance [m] and angle [rad] at each tick."""
    scenario = sr.Scenario.load(name)
    run, goal = sr.simulate(scenario), commanded(scenario, looks=10**9).poses
    shift = np.linalg.norm(goal[:, :3, 3] - run.pose[:, :3, 3], axis=1)
    turn = np.linalg.norm(log(goal[:, :3, :3] @ np.swapaxes(run.pose[:, :3, :3], 1, 2)), axis=1)
    return scenario, run, shift, turn


def test_there_are_ten_and_the_wheel_holds_their_files():
    assert len(sr.scenario_names()) == 10
    assert {path.stem for path in FOLDER.glob("*.toml")} == set(sr.scenario_names())
    assert (FOLDER / "figure-eight.csv").is_file()


@pytest.mark.parametrize("name", sr.scenario_names())
def test_each_says_what_it_shows(name):
    content = tomllib.loads(text(name))
    assert content["name"]
    assert len(content["description"]) > 80
    assert content["faults"]


@pytest.mark.parametrize("name", sr.scenario_names())
def test_each_runs_and_its_bounds_hold(name):
    scenario, run, _, _ = result(name)
    assert np.all(run.rates >= run.lower)
    assert np.all(run.rates <= run.upper)
    for fault in scenario.faults:
        if isinstance(fault.kind, sr.Locked):
            stuck = run.q[scenario.tick_at(fault.at) :, scenario.arm.joint_index(fault.joint)]
            assert np.all(stuck == stuck[0])


def test_a_panda_without_its_elbow_brings_the_bucket_to_its_place():
    scenario, run, shift, turn = result("panda-elbow")
    handle = run.pose[:, :3, 1]
    assert np.max(shift) < 5e-4
    assert np.max(np.linalg.norm(handle - handle[0], axis=1)) < np.deg2rad(0.05)
    assert np.rad2deg(turn[-1]) > 30.0  # about the handle
    assert len(commanded(scenario).poses) > 400
    healthy = sr.simulate(replace(scenario, faults=()))
    elbow = scenario.arm.joint_index("panda_joint4")
    assert np.ptp(np.rad2deg(healthy.q[run.time >= 2.0, elbow])) > 10.0  # what the others have to make up for


def test_a_panda_without_its_elbow_cannot_keep_the_whole_attitude():
    scenario = replace(sr.Scenario.load("panda-elbow"), task=sr.Task())
    found = sr.simulate(scenario).summary()
    assert not found.finished
    assert found.goal_distance > 0.05
    assert nearest(scenario) > 0.05


def nearest(scenario):
    """[m] plus [rad] from the goal to what a locked elbow can reach; searched from many configurations by SciPy."""
    goal, arm = commanded(scenario).poses[-1], scenario.arm
    run = sr.simulate(scenario)
    elbow = arm.joint_index("panda_joint4")
    rest = np.delete(np.arange(arm.n), elbow)
    lower, upper = arm.position_limits[rest].T

    def apart(values):
        q = np.insert(values, elbow, run.q[-1, elbow])
        T = arm.forward(q)
        return np.concatenate([T[:3, 3] - goal[:3, 3], log((goal[:3, :3] @ T[:3, :3].T)[None])[0]])

    rng = np.random.default_rng(4)
    starts = [run.q[-1, rest], *rng.uniform(lower, upper, (20, len(rest)))]
    found = [least_squares(apart, np.clip(start, lower, upper), bounds=(lower, upper)) for start in starts]
    return min(np.linalg.norm(one.fun) for one in found)


@pytest.mark.parametrize(
    ("name", "distance", "angle"),
    [
        ("paper-example-1", 0.01, 0.2),  # an open loop drifts
        ("paper-example-2-feedback", 1e-3, 0.05),
        ("canadarm2-shoulder", 1e-3, 0.05),
        ("snake-loses-five", 1e-3, 0.05),
        ("jammed-rail", 1e-3, 0.05),
        ("figure-eight", 2e-3, 0.2),
        ("planar-runaway", 2e-3, 180.0),  # the attitude is no part of the task
    ],
)
def test_most_arms_stay_on_their_task_whatever_fails(name, distance, angle):
    _, _, shift, turn = result(name)
    assert np.max(shift) < distance
    assert np.rad2deg(np.max(turn)) < angle


def test_the_papers_law_leaves_the_line_in_the_second_example():
    _, run, shift, _ = result("paper-example-2")
    assert shift[-1] > 1.0
    assert np.max(np.abs(run.rates)) <= np.deg2rad(50) * (1 + 1e-12)


def test_hot_drives_slow_the_tool_down_and_it_arrives_late_without_leaving_the_line():
    scenario, run, shift, turn = result("hot-drives")
    along = np.array([-1.5, -0.8, 0.6])
    moved = run.pose[:, :3, 3] - run.pose[0, :3, 3]
    off = moved - np.outer(moved @ along / (along @ along), along)
    assert np.min(run.scale) < 0.7
    assert np.max(shift) > 0.05
    assert shift[-1] < 1e-3
    assert np.max(np.linalg.norm(off, axis=1)) < 1e-5
    assert np.max(turn) < 1e-6
    assert run.summary().beside < 1e-5
    assert np.all(np.diff(moved @ along) > -1e-6)
    least = sr.simulate(replace(scenario, law=sr.LeastError())).pose[:, :3, 3] - run.pose[0, :3, 3]
    assert np.max(np.linalg.norm(least - np.outer(least @ along / (along @ along), along), axis=1)) > 0.01


@pytest.mark.parametrize("name", sr.scenario_names())
def test_each_arrives_but_the_one_that_shows_a_limit_and_says_so(name):
    scenario = sr.Scenario.load(name)
    told = "does not arrive" in " ".join(scenario.description.split())
    assert sr.simulate(scenario).summary().finished is not told
    assert told is (name == "paper-example-2")


def test_a_jammed_rail_stops_and_the_arm_makes_up_for_it():
    _, run, _, _ = result("jammed-rail")
    assert run.joint_units[0] == "m"
    assert run.q[300, 0] > 0.4
    assert np.all(run.rates[300:, 0] == 0.0)
    assert np.any(run.rates[300:, 1:] != 0.0)
