"""Values read off runs that are made by hand, so that each value is known beforehand."""

import numpy as np
import pytest

import stillreach as sr
from stillreach.paper import measure

INCH = 0.0254


def straight_run(places, rates=None, attitude=None, **arrays):
    """A run of a one-joint arm, a tick a second, told to go 2 in/s along x; `places` (T, 3) [in]."""
    ticks = len(places)
    pose = np.tile(np.eye(4), (ticks, 1, 1))
    pose[:, :3, 3] = np.array(places) * INCH
    if attitude is not None:
        pose[:, :3, :3] = attitude
    twist = [2 * INCH, 0, 0, 0, 0, 0]
    target = np.tile(pose[0], (ticks, 1, 1))
    target[:, :3, 3] += np.outer(np.arange(ticks), twist[:3])
    values = {
        "time": np.arange(ticks, dtype=float),
        "path_time": np.arange(ticks, dtype=float),
        "q": np.zeros((ticks, 1)),
        "rates": np.zeros((ticks, 1)) if rates is None else np.deg2rad(rates)[:, None],
        "pose": pose,
        "target": target,
        "command": np.tile(twist, (ticks, 1)),
        "residual": np.zeros((ticks, 6)),
        "lower": np.full((ticks, 1), -1.0),
        "upper": np.full((ticks, 1), 1.0),
        "health": np.zeros((ticks, 1), np.int8),
        "measured": np.zeros((ticks, 1)),
        "known": np.zeros((ticks, 1), np.int8),
        "active": np.zeros((ticks, 1), np.int8),
        "status": np.zeros(ticks, np.int32),
        **{name: np.zeros(ticks) for name in ("task_error", "damping", "scale")},
        **arrays,
    }
    motion = sr.ConstantTwist(twist, duration=float(ticks))
    return sr.Run(**values, scenario=sr.Scenario(arm=sr.Arm([sr.Joint()]), start=[0.0], motion=motion, period=1.0))


def test_displacement_and_deviation_are_in_inches_and_degrees():
    c, s = np.cos(np.deg2rad(10)), np.sin(np.deg2rad(10))
    attitudes = np.array([np.eye(3), np.eye(3), [[c, 0, s], [0, 1, 0], [-s, 0, c]]])
    run = straight_run([(1, 1, 1), (2, 1, 1), (3, 2, -1)], attitude=attitudes)
    np.testing.assert_allclose(measure.displacement(run), (2, 1, -2))
    np.testing.assert_allclose(measure.commanded_displacement(run), (4, 0, 0))
    np.testing.assert_allclose(measure.deviation(run), (-2, 1, -2, 10, 0, 0), atol=1e-12)
    distance, angle = measure.off_target(run)
    np.testing.assert_allclose(distance, (0, 1, 3))
    np.testing.assert_allclose(angle, (0, 0, 10))


def test_the_distance_from_the_line_does_not_count_what_is_along_it():
    assert measure.off_the_line(straight_run([(0, 0, 0), (50, 3, 4), (-9, 1, 0)])) == pytest.approx(5.0)


def test_a_limit_is_passed_between_two_ticks():
    run = straight_run(np.zeros((5, 3)), rates=np.array([10.0, 40.0, -60.0, 10.0, 90.0]))
    assert measure.passes(run, 50.0) == pytest.approx(1.5)
    assert measure.passes(run, 5.0) == 0.0
    assert np.isnan(measure.passes(run, 100.0))
    assert measure.largest_rate(run) == pytest.approx(90.0)
    assert measure.variation_of_the_rates(run) == pytest.approx(30 + 100 + 70 + 80)


def test_damping_is_read_where_there_is_some():
    damping = np.array([0.0, 0.2, 0.3, 0.7, 0.0])
    run = straight_run(np.zeros((5, 3)), rates=np.array([90.0, 10.0, 20.0, 30.0, 90.0]), damping=damping)
    assert measure.median_damping(run) == pytest.approx(0.3)
    assert measure.rate_used_while_damped(run) == pytest.approx(20.0)
    assert measure.largest_jump_of_damping(run) == pytest.approx(0.7)
    assert np.isnan(measure.median_damping(straight_run(np.zeros((3, 3)))))


def test_the_error_of_the_task_adds_up_inches_and_degrees():
    residual = np.array([[3 * INCH, 0, 0, 0, np.deg2rad(4), 0]] * 3)
    assert measure.error_of_the_task(straight_run(np.zeros((3, 3)), residual=residual)) == pytest.approx(10.0)


def test_two_tools_are_apart_by_their_largest_distance_and_angle():
    c, s = np.cos(np.deg2rad(10)), np.sin(np.deg2rad(10))
    attitudes = np.array([np.eye(3), [[c, 0, s], [0, 1, 0], [-s, 0, c]], np.eye(3)])
    one, other = straight_run([(0, 0, 0), (1, 0, 0), (2, 0, 0)]), straight_run([(0, 0, 0), (1, 3, 4), (2, 1, 0)])
    turned = straight_run([(0, 0, 0), (1, 0, 0), (2, 0, 0)], attitude=attitudes)
    np.testing.assert_allclose(measure.apart(one, other), (5, 0), atol=1e-12)
    np.testing.assert_allclose(measure.apart(one, turned), (0, 10), atol=1e-9)


def test_damping_begins_at_its_first_tick_above_zero():
    assert measure.first_damped(straight_run(np.zeros((4, 3)), damping=np.array([0.0, 0.0, 0.1, 0.0]))) == 2.0
    assert np.isnan(measure.first_damped(straight_run(np.zeros((4, 3)))))
