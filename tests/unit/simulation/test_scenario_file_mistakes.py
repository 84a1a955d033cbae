"""Everything that is wrong in a scenario file is said at once, each with its place."""

import pickle

import pytest

import stillreach as sr
from tests.unit.simulation.scenario_texts import EIGHT, EIGHT_MISTAKES, PLANAR, planar

COUPLED = [[2.0 if i == j else float({i, j} == {0, 3}) for j in range(6)] for i in range(6)]
"""Weights of a task in which vx and wx belong together."""
WAIT = '[[motion]]\nkind = "wait"\nduration = 1\n'


def test_eight_different_mistakes_are_all_listed_with_line_place_expectation_and_hint(mistakes):
    found = mistakes(EIGHT_MISTAKES)
    assert [(found[place].line, place, found[place].got, found[place].hint) for _, place, _, _, _ in EIGHT] == [
        (line, place, got, hint) for line, place, got, _, hint in EIGHT
    ]
    assert all(expected in found[place].expected for _, place, _, expected, _ in EIGHT)
    assert len(found) == 8


def test_the_message_has_a_line_for_each_mistake_in_the_order_of_the_file(load):
    with pytest.raises(sr.errors.ScenarioFileError) as caught:
        load(EIGHT_MISTAKES)
    error = caught.value
    lines = str(error).splitlines()
    assert lines[0].endswith("scenario.toml: 8 mistakes")
    assert "line 22, faults[0].joint: got 'j22', expected a joint of planar3: j1, j2, j3 (did you mean" in str(error)
    assert [mistake.line for mistake in error.mistakes] == sorted(mistake.line for mistake in error.mistakes)
    assert isinstance(error, sr.InputError)
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.mistakes, again.file) == (str(error), error.mistakes, error.file)


def test_an_empty_file_lacks_robot_start_and_motion(mistakes):
    assert mistakes("").keys() == {"robot", "start", "motion"}


def test_a_table_of_no_known_kind_does_not_hide_its_other_mistakes(mistakes):
    found = mistakes(
        planar(tables='[[faults]]\njoint = "j9"\nkind = "lokced"\nat = -1\n[[faults]]\nkind = "broken"\nat = "x"\n')
    )
    assert found.keys() == {
        "faults[0].joint",
        "faults[0].kind",
        "faults[0].at",
        "faults[1].joint",
        "faults[1].kind",
        "faults[1].at",
    }
    assert found["faults[0].kind"].hint == "did you mean 'locked'?"


def test_a_text_for_the_duration_of_a_motion_of_no_known_kind_is_not_added_up(mistakes):
    text = PLANAR.replace('"twist"', "true").replace("duration = 1", 'duration = "x"')
    assert "motion[0].kind" in mistakes(text)


def test_a_largest_rate_that_is_nothing_in_radians_is_refused(mistakes):
    tables = '[units]\nangle = "deg"\n[null_motion]\nkind = "manipulability"\nmax_rate = 5e-324\n'
    assert mistakes(planar(tables=tables)).keys() == {"null_motion.max_rate"}


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        (PLANAR.replace("n = 3", ""), "robot.n", "which planar needs"),
        (PLANAR.replace("n = 3", "lengths = [1]"), "robot.lengths", "only n beside planar"),
        (PLANAR.replace('"planar"', '"planer"'), "robot.arm", "did you mean 'planar'?"),
        (PLANAR.replace("n = 3", "n = true"), "robot.n", "an integer"),
        (PLANAR.replace("[robot]", "[robott]"), "robott", "did you mean 'robot'?"),
        (PLANAR.replace("arm =", "amr ="), "robot", "did you mean 'arm'?"),
        (PLANAR.replace("[0, 0.5, 1]", "{ j1 = 1, elbow = 2 }"), "start.elbow", "j1, j2, j3"),
        (PLANAR.replace("[0, 0.5, 1]", "[0, 0.5, true]"), "start[2]", "got true, expected a number"),
        (PLANAR.replace("[0, 0.5, 1]", "[0, 0.5, 1e12]"), "start[2]", "at most 1e+09"),
        (PLANAR.replace("[0, 0.5, 1]", '"home"'), "start", "a list"),
        (PLANAR.replace("duration = 1", ""), "duration", "the motion has no end of its own"),
        (PLANAR.replace("duration = 1", "duration = 0"), "motion[0].duration", "at least 1e-06"),
        (planar(top="duration = 0.5"), "duration", "at least the 1 s of the motion"),
        (planar(top="period = 2"), "period", "at most the whole duration, 1 s"),
        (planar(top="period = 1e-6\nduration = 1e6"), "duration", "ticks"),
        (planar(top='loop = "closd"'), "loop", "did you mean 'closed'?"),
        (planar(top="track_limits = [1, 2]"), "track_limits", 'loop = "closed"'),
        (planar(top="velocity_limits = -1"), "velocity_limits", "at least 0"),
        (planar(top="velocity_limits = { j7 = 1 }"), "velocity_limits.j7", "a joint of planar3"),
        (planar(top="position_limits = [[0, 1], [0, 1], [1, 0]]"), "position_limits[2]", "the lower one first"),
        (planar(top="position_limits = { j2 = [1] }"), "position_limits.j2", "2 entries"),
        (planar(tables='[[faults]]\njoint = "j1"'), "faults[0].kind", "'locked', 'derated', 'runaway'"),
        (planar(tables='[[faults]]\njoint = 1\nkind = "locked"'), "faults[0].joint", "a text"),
        (planar(tables='[[faults]]\njoint = "j1"\nkind = "one-way"\ndirection = 2'), "faults[0].direction", "1 or -1"),
        (
            planar(tables='[[faults]]\njoint = "j1"\nkind = "confined"\nlower = 1\nupper = 0'),
            "faults[0].lower",
            "lower <= upper",
        ),
        (planar(tables='[[faults]]\njoint = "j1"\nknid = "locked"'), "faults[0].knid", "did you mean 'kind'?"),
        (
            planar(tables='[[faults]]\njoint = "j1"\nkind = "derated"'),
            "faults[0].fraction",
            "missing key: what is left",
        ),
        (planar(tables='[[faults]]\njoint = "j1"\nkind = "locked"\nrate = 1'), "faults[0].rate", "unknown key"),
        (planar(tables='[[faults]]\njoint = "j1"\nkind = "locked"\nat = 1'), "faults[0].at", "before the end at 1 s"),
        (
            planar(tables='[[faults]]\njoint = "j1"\nkind = "locked"\nat = 0.5\nuntil = 0.4'),
            "faults[0].until",
            "after the onset at 0.5 s",
        ),
        (
            planar(tables='[[faults]]\njoint = "j1"\nkind = "locked"\nat = 0.501\nuntil = 0.509'),
            "faults[0].until",
            "after the first tick from 0.501 s on",
        ),
        (planar(tables='[law]\nkind = "least-error"\nprice = "no"'), "law.price", "'none'"),
        (planar(tables='[law]\nkind = "least-error"\nprice = [100, 8]'), "law.price", "prices by rows"),
        (planar(tables='[law]\nkind = "least-error"\nprice = {}'), "law.price", "1 to 3 parts"),
        (planar(tables='[law]\nkind = "least-error"\nprice = { wx = "8" }'), "law.price.wx", "no quotes"),
        (planar(tables='[law]\nkind = "least-error"\nprice = { tilt = 8 }'), "law.price", "names of rows (vx vy"),
        (planar(tables='[law]\nkind = "least-error"\nprice = { position = 8, vx = 1 }'), "law.price", "each row once"),
        (
            planar(tables='[law]\nkind = "least-error"\n[law.price]\nvx = 4\nvy = 3\nvz = 2\nwx = 1'),
            "law.price",
            "1 to 3 parts",
        ),
        (
            planar(tables='[law]\nkind = "least-error"\nprice = { position = 8 }'),
            "law.price",
            "no price for the row wx",
        ),
        (
            planar(
                tables='[law]\nkind = "least-error"\nprice = { position = 100, orientation = 8 }\n'
                f"[task.weights]\ntask = {COUPLED}"
            ),
            "task.weights.task",
            "no weight between rows that have different prices",
        ),
        (planar(tables='[law]\nkind = "keep-direction"\nrank_tolerance = 1'), "law.rank_tolerance", "below 1"),
        (planar(tables='[null_motion]\nkind = "posture"\nq = [1]'), "null_motion.q", "3, one for each joint"),
        (planar(tables='[task]\nrows = "position "'), "task.rows", "did you mean 'position'?"),
        (planar(tables="[task]\nrows = [false, false, false, false, false, false]"), "task.rows", "not all 0"),
        (planar(tables="[task]\nweights = { joints = [1, 2] }"), "task.weights.joints", "3, one for each joint"),
        (planar(tables="[task]\nweights = { task = [1, 2] }"), "task.weights.task", "6 entries"),
        (
            planar(tables="[task]\nweights = { joints = [[1, 2, 0], [2, 1, 0], [0, 0, 1]] }"),
            "task.weights.joints",
            "positive semidefinite",
        ),
        (planar(tables="[task]\nweights = { joints = [[1, 2], [2]] }"), "task.weights.joints", "a square matrix"),
        (planar(tables="[task]\ntool = { orientation = {} }"), "task.tool.orientation", "exactly one of rotation_vec"),
        (
            planar(tables="[task]\ntool = { orientation = { rpy = [0, 0, 0], quaternion = [1, 0, 0, 0] } }"),
            "task.tool.orientation",
            "exactly one of",
        ),
        (
            planar(tables="[task]\ntool = { orientation = { quaternion = [0, 0, 0, 0] } }"),
            "task.tool.orientation.quaternion",
            "not all 0",
        ),
        (planar(tables='[[motion]]\nkind = "line"\nduration = 1'), "motion[1].to", "a point to go to"),
        (
            planar(tables='[[motion]]\nkind = "line"\nto = [1, 2, 3]\nduration = 1\nramp = 0.2'),
            "motion[1].ramp",
            "trapezoidal",
        ),
        (
            planar(tables='[[motion]]\nkind = "circle"\ncentre = [0, 0, 0]\naxis = [0, 0, 0]\nduration = 1'),
            "motion[1].axis",
            "not all 0",
        ),
        (
            planar(
                tables='[[motion]]\nkind = "circle"\ncentre = [0, 0, 0]\naxis = [0, 0, 1]\nrelative = true\nduration=1'
            ),
            "motion[1].centre",
            "a circle with a radius",
        ),
        (planar(tables='[[motion]]\nkind = "waypoints"\npoints = [[1, 2, 3]]'), "motion[1].times", "neither"),
        (
            planar(tables='[[motion]]\nkind = "waypoints"\npoints = [[1, 2, 3]]\ntimes = [1, 2]'),
            "motion[1].times",
            "1 finite numbers",
        ),
        (
            planar(tables='[[motion]]\nkind = "waypoints"\npoints = [[1, 2, 3], [2, 2, 2]]\ntimes = [2, 1]'),
            "motion[1].times",
            "times that rise",
        ),
        (
            planar(tables='[[motion]]\nkind = "waypoints"\npoints = [[1, 2, 3]]\norientations = []\nduration = 1'),
            "motion[1].orientations",
            "1 orientations",
        ),
        (planar(tables='[[motion]]\nkind = "pose-table"\nfile = "no.csv"'), "motion[1].file", "no such file"),
        (planar(tables='[[motion]]\nkind = "pose-table"\nfile = "."'), "motion[1].file", "a folder"),
        (planar(tables='[[motion]]\nkind = "pose-table"\nfile = "scenario.toml"'), "motion[1].file", "scenario.toml"),
        (PLANAR.replace("duration = 1", "") + WAIT, "motion[0].duration", "only the last motion may have none"),
        (
            planar(tables='[[motion]]\nkind = "line"\nto = [1, 2, 0]\nduration = 0.001'),
            "motion[1].duration",
            "at least a period",
        ),
    ],
)
def test_one_mistake_has_one_line_with_its_place_and_what_was_expected(mistakes, text, place, words):
    found = mistakes(text)
    assert place in found
    assert words in str(found[place])


@pytest.mark.parametrize(
    ("robot", "place", "words"),
    [
        ('urdf = "no.urdf"', "robot.urdf", "No such file"),
        ('urdf = "arm.urdf"\ntip = "hand"', "robot.tip", "a link of the file"),
        ('urdf = "arm.urdf"\nfixed = { j9 = 0 }', "robot.fixed", "a joint between"),
        ('urdf = "broken.urdf"', "robot.urdf", "line 1"),
        ('urdf = "."', "robot.urdf", "a URDF file"),
        ('urdf = "arm.urdf"\nn = 3', "robot.n", "one of urdf, tip, base, fixed"),
        ('mjcf = "no.xml"', "robot.mjcf", "No such file"),
        ('modules = "RPX"\nlengths = [1, 1]', "robot", "RPX"),
        ('modules = "RP"\nlengths = [1]', "robot.lengths", "2"),
        ("dh = [{ a = 1 }, { b = 2 }]", "robot.dh[1].b", "one of a, alpha, d, theta, kind, name"),
        ('dh = [{ name = "x" }, { name = "x" }]', "robot", "'x'"),
    ],
)
def test_what_is_wrong_with_a_robot_is_said_at_its_key(mistakes, tmp_path, robot, place, words):
    (tmp_path / "arm.urdf").write_text(sr.Arm.from_modules("RP", [1, 1]).to_urdf())
    (tmp_path / "broken.urdf").write_text("<robot")
    found = mistakes(f"start = {{}}\n[robot]\n{robot}\n{WAIT}")
    near = [mistake for name, mistake in found.items() if name.startswith(place)]
    assert len(found) == len(near) == 1
    assert words in str(near[0])


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("a = 1\nb = \n", 2, "'b =' (column 5), expected valid TOML (Invalid value)"),
        ("a = 1\na = 2\n", 2, "Cannot overwrite a value"),
        ("[robot]\narm = 'x\n", 2, "valid TOML"),
        ('a = """\nnever closed\n', 2, "valid TOML"),
    ],
)
def test_a_syntax_error_has_its_line(load, text, line, words):
    with pytest.raises(sr.errors.ScenarioFileError) as caught:
        load(text)
    (mistake,) = caught.value.mistakes
    assert mistake.line == line
    assert words in str(mistake)


def test_lines_are_those_of_the_file_whatever_stands_between(mistakes):
    text = '''# a comment with [brackets] and "quotes"
name = """
[robot]
joint = 1
"""
start = [ # one
  0, "x",
  { a = 1 },   # two
]
"velocity_limits" = -1

[robot]
arm = "planar" # [law]
n = 3
[[motion]]
kind = 'twist'
twist = [0, 0, 0,
         0, 0, "'"]
[[motion]]
kind = "wait"
  [[faults]]
  joint = "j1"
  kind = "locked"
  [[faults]]
  at = -1
  "kind" = "locked"
'''
    found = mistakes(text)
    assert {place: mistake.line for place, mistake in found.items()} == {
        "start[1]": 7,
        "start[2]": 8,
        "velocity_limits": 10,
        "motion[0].twist[5]": 18,
        "motion[1].duration": 19,
        "faults[1].joint": 24,
        "faults[1].at": 25,
    }
