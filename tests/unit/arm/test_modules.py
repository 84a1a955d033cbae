"""Arms put together from roll and pitch modules."""

import numpy as np
import pytest

import stillreach as sr


def test_a_roll_sits_in_the_middle_and_a_segment_without_one_is_whole():
    arm = sr.Arm.from_modules("PRP", lengths=[1.0, 2.0, 3.0])
    heights = np.cumsum([joint.placement[2, 3] for joint in arm.joints])
    np.testing.assert_array_equal(heights, [1.0, 2.0, 3.0])
    assert [joint.axis.tolist() for joint in arm.joints] == [[0, -1, 0], [0, 0, 1], [0, -1, 0]]
    assert arm.tool[2, 3] == 3.0


def test_the_last_segment_may_hold_a_roll():
    arm = sr.Arm.from_modules("PR", lengths=[1.0, 4.0])
    np.testing.assert_array_equal([joint.placement[2, 3] for joint in arm.joints], [1.0, 2.0])
    assert arm.tool[2, 3] == 2.0


def test_one_roll_alone_turns_a_tool_that_stays_put():
    arm = sr.Arm.from_modules("R", lengths=[2.0])
    np.testing.assert_array_equal(arm.jacobian([0.3])[:, 0], [0, 0, 0, 0, 0, 1])
    np.testing.assert_array_equal(arm.forward([0.3])[:3, 3], [0, 0, 2])


def test_a_segment_may_have_no_length():
    arm = sr.Arm.from_modules("RPRP", lengths=[1.0, 0.0, 0.5])
    np.testing.assert_allclose(arm.forward([0, 0, 0, np.pi / 2])[:3, 3], [-0.5, 0, 1], atol=1e-15)


def test_the_catalogue_arm_is_this_builder():
    arm = sr.Arm.from_modules("RPRPRPRPRPR", lengths=[0.762] * 6, velocity_limits=np.deg2rad(50), name="nasa_modular")
    assert arm == sr.arms.nasa_modular()


def test_rate_limits_one_for_all_or_one_each():
    assert sr.Arm.from_modules("RP", [1, 1], velocity_limits=2).velocity_limits.tolist() == [2, 2]
    assert sr.Arm.from_modules("RP", [1, 1], velocity_limits=[2, 3]).velocity_limits.tolist() == [2, 3]
    assert sr.Arm.from_modules("RP", [1, 1]).velocity_limits.tolist() == [np.inf, np.inf]


@pytest.mark.parametrize(
    ("sequence", "told"),
    [
        ("RPRRP", "two rolls in one segment (places 2 and 3 of 'RPRRP')"),
        ("RR", "two rolls in one segment (places 0 and 1 of 'RR')"),
        ("RPX", "'X' at place 2 of 'RPX'"),
        ("rp", "'r' at place 0 of 'rp'"),
        ("RPR-PR", "'-' at place 3"),
        ("", "''"),
        (None, "None"),
        (["R", "P"], "['R', 'P']"),
    ],
)
def test_another_sequence_is_refused(sequence, told):
    with pytest.raises(sr.InputError) as caught:
        sr.Arm.from_modules(sequence, [1, 1, 1])
    assert caught.value.argument == "sequence"
    assert told in caught.value.got


@pytest.mark.parametrize("lengths", [[1, 1], [1, 1, 1, 1], [1, -0.1, 1], [1, np.nan, 1], [1, np.inf, 1], None, "11"])
def test_as_many_lengths_as_pitches_and_one(lengths):
    with pytest.raises(sr.InputError, match=r"lengths: got .*, expected 3 finite numbers"):
        sr.Arm.from_modules("RPRP", lengths)


@pytest.mark.parametrize("limits", [-1, [1, 2, 3], np.nan, [1, -1e-9], "fast"])
def test_rate_limits_are_refused_under_their_own_name(limits):
    with pytest.raises(sr.InputError, match=r"velocity_limits: got .*, expected 2 numbers .* each at least 0"):
        sr.Arm.from_modules("RP", [1, 1], velocity_limits=limits)
