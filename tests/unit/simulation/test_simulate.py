import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stillreach as sr
from stillreach.simulation import simulate as function
from tests.unit.arm.literal_kinematics import cross_matrix
from tests.unit.simulation.scenarios import eight_joints, eight_joints_start, followed, small_run, waving


def scenario(**changes):
    settings = {"motion": waving, "law": sr.Pseudoinverse(), "period": 0.01, "duration": 1.0}
    return sr.Scenario(**{"arm": eight_joints(), "start": eight_joints_start(), **settings, **changes})


def test_a_run_has_a_row_for_each_tick_and_one_at_the_final_state():
    run = sr.simulate(scenario(period=0.1, duration=2.0))
    assert len(run) == 21
    np.testing.assert_array_equal(run.time, 0.1 * np.arange(21))


@pytest.mark.parametrize(
    ("period", "duration", "steps"), [(0.1, 0.3, 3), (0.3, 1.0, 3), (0.001, 1.0, 1000), (1 / 3, 1.0, 3), (0.5, 0.2, 0)]
)
def test_the_last_tick_is_the_last_one_not_after_the_duration(period, duration, steps):
    assert sr.simulate(scenario(period=period, duration=duration)).time[-1] == pytest.approx(steps * period)


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_each_row_says_what_was_true_at_its_tick(integrator):
    run = sr.simulate(scenario(integrator=integrator))
    arm = eight_joints()
    np.testing.assert_allclose(run.pose, arm.forward(run.q), atol=1e-12)
    made = np.einsum("tij,tj->ti", arm.jacobian(run.q), run.rates)
    np.testing.assert_allclose(run.residual, run.command - made, atol=1e-12)
    np.testing.assert_allclose(run.task_error, np.linalg.norm(run.residual, axis=1), atol=1e-12)


def test_an_euler_step_holds_the_rates_until_the_next_tick():
    run = sr.simulate(scenario())
    np.testing.assert_allclose(np.diff(run.q, axis=0), 0.01 * run.rates[:-1], atol=1e-15)


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_the_size_of_the_chunks_changes_nothing(integrator, monkeypatch):
    whole = small_run(integrator=integrator)
    module = sys.modules["stillreach.simulation.simulator"]
    monkeypatch.setattr(module, "FIRST_CHUNK", 1)
    monkeypatch.setattr(module, "CHUNK_SECONDS", 0.0)
    pieces = small_run(integrator=integrator)
    for name in ("q", "rates", "pose", "residual", "damping", "status", "health", "lower", "upper"):
        assert np.array_equal(getattr(whole, name), getattr(pieces, name)), name


def test_the_same_scenario_gives_the_same_run():
    assert np.array_equal(small_run().q, small_run().q)


def test_no_rate_limit_is_said_so():
    run = small_run(velocity_limits=np.inf, law=sr.Pseudoinverse(), faults=())
    assert np.all(np.isinf(run.upper))
    assert np.all(np.isinf(run.scenario.velocity_limits))
    assert small_run().scenario.velocity_limits is None  # the arm's


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"arm": "panda"}, "arm: got 'panda', expected an Arm"),
        ({"start": np.zeros(7)}, "start: .*8 finite numbers"),
        ({"start": [np.nan] * 8}, "start: got nan at index 0"),
        ({"period": 0.0}, "period: .*above 0"),
        ({"duration": -1.0}, "duration: .*above 0"),
        ({"integrator": "rk45"}, "integrator: .*did you mean 'rk4'"),
        ({"velocity_limits": -1.0}, "velocity_limits"),
    ],
)
def test_a_wrong_setting_is_refused_by_name(changes, message):
    with pytest.raises(sr.InputError, match=message):
        sr.simulate(scenario(**changes))


def test_a_bar_is_shown_on_request_and_not_without_a_terminal(capsys):
    function(scenario(), progress=True)
    assert "simulating" in capsys.readouterr().err
    function(scenario())
    assert capsys.readouterr().err == ""


def test_feedback_keeps_the_tool_on_its_path_where_steps_alone_drift():
    """The path of a function of time, integrated by SciPy on its own."""

    def followed(t, state):
        twist = np.asarray(waving(t))
        return [*twist[:3], *(cross_matrix(twist[3:]) @ state[3:].reshape(3, 3)).ravel()]

    runs = [
        sr.simulate(scenario(duration=2.0, **settings))
        for settings in (
            {},
            {"loop": "closed", "track_gain": 5.0},
            {"loop": "closed", "track_gain": 5.0, "integrator": "rk4"},
        )
    ]
    start = runs[0].pose[0]
    state = [*start[:3, 3], *start[:3, :3].ravel()]
    state = solve_ivp(followed, (0.0, 2.0), state, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    drift = [np.linalg.norm(np.append(run.pose[-1, :3, 3], run.pose[-1, :3, :3].ravel()) - state) for run in runs]
    assert drift[0] > 2e-3
    assert drift[1] < drift[0] / 4
    assert drift[2] < 1e-7


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_with_feedback_the_tool_waits_at_the_end_of_the_path(integrator):
    motion = [sr.ConstantTwist([0.1, 0, 0, 0, 0, 0.2], 0.5), sr.ConstantTwist([0, -0.1, 0.05, 0, 0.1, 0], 0.5)]
    run = sr.simulate(scenario(motion=motion, duration=4.0, loop="closed", track_gain=5.0, integrator=integrator))
    expected = followed(run.pose[0], [part.twist for part in motion], [0.5, 0.5])[-1]
    np.testing.assert_allclose(run.pose[-1], expected, atol=1e-6)
    np.testing.assert_allclose(run.rates[-1], 0.0, atol=1e-6)
