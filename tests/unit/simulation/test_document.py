"""A run that was saved is as good as a fresh one: the same scenario, summary, picture and, again, the same run."""

import json
from dataclasses import dataclass, replace
from io import BytesIO

import numpy as np
import pandas as pd
import pytest
from matplotlib import pyplot

import stillreach as sr
from stillreach.null_motions import Centring, Gradient, Manipulability, Posture, Rates
from stillreach.simulation.document import scenario_data, scenario_of, scenario_text
from tests.robots.catalogue import ROBOTS
from tests.unit.simulation.scenarios import eight_joints, eight_joints_start, first_ticks, small_run, waving

RNG = np.random.default_rng(8)
ROOT = RNG.normal(size=(8, 8))
WEIGHTS = sr.Weights(length=0.3, angle=2.0, task=[1, 2, 3, 1, 1, 0.5], joints=np.eye(8) + 0.1 * ROOT @ ROOT.T)
TOOL = np.eye(4)
TOOL[:3, :3] = [[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]]
TOOL[:3, 3] = 0.1, -1 / 3, 1e-300
HALF = sr.ConstantTwist([0.1, 0, 0.05, 0, 0.1, 0], duration=0.5)
TURN = [0.1, -0.2, 1 / 3]

SETTINGS = {
    "the default": {},
    "keep direction": {"law": sr.KeepDirection(rank_tolerance=1e-8)},
    "bare optimum": {"law": sr.LeastError(price=None)},
    "prices": {"law": sr.LeastError(price={"position": 100, "wx wy": 8, "wz": 1 / 3})},
    "position first": {"law": sr.LeastError(price="position-first")},
    "2-norm": {"law": sr.SingularityRobust(damping="closed-form", norm="2")},
    "inf-norm": {"law": sr.SingularityRobust(damping=0.1, norm="inf")},
    "weights of the law": {"law": sr.Pseudoinverse(weights=WEIGHTS)},
    "weights of the task": {"task": sr.Task(weights=WEIGHTS)},
    "weights of both": {"law": sr.LeastError(weights=WEIGHTS), "task": sr.Task(weights=WEIGHTS)},
    "rows": {"task": sr.Task(rows=np.array([True, False, True, False, False, True]), frame="tool", tool=TOOL)},
    "posture by name": {"null_motion": Posture(q={f"j{k}": k / 7 for k in range(8, 0, -1)}, max_rate=0.2)},
    "posture as a series": {"null_motion": Posture(q=pd.Series({f"j{k}": k / 7 for k in range(8, 0, -1)}))},
    "centring": {"null_motion": Centring(gain=0.3), "position_limits": (-2.0, 3.0)},
    "manipulability": {"null_motion": Manipulability(gain=0.5)},
    "rates": {"null_motion": Rates(rates=np.linspace(-0.1, 0.1, 8))},
    "bare rates": {"null_motion": np.full(8, 0.05)},
    "gradient": {"null_motion": Gradient(gradient=[0.1] * 8, gain=2.0)},
    "limits": {"velocity_limits": np.inf, "acceleration_limits": {f"j{k}": float(k) for k in range(8, 0, -1)}},
    "closed loop": {"loop": "closed", "track_gain": 1.0, "track_limits": (0.2, np.inf), "return_rate": 0.1},
    "open end": {"motion": sr.ConstantTwist([0.1, 0, 0, 0, 0, 0]), "transition_rate": 0.0},
    "course": {"motion": [HALF, sr.Line([0.1, 0, 0], orientation=TURN, duration=0.7, relative=True)]},
    "circle": {"motion": sr.Circle(centre=[0, 0.3, 0], axis=[1, 2, 3], attitude="follow", duration=1, relative=True)},
    "waypoints": {
        "motion": sr.Waypoints(
            [[0.1, 0, 0], [0, 0.1, 0]],
            orientations=[None, TURN],
            times=[0.4, 1.0],
            profile="minimum-jerk",
            relative=True,
        )
    },
    "shared waypoints": {"motion": sr.Waypoints([[0.1, 0, 0], [0, 0.1, 0]], duration=1.0, ramp=0.3, relative=True)},
    "pose table": {"motion": sr.PoseTable([0.5, 1.0], [[0.1, 0, 0], [0, 0.1, 0]], orientations=[TOOL[:3, :3]] * 2)},
    "function": {"motion": [HALF, waving]},
    "runge-kutta": {"motion": waving, "integrator": "rk4"},
    "arm's clock": {"clock": "arm", "law": sr.KeepDirection(), "motion": [HALF, HALF]},
    "names": {"name": 'a "name" of ° and \n', "description": "{}\\"},
}


def scenario(**settings):
    """Two seconds of an arm of both kinds of joints; not every motion can be done."""
    faults = [sr.Fault("j2", at=0.4), sr.Fault(3, at=0.2, until=0.8, kind=sr.Derated(1 / 3)), sr.Fault("j7", at=0.6)]
    faults += [sr.Fault("j5", at=1.0, kind=sr.Confined(-0.5, np.inf)), sr.Fault("j1", at=0.5, kind=sr.OneWay(-1))]
    given = {"arm": eight_joints().with_limits(velocity=0.5), "start": eight_joints_start(), "motion": HALF}
    given |= {"faults": faults, "duration": 2.0, "period": 0.02, "allow_outside": True}
    return sr.Scenario(**{**given, **settings})


def pixels(figure):
    file = BytesIO()
    figure.savefig(file, format="raw", dpi=40)
    pyplot.close(figure)
    return file.getvalue()


def in_numbers(summary):
    """All that a summary holds, bit for bit."""
    return repr({key: value for key, value in vars(summary).items() if key != "run"})


@pytest.fixture(params=["run.nc", "run.npz"])
def again(request, tmp_path):
    """Saves a run and loads it."""

    def saved(run):
        run.save(tmp_path / request.param)
        return sr.Run.load(tmp_path / request.param)

    return saved


@pytest.mark.parametrize("name", SETTINGS)
def test_a_run_that_was_saved_is_as_good_as_a_fresh_one(name, again):
    run = sr.simulate(scenario(**SETTINGS[name]))
    loaded = again(run)
    assert scenario_text(loaded.scenario) == scenario_text(run.scenario)
    assert repr(loaded) == repr(run)
    fresh = run.summary()
    assert in_numbers(loaded.summary()) == in_numbers(fresh)
    assert str(loaded.summary()) == str(fresh)
    if name in ("the default", "function", "rows", "arm's clock", "names"):
        assert pixels(loaded.plot()) == pixels(run.plot())
    if not run.scenario.schedule.has_function:
        repeated = sr.simulate(loaded.scenario)
        assert all(np.array_equal(array, repeated.arrays()[key]) for key, array in run.arrays().items())


def test_a_document_holds_every_setting_of_a_scenario():
    data = scenario_data(scenario(**SETTINGS["closed loop"]))
    names = set(sr.Scenario.__dataclass_fields__) - {"_"}
    assert names == set(data) - {"format"}
    assert data["track_limits"] == [0.2, {"float": "inf"}]
    assert data["faults"][1] == {
        "joint": 3,
        "at": 0.2,
        "kind": {"kind": "derated", "fraction": 1 / 3},
        "until": 0.8,
        "known_after": 0.0,
    }
    assert "Infinity" not in scenario_text(scenario())


@pytest.mark.parametrize("name", ROBOTS)
def test_arms_of_robot_files_are_rebuilt_exactly(name):
    """Followers, limits and placements with all their digits; and so are built-in arms, below."""
    arm = ROBOTS[name].make()
    start = np.clip(0.1, *arm.position_limits.T)
    of = sr.Scenario(arm=arm, start=start, motion=sr.ConstantTwist(np.zeros(6)), duration=1.0, task=sr.Task())
    rebuilt = scenario_of(scenario_text(of)).arm
    assert rebuilt == arm
    assert np.array_equal(rebuilt.forward(start), arm.forward(start))


@pytest.mark.parametrize("name", sr.scenario_names())
def test_ready_scenarios_are_rebuilt_exactly(name):
    of = sr.Scenario.load(name)
    text = scenario_text(of)
    assert scenario_text(scenario_of(text)) == text


def test_a_function_is_stored_by_its_name_and_cannot_run_again(again):
    for settings, name in (
        ({"motion": waving}, "waving"),
        ({"null_motion": Gradient(gradient=lambda q: -q)}, "<lambda>"),
    ):
        loaded = again(sr.simulate(scenario(**settings)))
        assert name in json.dumps(scenario_data(loaded.scenario))
        with pytest.raises(sr.InputError, match=f"its name '.*{name}' and not its code"):
            sr.simulate(loaded.scenario)
        assert again(loaded).summary().finished == loaded.summary().finished
        whole = sr.simulate(replace(loaded.scenario, **settings))
        assert np.array_equal(whole.q, loaded.q)


def test_a_function_is_known_as_far_as_the_run_went(again):
    part = first_ticks(small_run(), 12)
    loaded = again(part)
    assert loaded.interrupted
    assert in_numbers(loaded.summary()) == in_numbers(part.summary())
    steps = np.diff(part.target[:, :3, 3], axis=0)
    assert loaded.summary().way == pytest.approx(np.sum(np.linalg.norm(steps, axis=1)))


def test_where_a_function_would_lead_by_the_arms_clock_is_not_known(again):
    run = sr.simulate(scenario(motion=waving, clock="arm", law=sr.KeepDirection()))
    assert not run.summary().finished
    with pytest.raises(sr.InputError, match="its name 'waving' and not its code"):
        again(run).summary()


@dataclass(frozen=True, kw_only=True)
class OwnLaw(sr.LeastError):
    """A law of a user."""


def test_a_law_of_ones_own_is_refused_before_a_file_is_made(tmp_path):
    run = sr.simulate(scenario(law=OwnLaw()))
    for name in ("run.nc", "run.npz"):
        with pytest.raises(sr.InputError, match=r"OwnLaw.*expected one of least-error, keep-direction"):
            run.save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []
    replace(run, scenario=replace(run.scenario, law=sr.LeastError())).save(tmp_path / "run.nc")
