"""Errors carry their data, are one family, and survive pickling."""

import pickle

import pytest

from stillreach import errors

ALL = [
    errors.InputError("q", "nan at index 1", "3 finite numbers"),
    errors.UnknownJointError("joint", "'j9'", ["j1", "j2", "j3", "j4"]),
    errors.RobotFileError("path", "'x'", "one of a, b", "arm.urdf", 12, "joint 'elbow'", ["a", "b"]),
    errors.MissingExtraError("netcdf", "run.save()"),
    errors.SimulationInterrupted({"rows": 3}),
    errors.PageNotBuiltError(),
    errors.ScenarioFileError(
        "run.toml", [errors.Mistake("faults[1].joint", "'j44'", "j1 … j11", "did you mean 'j4'?", 7)]
    ),
]


@pytest.mark.parametrize("error", ALL, ids=lambda error: type(error).__name__)
def test_every_error_is_a_stillreach_error_and_survives_pickling(error):
    assert isinstance(error, errors.StillreachError)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert again.__dict__ == error.__dict__
    assert again.args == error.args
    assert str(again) == str(error)


def test_every_error_class_of_the_module_is_tried_here():
    classes = {value for value in vars(errors).values() if isinstance(value, type) and issubclass(value, BaseException)}
    assert classes - {errors.StillreachError} == {type(error) for error in ALL}


def test_builtin_handlers_catch_them_too():
    with pytest.raises(ValueError, match=r"^q: "):
        raise ALL[0]
    with pytest.raises(ValueError, match="j9"):
        raise ALL[1]
    with pytest.raises(ImportError):
        raise ALL[3]
    with pytest.raises(KeyboardInterrupt):
        raise ALL[4]


def test_input_error_holds_what_it_says():
    error = ALL[0]
    assert (error.argument, error.got, error.expected) == ("q", "nan at index 1", "3 finite numbers")


@pytest.mark.parametrize(
    ("choices", "listed"),
    [
        (["j1", "j2", "j3", "j4"], "j1 … j4"),
        (["a07", "a08", "a09", "a10"], "a07, a08, a09, a10"),
        (["j1", "j2", "j4", "j5"], "j1, j2, j4, j5"),
        (["1", "2", "3", "4"], "1 … 4"),
        (["j1", "j2"], "j1, j2"),
        (["base", "arm", "wrist", "hand", "tool"], "base, arm, wrist, hand, tool"),
    ],
)
def test_an_unknown_joint_lists_the_choices(choices, listed):
    error = errors.UnknownJointError("joint", "'x'", choices)
    assert error.choices == error.args[2] == tuple(choices)
    assert str(error) == f"joint: got 'x', expected one of {listed} or an index from 0 to {len(choices) - 1}"


def test_an_error_of_a_robot_file_names_file_line_and_element():
    assert str(ALL[2]) == "arm.urdf, line 12, joint 'elbow': got 'x', expected one of a, b"
    assert (ALL[2].file, ALL[2].line, ALL[2].element, ALL[2].choices) == ("arm.urdf", 12, "joint 'elbow'", ("a", "b"))
    asked = errors.RobotFileError("tip", "'x'", "a link", "arm.urdf")
    assert str(asked) == "arm.urdf, tip: got 'x', expected a link"


def test_a_missing_extra_names_the_command_that_installs_it():
    assert str(ALL[3]) == "run.save() needs an optional part: pip install 'stillreach[netcdf]'"
    assert ALL[3].extra == "netcdf"


def test_an_interrupted_simulation_holds_its_run():
    assert ALL[4].run == {"rows": 3}
    assert ".run" in str(ALL[4])
