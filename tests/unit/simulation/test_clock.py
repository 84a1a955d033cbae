"""A motion whose time follows the arm: slower, and on its path."""

import numpy as np
import pytest

import stillreach as sr
from tests.robots.catalogue import ROBOTS
from tests.unit.simulation.scenario_texts import planar

HOME = np.deg2rad([0, -45, 0, -135, 0, 90, 45])
CENTRE, TIME = 0.12, 0.4


def slide(limit, **settings):
    """One slide along x, on its position alone."""
    joint = sr.Joint(name="x", kind="prismatic", axis=(1, 0, 0), velocity_limit=limit)
    defaults = {"start": [0.0], "task": sr.Task(rows=(True, *[False] * 5)), "law": sr.KeepDirection(), "clock": "arm"}
    return sr.Scenario(arm=sr.Arm([joint]), **{**defaults, **settings})


def circle(clock, duration):
    """A Panda's tool round a circle of 12 cm radius in 0.4 s: nearly 2 m/s."""
    motion = sr.Circle(centre=[0, CENTRE, 0], axis=[1, 0, 0], duration=TIME, relative=True)
    settings = {"law": sr.KeepDirection(), "period": 0.001, "loop": "closed", "clock": clock, "duration": duration}
    return sr.Scenario(arm=ROBOTS["Panda"].make(), start=HOME, motion=motion, **settings)


def off_circle(scenario, run):
    """Largest distance of the tool from the circle, by geometry alone."""
    x, y, z = np.moveaxis(run.pose[:, :3, 3] - scenario.task_pose(scenario.start)[:3, 3], 1, 0)
    return np.max(np.hypot(x, np.hypot(y - CENTRE, z) - CENTRE))


def test_a_circle_too_fast_for_a_panda_is_left_by_the_clock_and_kept_to_by_the_arms():
    late, patient = circle("time", 1.0), circle("arm", 1.0)
    behind, run = sr.simulate(late), sr.simulate(patient)
    assert off_circle(late, behind) > 0.05  # cuts across
    assert run.scale.min() < 0.5
    assert off_circle(patient, run) < 1e-3
    arrival = run.time[np.argmax(run.path_time >= TIME)]
    assert 1.5 * TIME < arrival < 1.0
    found = run.summary()
    assert found.finished
    assert found.distance.value < 2e-3  # from where its path time wants it
    assert found.beside < 1e-3


def test_path_time_is_what_was_done_of_the_time():
    run = sr.simulate(circle("arm", 0.5))
    np.testing.assert_allclose(np.diff(run.path_time), 0.001 * run.scale[:-1], atol=1e-15)
    assert run.path_time[0] == 0.0


def test_half_the_speed_takes_twice_the_time():
    run = sr.simulate(slide(0.5, motion=sr.Line([1, 0, 0], duration=1.0), duration=3.0))
    np.testing.assert_allclose(run.path_time[:201], 0.5 * run.time[:201], atol=1e-12)
    np.testing.assert_allclose(run.q[:201, 0], 0.5 * run.time[:201], atol=1e-12)
    np.testing.assert_allclose(run.q[200:, 0], 1.0, atol=1e-12)  # and stays


@pytest.mark.parametrize("loop", ["open", "closed"])
def test_no_step_crosses_from_one_part_to_the_next(loop):
    """At 0.3 m/s no tick ends where a part does: the last one goes only as far as the part."""
    out = sr.Line([1, 0, 0], duration=1.0)
    back = sr.ConstantTwist([-1, 0, 0, 0, 0, 0], duration=0.5)
    run = sr.simulate(slide(0.3, motion=[out, back], duration=6.0, loop=loop))
    assert run.q.max() == pytest.approx(1.0, abs=1e-12)
    assert run.q[-1, 0] == pytest.approx(0.5, abs=1e-12)


def test_a_locked_arm_stops_the_motion_until_it_is_restored():
    fault = sr.Fault("x", at=0.5, until=1.5)
    run = sr.simulate(slide(2.0, motion=sr.Line([1, 0, 0], duration=1.0), duration=2.5, faults=[fault]))
    held = (run.time >= 0.5) & (run.time < 1.5)
    np.testing.assert_allclose(run.path_time[held], 0.5, atol=1e-12)
    assert np.all(run.scale[held] == 0.0)
    assert np.all(run.status[held] & sr.Status.SCALED)
    assert run.q[-1, 0] == pytest.approx(1.0, abs=1e-12)
    assert run.time[np.argmax(run.path_time >= 1.0 - 1e-9)] == pytest.approx(2.0)


@pytest.mark.parametrize("law", [sr.LeastError(), sr.SingularityRobust(), sr.Pseudoinverse()])
def test_laws_that_do_the_whole_twist_or_miss_it_run_on_time(law):
    run = sr.simulate(slide(0.5, motion=sr.Line([1, 0, 0], duration=1.0), duration=2.0, law=law))
    np.testing.assert_allclose(run.path_time, run.time, atol=1e-12)


def test_a_function_of_time_is_asked_at_the_path_time():
    speed = 2.0
    run = sr.simulate(slide(0.5, motion=lambda t: [speed * (t < 1.0), 0, 0, 0, 0, 0], duration=6.0))
    assert run.q[-1, 0] == pytest.approx(speed, abs=0.02)  # a tick of it
    assert run.time[np.argmax(run.path_time >= 1.0)] == pytest.approx(4.0, abs=0.05)


def test_an_unlimited_run_is_the_same_by_both_clocks():
    motion = [
        sr.Circle(centre=[0, 0.05, 0], axis=[1, 0, 0], duration=1.0, relative=True),
        sr.ConstantTwist([0.01] * 6, 0.5),
    ]
    settings = {"arm": ROBOTS["Panda"].make(), "start": HOME, "duration": 2.0, "law": sr.KeepDirection()}
    runs = [
        sr.simulate(sr.Scenario(**settings, motion=motion, clock=clock, loop="closed")) for clock in ("time", "arm")
    ]
    assert np.all(runs[0].scale == 1.0)
    np.testing.assert_allclose(runs[1].q, runs[0].q, atol=1e-12)
    np.testing.assert_array_equal(runs[1].path_time, runs[0].path_time)


def test_a_motion_that_is_cut_off_has_not_arrived():
    scenario = slide(0.25, motion=sr.Line([1, 0, 0], duration=1.0), duration=2.0)
    found = sr.simulate(scenario).summary()
    assert not found.finished
    assert found.goal_distance == pytest.approx(0.5, abs=1e-9)
    assert found.distance.value < 1e-9


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"duration": None}, "duration: got None, expected a time above 0: with clock='arm'"),
        ({"duration": 2.0, "integrator": "rk4"}, "integrator: got 'rk4', expected 'euler' with clock='arm'"),
        ({"duration": 2.0, "clock": "tool"}, "clock: got 'tool', expected one of 'time', 'arm'"),
    ],
)
def test_what_does_not_go_with_it_is_refused(settings, message):
    with pytest.raises(sr.InputError, match=message.replace("'", ".")):
        slide(0.5, motion=sr.Line([1, 0, 0], duration=1.0), **settings)


def test_a_file_says_the_clock(load, mistakes):
    law = '[law]\nkind = "keep-direction"'
    assert load(planar(top='clock = "arm"\nduration = 3', tables=law)).clock == "arm"
    assert load(planar()).clock == "time"
    found = mistakes(planar(top='clock = "arm"\nintegrator = "rk4"', tables=law))
    assert found.keys() == {"duration", "integrator"}
    assert "as long as the arm needs" in found["duration"].expected
    assert '"euler"' in found["integrator"].expected
