import numpy as np
import pytest

import stillreach as sr
from oracles.kinematics import INCH, paper_arm
from stillreach.paper import examples, scenarios


def test_the_start_of_example_1_is_the_printed_one_and_its_tool_is_where_the_text_says():
    start = scenarios()[examples.EXAMPLE_1_FREE].start
    tool, _, _ = paper_arm(start)
    np.testing.assert_allclose(tool / INCH, (113.2, 53.2, 73.4), atol=0.05)


def test_the_start_of_example_2_lies_in_a_plane_with_non_zero_values_at_joints_2_4_6_8():
    start = scenarios()[examples.EXAMPLE_2_FREE].start
    assert np.flatnonzero(start).tolist() == [1, 3, 5, 7]
    tool, _, jacobian = paper_arm(start)
    assert tool[1] == 0.0
    assert np.all(jacobian[1, 1::2] == 0.0)  # no pitch joint moves the tool sideways


def test_only_the_pseudoinverse_run_has_no_rate_limit_and_says_so():
    for name, scenario in scenarios().items():
        unlimited = np.all(np.isinf(scenario.rate_limits))
        assert unlimited == (name == examples.EXAMPLE_2_PSEUDOINVERSE) == ("without rate limit" in scenario.name)
        if not unlimited:
            assert np.all(scenario.rate_limits == np.deg2rad(50.0))


def test_damping_is_in_inches_and_degrees():
    for name in (examples.EXAMPLE_2_CLOSED_FORM, examples.EXAMPLE_2_EXACT):
        weights = scenarios()[name].law.weights
        assert (weights.length, weights.angle) == (0.0254, np.deg2rad(1.0))


@pytest.mark.parametrize("settings", [{"duration": 0.0}, {"step": -0.1}, {"lengths": [1.0] * 5}, {"duration": np.nan}])
def test_settings_that_cannot_be_are_refused(settings):
    with pytest.raises(sr.InputError, match=next(iter(settings))):
        scenarios(**settings)
