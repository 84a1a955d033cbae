"""Rehearsals: each case is the run with that fault, and says why it is not survived."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import stillreach as sr
from stillreach import InputError
from stillreach.errors import UnknownJointError
from stillreach.null_motions import Centring
from stillreach.plants import KinematicPlant
from stillreach.simulation.commanded import deviation
from stillreach.tolerance import Cause

PANDA = sr.arms.panda()
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
TWIST = sr.ConstantTwist([0.0, 0.06, -0.05, 0.1, 0.0, 0.0], duration=1.0)
LINE = sr.Line([0.05, 0.1, -0.1], duration=1.0, relative=True)
RECORDED = sr.Recording(
    PANDA,
    np.linspace(0.0, 2.0, 81),
    START + 0.25 * np.sin(np.outer(np.linspace(0.0, 2.0, 81), [0.5, 0.7, 0.3, 0.6, 0.4, 0.8, 0.2])),
)
ALL = ("locked", "derated", "confined", "one-way+", "one-way-", "runaway+", "runaway-")


def task(**settings):
    return sr.Scenario(arm=PANDA, start=START, **{"motion": [TWIST, LINE], "loop": "closed", **settings})


WAYS = {
    "closed loop": (task(), {}),
    "known after 40 ms": (task(), {"known_after": 0.04}),
    "never known": (task(), {"known_after": np.inf}),
    "open loop": (task(loop="open"), {"known_after": 0.02}),
    "a recording": (RECORDED.scenario(), {"known_after": 0.04}),
    "Runge-Kutta": (task(integrator="rk4"), {}),
    "late and noisy": (
        task(plant=KinematicPlant(lag=0.03, dead_time=0.02, resolution=1e-4, noise=1e-4)),
        {"known_after": 0.03},
    ),
    "with faults of its own": (
        task(faults=[sr.Fault(2, at=0.3, known_after=0.05), sr.Fault(6, at=0.5, kind=sr.Derated(0.5), until=1.4)]),
        {},
    ),
    "a null motion": (task(null_motion=Centring(gain=1.0)), {}),
    "acceleration limits": (task(acceleration_limits=8.0), {"known_after": 0.01}),
    "position alone": (task(task=sr.Task(rows="position")), {}),
    "along the tool": (task(task=sr.Task(rows=(True, False, True, False, True, False), frame="tool")), {}),
    "another law": (task(law=sr.KeepDirection()), {}),
    "a function": (task(motion=lambda t: [0.05 * np.cos(t), 0.04, 0.0, 0.0, 0.1 * np.sin(t), 0.0], duration=2.0), {}),
    "two at once": (task(), {"k": 2}),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_case_is_the_run_with_that_fault_to_the_last_bit(way):
    scenario, options = WAYS[way]
    found = sr.tolerance.rehearse(scenario, kinds=ALL, onsets=7, threads=2, **options)
    assert found.done.all()
    rng = np.random.default_rng(len(way))
    for flat in rng.choice(found.cause.size, 14, replace=False):
        place = kind, which, moment = np.unravel_index(flat, found.cause.shape)
        case = found.case(found.kinds[kind], found.failures.sets[which], found.onset[moment])
        run = sr.simulate(case)
        first = round(found.onset[moment] / scenario.period)
        distance, angle = (off[first:] for off in deviation(run))
        assert found.worst_distance[place] == distance.max()
        assert found.worst_angle[place] == angle.max()
        assert found.worst_time[place] == pytest.approx(run.time[first + distance.argmax()], abs=1e-12)
        assert (found.final_distance[place], found.final_angle[place]) == (distance[-1], angle[-1])
        known = min(scenario.tick_at(found.onset[moment] + found.failures.known_after), scenario.steps) - first
        assert (found.delay_distance[place], found.delay_angle[place]) == (distance[known], angle[known])
        near, turned = found.limits
        good = bool((distance <= near).all() and (angle <= turned).all())
        assert found.survives[place] == good
        assert found.survives_position[place] == bool((distance <= near).all())
        if not good:
            left = int(np.flatnonzero((distance > near) | (angle > turned))[0])
            assert found.failed_time[place] == pytest.approx(run.time[first + left], abs=1e-12)


def test_threads_change_nothing():
    one, two = (
        sr.tolerance.rehearse(task(), kinds=ALL, onsets=20, threads=count, known_after=0.04) for count in (1, 2)
    )
    for name in ("cause", "limited_by", "worst_distance", "worst_angle", "final_distance", "delay_angle"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


def test_the_healthy_run_is_that_of_simulate():
    found = sr.tolerance.rehearse(task(), onsets=3)
    distance, angle = deviation(sr.simulate(task()))
    np.testing.assert_array_equal(found.healthy_distance, distance)
    np.testing.assert_array_equal(found.healthy_angle, angle)


def shift(x, y, duration=1.0):
    return sr.ConstantTwist([x, y, 0.0, 0.0, 0.0, 0.0], duration=duration)


def test_two_links_cannot_lose_a_joint_on_a_line():
    """With two joints and two rows, no joint is spare: the direction is lost."""
    arm = sr.arms.planar(2)
    scenario = sr.Scenario(
        arm=arm,
        start=[0.3, 1.2],
        motion=shift(0.05, 0.08),
        task=sr.Task(rows=(True, True, False, False, False, False)),
        loop="closed",
    )
    found = sr.tolerance.rehearse(scenario, onsets=5)
    assert not found.survives.any()
    assert (found.cause == Cause.DIRECTION).all()
    assert found.share == 0.0
    assert found.when(0) == found.when(1) == "at any time"


def test_three_links_lose_one_and_go_on_but_not_two():
    arm = sr.arms.planar(3)
    scenario = sr.Scenario(
        arm=arm,
        start=[0.3, 0.8, 0.7],
        motion=shift(0.05, 0.08),
        task=sr.Task(rows=(True, True, False, False, False, False)),
        loop="closed",
    )
    assert sr.tolerance.rehearse(scenario, onsets=5).share == 1.0
    pairs = sr.tolerance.rehearse(scenario, onsets=5, k=2)
    assert pairs.joints == ("j1 + j2", "j1 + j3", "j2 + j3")
    assert not pairs.survives.any()


def test_a_slide_at_its_limit():
    """Two parallel slides, the second long enough for 0.3 m alone: without the first it stops at its limit."""
    limits = {"position_limits": (-0.3, 0.3), "velocity_limit": 1.0}
    slides = [sr.Joint(kind="prismatic", axis=[1, 0, 0], name=name, **limits) for name in ("a", "b")]
    arm = sr.Arm(slides)
    motion = sr.ConstantTwist([0.5, 0, 0, 0, 0, 0], duration=1.0)
    scenario = sr.Scenario(
        arm=arm,
        start=[0, 0],
        motion=motion,
        task=sr.Task(rows=(True, False, False, False, False, False)),
        loop="closed",
        allow_outside=True,
    )
    found = sr.tolerance.rehearse(scenario, onsets=[0.0], allowed_distance=0.01)
    assert (found.cause == Cause.POSITION).all()
    assert found.limited_by[0, :, 0].tolist() == [1, 0]
    np.testing.assert_allclose(found.final_distance, 0.2, atol=1e-3)
    fast = replace(scenario, velocity_limits=0.3)
    slow = sr.tolerance.rehearse(fast, onsets=[0.0], allowed_distance=0.01)
    assert (slow.cause == Cause.SPEED).all()
    assert sr.tolerance.rehearse(scenario, kinds="one-way-", onsets=[0.5]).share < 1.0


def test_a_failure_that_nobody_knows():
    found = sr.tolerance.rehearse(task(), onsets=[0.5], known_after=np.inf, allowed_distance=1e-3, allowed_angle=1e-3)
    lost = ~found.survives
    assert lost.any()
    assert (found.cause[lost] == Cause.DELAY).all()


def test_a_runaway_that_is_faster_than_what_is_left():
    """Two parallel slides: b can make up for a runaway a of 0.1 m/s only up to its own 0.05 m/s."""
    slides = [
        sr.Joint(kind="prismatic", axis=[1, 0, 0], name=name, position_limits=(-9, 9), velocity_limit=limit)
        for name, limit in (("a", 1.0), ("b", 0.05))
    ]
    scenario = sr.Scenario(
        arm=sr.Arm(slides),
        start=[0, 0],
        motion=sr.Wait(1.0),
        task=sr.Task(rows=(True, False, False, False, False, False)),
        loop="closed",
    )
    found = sr.tolerance.rehearse(scenario, kinds=["runaway+"], joints=["a"], onsets=[0.0])
    assert found.cause.item() == Cause.RUNAWAY
    assert found.limited_by.item() == 0
    assert found.final_distance.item() == pytest.approx(0.05, abs=2e-3)  # 0.1 - 0.05 m/s for a second


def test_a_healthy_arm_that_is_off_is_said():
    slow = task(velocity_limits=0.02)
    found = sr.tolerance.rehearse(slow, onsets=3)
    assert not found.healthy_survives
    assert "without a failure it is itself" in found.verdict


def test_the_verdict_and_the_table_say_when():
    found = sr.tolerance.rehearse(RECORDED.scenario(), kinds=["locked"], onsets=10)
    lost = {joint for which, joint in enumerate(found.joints) if not found.survives[:, which].all()}
    assert lost
    for which, joint in enumerate(found.joints):
        assert (found.when(which) == "never") == (joint not in lost)
    first, last = found.gaps(found.ranking[0])[0]
    assert not found.survives[0, found.ranking[0], first : last + 1].any()
    assert str(found).endswith(found.verdict)
    assert all(joint in found.verdict for joint in lost)


def test_when_is_in_words():
    found = sr.tolerance.rehearse(task(duration=None), kinds=["locked"], onsets=10)

    def said(*lost):
        found.cause[:] = Cause.SURVIVES
        found.cause[0, 0, list(lost)] = Cause.SPEED
        return found.when(0)

    assert said() == "never"
    assert said(*range(10)) == "at any time"
    assert said(0, 1) == "until 0.2 s"
    assert said(8, 9) == "from 1.6 s on"
    assert said(3) == "at 0.6 s"
    assert said(2, 3, 6, 7) == "between 0.4 and 0.6 s and between 1.2 and 1.4 s"
    assert said(0, 2, 4, 6) == "at 0 s, at 0.4 s, at 0.8 s and once more"


def test_labels_and_files(tmp_path):
    xarray = pytest.importorskip("xarray")
    found = sr.tolerance.rehearse(task(), kinds=["locked", sr.Derated(0.1)], onsets=4)
    found.save(tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc", engine="h5netcdf") as read:
        assert read["worst_distance"].dims == ("kind", "joint", "onset")
        assert list(read["joint"].values) == list(PANDA.joint_names)
        assert list(read["kind"].values) == ["locked", "Derated(fraction=0.1)"]
        np.testing.assert_array_equal(read["worst_distance"].values, found.worst_distance)
        np.testing.assert_array_equal(read["survives"].values.astype(bool), found.survives)
        assert read["worst_angle"].attrs["units"] == "rad"
        assert read.attrs["share"] == found.share


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"kinds": "broken"}, "kinds: got 'broken', expected words of locked"),
        ({"kinds": []}, "kinds: got none"),
        ({"kinds": 3}, "kinds: got 3"),
        ({"k": 0}, "k: got 0"),
        ({"k": 9}, "k: got 9, expected at most the 7 joints"),
        ({"onsets": 0}, "onsets: got 0"),
        ({"onsets": [-1.0]}, r"onsets: got \[-1.0\], expected moments from 0 to the end at 2 s"),
        ({"onsets": [[1.0]]}, "onsets: got .*expected moments"),
        ({"known_after": -1.0}, "known_after: got -1"),
        ({"allowed_distance": -1.0}, "allowed_distance: got -1"),
        ({"threads": 0}, "threads: got 0"),
        ({"joints": "panda_joint1"}, "joints: got .*expected a list"),
        (
            {"kinds": "runaway+", "velocity_limits": np.inf},
            "kinds: got runaway for panda_joint1, which has no velocity",
        ),
        ({"clock": "arm", "duration": 4.0}, 'task: got clock = "arm"'),
    ],
)
def test_mistakes(options, said):
    with pytest.raises(InputError, match=said):
        sr.tolerance.rehearse(task(), **{"onsets": 3, **options})


def test_other_mistakes():
    with pytest.raises(InputError, match=r"task: got .*expected a Scenario or a Recording"):
        sr.tolerance.rehearse("panda-elbow")
    with pytest.raises(TypeError, match="unexpected keyword argument 'laws'"):
        sr.tolerance.rehearse(task(), laws=3)
    with pytest.raises(UnknownJointError):
        sr.tolerance.rehearse(task(), joints=["j1"])
    found = sr.tolerance.rehearse(task(), onsets=3, joints=["panda_joint2", 3])
    assert found.joints == ("panda_joint2", "panda_joint4")
    with pytest.raises(InputError, match="kind: got 'lock', expected 'locked'"):
        found.case("lock", "panda_joint2", 0.0)
    with pytest.raises(InputError, match="joints: got 0, expected one of 'panda_joint2', 'panda_joint4'"):
        found.case("locked", 0, 0.0)


def test_ctrl_c_keeps_what_is_done(monkeypatch):
    module = sys.modules["stillreach.tolerance.rehearse"]
    real = module._case
    count = 0

    def interrupting(*arguments):
        nonlocal count
        count += 1
        return real(*arguments)

    class Stopped(module.Progress):
        def update(self, done):
            if count >= 5:
                raise KeyboardInterrupt

    monkeypatch.setattr(module, "_case", interrupting)
    monkeypatch.setattr(module, "Progress", Stopped)
    found = sr.tolerance.rehearse(task(), kinds=ALL, onsets=60, threads=1)
    assert found.interrupted
    assert 0 < found.done.sum() < found.done.size
    assert np.isnan(found.worst_distance[~found.done]).all()
    assert np.isfinite(found.worst_distance[found.done]).all()
    assert 0.0 <= found.share <= 1.0
    assert str(found)
