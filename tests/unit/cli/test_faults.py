"""Faults on the command line: a joint, a time, a kind with its numbers in units."""

import numpy as np
import pytest

import stillreach as sr
from stillreach.cli._faults import parse_fault

RAIL = sr.Arm.from_dh([sr.DHRow(kind="prismatic", name="rail"), sr.DHRow(a=1.0, name="turn")])


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("turn", sr.Fault("turn")),
        ("turn@2.5s", sr.Fault("turn", at=2.5)),
        ("turn:derated=0.3", sr.Fault("turn", kind=sr.Derated(0.3))),
        ("turn:runaway=-3deg/s", sr.Fault("turn", kind=sr.Runaway(np.deg2rad(-3.0)))),
        ("rail@1:runaway=5mm", sr.Fault("rail", at=1.0, kind=sr.Runaway(0.005))),
        ("turn:confined=-90deg,0.5", sr.Fault("turn", kind=sr.Confined(np.deg2rad(-90.0), 0.5))),
        ("rail:confined=0,20cm", sr.Fault("rail", kind=sr.Confined(0.0, 0.2))),
        ("turn:one-way=+1", sr.Fault("turn", kind=sr.OneWay(1))),
        ("turn:one-way=-1", sr.Fault("turn", kind=sr.OneWay(-1))),
    ],
)
def test_a_fault_is_written_as_joint_time_and_kind(text, fault):
    found = parse_fault(RAIL, text)
    assert (found.joint, found.at, type(found.kind)) == (fault.joint, fault.at, type(fault.kind))
    assert found.kind.numbers == pytest.approx(fault.kind.numbers, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "argument", "words"),
    [
        ("turn:confined=1", "--fail", "confined=LOWER,UPPER"),
        ("turn:locked=1", "--fail", "a kind of locked, derated=FRACTION"),
        ("turn:one-way=2", "--fail one-way direction", "1 or -1"),
        ("turn:confined=1,0", "--fail confined lower", "lower <= upper"),
        ("turn:runaway=5mm", "--fail runaway", "rad or deg"),
    ],
)
def test_a_fault_that_is_none_is_refused_with_what_would_be_right(text, argument, words):
    with pytest.raises(sr.InputError) as told:
        parse_fault(RAIL, text)
    assert told.value.argument == argument
    assert words in told.value.expected
