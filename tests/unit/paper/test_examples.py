import numpy as np
import pytest

import stillreach as sr
from oracles.kinematics import INCH, paper_arm
from stillreach.paper import examples, scenarios


@pytest.mark.parametrize(
    ("name", "start", "command"),
    [
        (examples.EXAMPLE_1_FREE, (45, -60, 0, -45, 0, 45, 90, 45, 0, 0, 0), (-5.5, -2.5, 1.5, 0, 0, 0)),
        (examples.EXAMPLE_2_FREE, (0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0), (-5, 0, 0, 0, 0, 0)),
    ],
)
def test_start_and_command_are_those_printed_in_section_6(name, start, command):
    scenario = scenarios()[name]
    np.testing.assert_allclose(np.rad2deg(scenario.start), start, atol=1e-12)
    run = sr.simulate(scenario)
    np.testing.assert_allclose(run.command[0] / ([INCH] * 3 + [np.deg2rad(1)] * 3), command, atol=1e-12)


def test_the_duration_changes_how_long_the_velocity_is_commanded_and_not_the_velocity():
    for name, scenario in scenarios(duration=7.0).items():
        usual = scenarios()[name]
        assert (scenario.duration, usual.duration) == (7.0, 20.0)
        assert np.array_equal(scenario.motion[0].twist, usual.motion[0].twist)


def test_the_start_of_example_2_lies_in_a_plane():
    tool, _, jacobian = paper_arm(scenarios()[examples.EXAMPLE_2_FREE].start)
    assert tool[1] == 0.0
    assert np.all(jacobian[1, 1::2] == 0.0)  # no pitch joint moves the tool sideways


def test_only_the_pseudoinverse_run_has_no_rate_limit_and_says_so():
    for name, scenario in scenarios().items():
        unlimited = np.all(np.isinf(scenario.velocity_limits))
        assert unlimited == (name == examples.EXAMPLE_2_PSEUDOINVERSE) == ("without rate limit" in scenario.name)
        if not unlimited:
            assert np.all(np.abs(scenario.velocity_limits) == np.deg2rad(50.0))


def test_damping_is_in_inches_and_degrees():
    for name in (examples.EXAMPLE_2_CLOSED_FORM, examples.EXAMPLE_2_EXACT):
        weights = scenarios()[name].law.weights
        assert (weights.length, weights.angle) == (0.0254, np.deg2rad(1.0))


@pytest.mark.parametrize("settings", [{"duration": 0.0}, {"step": -0.1}, {"lengths": [1.0] * 5}, {"duration": np.nan}])
def test_settings_that_cannot_be_are_refused(settings):
    with pytest.raises(sr.InputError, match=next(iter(settings))):
        scenarios(**settings)
