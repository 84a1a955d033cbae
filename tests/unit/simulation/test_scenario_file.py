"""A scenario file is a way to write a Scenario: what it says is what Python would have said."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import stillreach as sr
from stillreach.paper.examples import EXAMPLE_1_FAILED, EXAMPLE_2_CLOSED_FORM, EXAMPLE_2_STILLREACH, scenarios
from tests.unit.simulation.scenario_texts import PLANAR, planar

DEGREE = np.deg2rad(1.0)
ARRAYS = ("time", "q", "rates", "pose", "command", "residual", "task_error", "damping", "scale", "status", "health")


def same_run(scenario, reference):
    one, other = sr.simulate(scenario), sr.simulate(reference)
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in ARRAYS)


def test_the_papers_second_example_from_its_file_is_the_one_built_in_python_bit_for_bit():
    assert same_run(sr.Scenario.load("paper-example-2"), scenarios()[EXAMPLE_2_CLOSED_FORM])


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16-le", "utf-16-be"])
def test_a_file_as_powershell_writes_it_is_read(encoding, tmp_path):
    file = tmp_path / "reach.toml"
    text = PLANAR if encoding == "utf-8-sig" else f"\ufeff{PLANAR}"
    file.write_bytes(text.replace("\n", "\r\n").encode(encoding))
    plain = tmp_path / "plain.toml"
    plain.write_text(PLANAR, encoding="utf-8")
    assert same_run(sr.Scenario.load(file), sr.Scenario.load(plain))
    file.write_bytes(text.replace("start", "strat").replace("\n", "\r\n").encode(encoding))
    with pytest.raises(sr.errors.ScenarioFileError) as caught:
        sr.Scenario.load(file)
    wrong = next(k for k, line in enumerate(PLANAR.split("\n"), 1) if "start" in line)
    assert wrong in [mistake.line for mistake in caught.value.mistakes]


def test_the_papers_first_example_from_its_file_is_the_one_built_in_python():
    """Its twist is 1.5 in/s there and 30 in in 20 s here, which differ by a rounding."""
    one, other = sr.simulate(sr.Scenario.load("paper-example-1")), sr.simulate(scenarios()[EXAMPLE_1_FAILED])
    np.testing.assert_allclose(one.q, other.q, atol=1e-12)


def test_the_closed_loop_from_its_file_goes_where_the_one_built_in_python_goes():
    one = sr.simulate(sr.Scenario.load("paper-example-2-feedback"))
    other = sr.simulate(scenarios()[EXAMPLE_2_STILLREACH])
    np.testing.assert_allclose(one.pose[-1], other.pose[-1], atol=1e-3)


def test_the_least_that_a_file_can_say(load):
    scenario = load(PLANAR)
    assert same_run(
        scenario,
        sr.Scenario(arm=sr.arms.planar(3), start=[0, 0.5, 1], motion=sr.ConstantTwist([0.1, 0, 0, 0, 0, 0], 1.0)),
    )
    assert (scenario.period, scenario.duration, scenario.loop, scenario.name) == (0.01, 1.0, "open", "")


def test_every_setting_arrives(load):
    scenario = load(
        planar(
            top="""
name = "all of them"
description = "what it shows"
period = 0.02
duration = 3
integrator = "rk4"
loop = "closed"
track_gain = 3.5
track_limits = [10, inf]
velocity_limits = { j2 = 90 }
position_limits = [[-90, 90], [-inf, inf], [0, 180]]
acceleration_limits = 360
return_rate = 45
transition_rate = 1.5
""",
            tables="""
[units]
length = "in"
angle = "deg"
[law]
kind = "singularity-robust"
damping = 0.5
norm = "2"
rank_tolerance = 1e-8
[null_motion]
kind = "posture"
q = { j3 = 90 }
gain = 0.5
max_rate = 20
[task]
rows = [true, true, false, false, false, false]
frame = "tool"
tool = { position = [1, 0, 0], orientation = { rpy = [0, 0, 90] } }
weights = { length = 2, angle = 3, task = [1, 2, 3, 4, 5, 6], joints = [1, 2, 3] }
""",
        )
    )
    assert (scenario.name, scenario.period, scenario.duration) == ("all of them", 0.02, 3.0)
    assert (scenario.integrator, scenario.loop, scenario.track_gain) == ("rk4", "closed", 3.5)
    assert scenario.track_limits == (10 * 0.0254, np.inf)
    np.testing.assert_array_equal(scenario.velocity_limits[:, 1], [1.0, 90 * DEGREE, 1.0])
    np.testing.assert_allclose(
        scenario.position_limits, [[-np.pi / 2, np.pi / 2], [-np.inf, np.inf], [0, np.pi]], rtol=1e-15
    )
    np.testing.assert_allclose(scenario.acceleration_limits, [2 * np.pi] * 3, rtol=1e-15)
    assert (scenario.return_rate, scenario.transition_rate) == (45 * DEGREE, 1.5)
    assert scenario.law == sr.SingularityRobust(damping=0.5, norm="2", rank_tolerance=1e-8)
    assert isinstance(scenario.null_motion, sr.null_motions.Posture)
    np.testing.assert_allclose(scenario.null_motion.q, [0, 0, np.pi / 2], rtol=1e-15)
    assert (scenario.null_motion.gain, scenario.null_motion.max_rate) == (0.5, 20 * DEGREE)
    task = scenario.task
    assert (task.indices, task.frame) == ((0, 1), "tool")
    np.testing.assert_allclose(task.tool, [[0, -1, 0, 0.0254], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], atol=1e-15)
    assert (task.weights.length, task.weights.angle) == (2 * 0.0254, 3 * DEGREE)
    np.testing.assert_array_equal(task.weights.task, [1, 2, 3, 4, 5, 6])
    np.testing.assert_array_equal(task.weights.joints, [1, 2, 3])
    np.testing.assert_allclose(scenario.start, np.deg2rad([0, 0.5, 1]), rtol=1e-15)


@pytest.mark.parametrize(
    ("table", "law"),
    [
        ('kind = "least-error"\nprice = 3', sr.LeastError(price=3)),
        ('kind = "least-error"\nprice = "none"', sr.LeastError(price=None)),
        ('kind = "least-error"\nprice = "position-first"', sr.LeastError(price="position-first")),
        ('kind = "least-error"\nprice = { position = 100, orientation = 8 }', sr.LeastError(price=(100, 8))),
        (
            'kind = "least-error"\nprice = { position = 100, "wx wy" = 8, wz = 1 }',
            sr.LeastError(price={"position": 100, "wx wy": 8, "wz": 1}),
        ),
        ('kind = "singularity-robust"\ndamping = "closed-form"', sr.SingularityRobust(damping="closed-form")),
        ('kind = "pseudoinverse"\nrank_tolerance = 0.01', sr.Pseudoinverse(rank_tolerance=0.01)),
    ],
)
def test_settings_of_a_law_arrive(load, table, law):
    assert load(planar(tables=f"[law]\n{table}")).law == law


def test_a_price_is_not_converted_from_the_units_of_the_file(load):
    tables = '[units]\nlength = "in"\nangle = "deg"\n[law]\nkind = "least-error"\nprice = 3\n'
    assert load(planar(tables=tables)).law == sr.LeastError(price=3)


def test_faults_have_their_joint_onset_end_and_kind(load):
    faults = load(
        planar(
            tables="""
[units]
angle = "deg"
[[faults]]
joint = "j1"
kind = "locked"
[[faults]]
joint = "j3"
at = 0.25
until = 0.5
kind = "derated"
fraction = 0.1
[[faults]]
joint = "j3"
at = 0.75
kind = "runaway"
rate = -90
[[faults]]
joint = "j2"
kind = "confined"
lower = -inf
upper = 45
[[faults]]
joint = "j2"
kind = "one-way"
direction = -1
"""
        )
    ).faults
    assert faults == (
        sr.Fault("j1"),
        sr.Fault("j3", at=0.25, until=0.5, kind=sr.Derated(0.1)),
        sr.Fault("j3", at=0.75, kind=sr.Runaway(-90 * DEGREE)),
        sr.Fault("j2", kind=sr.Confined(-np.inf, 45 * DEGREE)),
        sr.Fault("j2", kind=sr.OneWay(-1)),
    )


def test_motions_of_every_kind_arrive_in_metres_and_radians(load, tmp_path):
    (tmp_path / "poses.csv").write_text("time,x,y,z,rx,ry,rz\n1,1,2,3,0,0,90\n2,4,5,6,0,0,0\n")
    twist, wait, line, circle, waypoints, table = load(
        "start = [0, 0, 0, 0, 0, 0]\n"
        '[robot]\nmodules = "RPRPRP"\nlengths = [30, 30, 30, 30]\n'
        """
[units]
length = "cm"
angle = "deg"
[[motion]]
kind = "twist"
twist = [1, 2, 3, 90, 0, 0]
duration = 1
[[motion]]
kind = "wait"
duration = 2
[[motion]]
kind = "line"
to = [10, 20, 30]
orientation = { pitch_yaw_roll = [10, 20, 30] }
duration = 3
profile = "trapezoidal"
ramp = 0.1
[[motion]]
kind = "circle"
centre = [5, 0, 0]
axis = [0, 0, 2]
angle = 180
duration = 4
attitude = "follow"
profile = "minimum-jerk"
relative = true
[[motion]]
kind = "waypoints"
points = [[1, 0, 0], [0, 1, 0]]
orientations = ["keep", { quaternion = [0, 0, 0, -3] }]
times = [1, 5]
[[motion]]
kind = "pose-table"
file = "poses.csv"
"""
    ).motion
    assert twist == sr.ConstantTwist([0.01, 0.02, 0.03, np.pi / 2, 0, 0], 1.0)
    assert wait == sr.ConstantTwist([0] * 6, 2.0)
    np.testing.assert_allclose(line.to, [0.1, 0.2, 0.3], rtol=1e-15)
    np.testing.assert_allclose(
        line.orientation, Rotation.from_euler("YZX", [10, 20, 30], degrees=True).as_matrix(), atol=1e-15
    )
    assert (line.profile, line.ramp, line.relative, line.duration) == ("trapezoidal", 0.1, False, 3.0)
    np.testing.assert_allclose(circle.centre, [0.05, 0, 0], rtol=1e-15)
    np.testing.assert_array_equal(circle.axis, [0, 0, 1])
    assert circle.angle == pytest.approx(np.pi, rel=1e-15)
    assert (circle.attitude, circle.profile, circle.relative) == ("follow", "minimum-jerk", True)
    np.testing.assert_allclose(waypoints.points, [[0.01, 0, 0], [0, 0.01, 0]], rtol=1e-15)
    assert waypoints.orientations[0] is None
    np.testing.assert_allclose(waypoints.orientations[1], np.diag([-1, -1, 1]), atol=1e-15)
    assert waypoints.duration == 5.0
    np.testing.assert_allclose(table.points, [[0.01, 0.02, 0.03], [0.04, 0.05, 0.06]], rtol=1e-15)
    np.testing.assert_allclose(table.orientations[0], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)


def test_a_path_works_as_text_and_as_path_and_wins_over_a_ready_name(tmp_path, monkeypatch):
    file = tmp_path / "paper-example-2"
    file.write_text(PLANAR)
    assert sr.Scenario.load("paper-example-2").arm.n == 11
    assert sr.Scenario.load(file).arm.n == sr.Scenario.load(str(file)).arm.n == 3
    monkeypatch.chdir(tmp_path)
    assert sr.Scenario.load("paper-example-2").arm.n == 3


def test_a_folder_does_not_hide_the_ready_scenario_of_its_name(tmp_path, monkeypatch):
    (tmp_path / "jammed-rail").mkdir()
    monkeypatch.chdir(tmp_path)
    assert sr.Scenario.load("jammed-rail").name == "A robot on a rail that jams"
    with pytest.raises(sr.errors.ScenarioFileError, match="got a folder"):
        sr.Scenario.load(tmp_path / "jammed-rail")
