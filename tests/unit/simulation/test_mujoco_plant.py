"""An arm with inertia in MuJoCo: each fault of it does what physics says, and the controller goes on."""

from dataclasses import replace
from importlib.metadata import distribution

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stillreach as sr
from stillreach import InputError
from stillreach.plants import KinematicPlant, MujocoPlant
from stillreach.status import Health
from tests.robots.catalogue import MJCF

pytest.importorskip("mujoco", reason="pip install 'stillreach[mujoco]'")

PANDA = sr.arms.panda()
START = np.deg2rad([20.0, -45.0, 20.0, -125.0, 20.0, 95.0, 45.0])
RATES = np.array([0.2, -0.1, 0.15, 0.1, -0.2, 0.1, 0.3])
J4 = 3


def driven(plant, rates=RATES, *, seconds=0.6, faults=(), arm=PANDA, start=START, period=0.01):
    """A plant that is commanded constant rates for a time; its faults: {tick: (joint, kind)}. Positions by tick."""
    moving, found = plant.begin(arm, np.array(start), period), []
    for tick in range(round(seconds / period) + 1):
        found.append(moving.q)
        for at, joint, kind in faults:
            if at == tick:
                moving.fail(joint, kind)
        moving.advance(np.array(rates))
    return np.array(found)


def speeds(q, period=0.01):
    return np.diff(q, axis=0) / period


def test_without_a_fault_it_follows_the_rates():
    q = driven(MujocoPlant())
    np.testing.assert_allclose(speeds(q)[-20:], np.tile(RATES, (20, 1)), atol=2e-3)


def test_a_locked_joint_stands_and_the_others_move():
    q = driven(MujocoPlant(), faults=[(20, J4, sr.Locked())])
    assert np.ptp(q[22:, J4]) < 1e-3
    np.testing.assert_allclose(speeds(q)[-10:, 0], RATES[0], atol=5e-3)
    released = driven(MujocoPlant(), faults=[(20, J4, sr.Locked()), (40, J4, None)])
    np.testing.assert_allclose(speeds(released)[-10:, J4], RATES[J4], atol=5e-3)


def test_a_runaway_joint_has_its_own_rate():
    q = driven(MujocoPlant(), faults=[(20, J4, sr.Runaway(-0.25))])
    np.testing.assert_allclose(speeds(q)[-20:, J4], -0.25, atol=5e-3)


def test_a_derated_joint_is_slower():
    limit = PANDA.velocity_limits[J4]
    fast = RATES.copy()
    fast[J4] = 0.5 * limit
    q = driven(MujocoPlant(), fast, faults=[(10, J4, sr.Derated(0.1))], seconds=0.4)
    np.testing.assert_allclose(speeds(q)[-10:, J4], 0.1 * limit, atol=5e-3)


def test_a_one_way_joint_does_not_go_back():
    q = driven(MujocoPlant(), faults=[(20, J4, sr.OneWay(-1))])
    np.testing.assert_allclose(speeds(q)[-20:, J4], 0.0, atol=5e-3)
    np.testing.assert_allclose(speeds(driven(MujocoPlant(), faults=[(20, J4, sr.OneWay(1))]))[-20:, J4], 0.1, atol=5e-3)


def test_a_confined_joint_stops_at_its_end():
    end = START[J4] + 0.02
    q = driven(MujocoPlant(), seconds=1.0, faults=[(0, J4, sr.Confined(START[J4] - 1.0, end))])
    assert q[:, J4].max() < end + 5e-3
    assert q[-1, J4] == pytest.approx(end, abs=5e-3)


def test_a_free_swinging_joint_is_a_pendulum(tmp_path):
    mass, inertia, length, damping, armature = 2.0, 0.03, 0.4, 0.3, 0.05
    (tmp_path / "pendulum.xml").write_text(
        '<mujoco><worldbody><body><joint name="j1" axis="0 1 0"/><inertial pos="0 0 -0.4" mass="2" '
        'diaginertia="0.03 0.03 0.03"/></body></worldbody></mujoco>'
    )
    arm = sr.Arm([sr.Joint(name="j1", axis=(0, 1, 0))], tool=np.eye(4))
    settings = {"gravity": True, "damping": damping, "armature": armature, "step": 0.0005}
    plant = MujocoPlant(model=str(tmp_path / "pendulum.xml"), **settings)
    q = driven(plant, [0.0], seconds=2.0, arm=arm, start=[1.0], faults=[(0, 0, sr.FreeSwinging())])[:, 0]
    whole = inertia + mass * length**2 + armature

    def fall(_, state):
        angle, rate = state
        return rate, -(mass * 9.81 * length * np.sin(angle) + damping * rate) / whole

    there = solve_ivp(fall, (0.0, 2.0), (1.0, 0.0), rtol=1e-9, atol=1e-9, t_eval=0.01 * np.arange(201)).y[0]
    np.testing.assert_allclose(q, there, atol=5e-3)
    caught = driven(plant, [0.0], arm=arm, start=[1.0], faults=[(0, 0, sr.FreeSwinging()), (20, 0, None)])[:, 0]
    assert abs(np.diff(caught[-10:])).max() < 0.1 * abs(np.diff(caught[:20])).max()  # its servo works again


def test_the_controller_goes_on_with_a_joint_that_swings():
    J3 = 2
    faults = [sr.Fault(J3, at=0.5, kind=sr.FreeSwinging(), known_after=0.02)]
    motion = sr.Line([0.0, 0.1, 0.0], duration=3.0, relative=True)
    scenario = sr.Scenario(arm=PANDA, start=START, motion=motion, faults=faults, plant=MujocoPlant(), loop="closed")
    run = sr.simulate(scenario)
    assert np.all(run.rates[-100:, J3] == 0.0)
    assert set(run.health[-100:, J3]) == {Health.FREE_SWINGING}
    assert np.ptp(run.q[60:, J3]) > 1e-3  # the others' motion swings it
    assert np.linalg.norm(run.pose[-1, :3, 3] - run.target[-1, :3, 3]) < 2e-3


def test_a_weak_servo_accelerates_as_its_force_and_the_inertia_say(tmp_path):
    (tmp_path / "wheel.xml").write_text(
        '<mujoco><worldbody><body><inertial pos="0 0 0" mass="1" diaginertia="0.05 0.05 0.05"/><joint name="j1"/>'
        "</body></worldbody></mujoco>"
    )
    arm = sr.Arm([sr.Joint(name="j1", velocity_limit=9.0)])
    plant = MujocoPlant(model=str(tmp_path / "wheel.xml"), force=0.6, damping=0.0, armature=0.15)
    q = driven(plant, [5.0], seconds=0.5, arm=arm, start=[0.0])
    np.testing.assert_allclose(np.diff(q[:, 0], 2) / 0.01**2, 0.6 / (0.05 + 0.15), rtol=1e-6)  # [rad/s²]


def test_gravity_pulls_and_friction_holds():
    standing = np.zeros(7)
    sagged = np.abs(driven(MujocoPlant(gravity=True, gain=20.0), standing)[-1] - START)
    assert sagged[1] > 0.01  # the shoulder
    assert np.abs(driven(MujocoPlant(gain=20.0), standing)[-1] - START).max() < 1e-6
    little = 0.02 * RATES
    stuck = driven(MujocoPlant(friction=50.0), little)
    free = driven(MujocoPlant(), little)
    assert np.abs(stuck[-1] - START).max() < 0.5 * np.abs(free[-1] - START).max()


def test_a_delay_is_whole_ticks():
    late, early = driven(MujocoPlant(delay=0.03)), driven(MujocoPlant())
    np.testing.assert_array_equal(late[:4], np.tile(START, (4, 1)))
    np.testing.assert_allclose(late[3:], early[:-3], atol=1e-12)


def test_encoders_are_off():
    exact = MujocoPlant().begin(PANDA, START, 0.01)
    np.testing.assert_array_equal(exact.measure(), exact.q)
    off = MujocoPlant(offset=0.01, resolution=0.005).begin(PANDA, START, 0.01).measure()
    np.testing.assert_allclose(off / 0.005, np.round(off / 0.005), atol=1e-9)
    np.testing.assert_allclose(off, START + 0.01, atol=0.0025 + 1e-12)
    noisy = MujocoPlant(noise=1e-3, seed=4).begin(PANDA, START, 0.01)
    samples = np.array([noisy.measure() for _ in range(500)]) - START
    assert samples.std() == pytest.approx(1e-3, rel=0.05)
    again = MujocoPlant(noise=1e-3, seed=4).begin(PANDA, START, 0.01)
    np.testing.assert_array_equal(again.measure() - START, samples[0])


def test_the_papers_second_example_with_inertia():
    """Joints 2, 4 and 7 lock at 2 s, the controller learns of it 40 ms later: the tool makes its 100 in."""
    scenario = sr.Scenario.load("paper-example-2-feedback")
    faults = tuple(replace(fault, at=2.0, known_after=0.04) for fault in scenario.faults)
    spare = sr.null_motions.Tolerance(gain=0.2, max_rate=10.0)
    scenario = replace(scenario, faults=faults, plant=MujocoPlant(), null_motion=spare)
    run = sr.simulate(scenario)
    assert run.summary().finished
    inch = 0.0254
    way = run.pose[-1, 0, 3] - run.pose[0, 0, 3]
    assert way == pytest.approx(-100.0 * inch, abs=0.1 * inch)
    for joint in (1, 3, 6):
        assert np.ptp(run.q[201:, joint]) < 1e-3
    off = np.linalg.norm(run.pose[:, :3, 3] - run.target[:, :3, 3], axis=1)
    assert off[204:].max() <= 1.0 * inch
    assert {late.joint for late in run.summary().unnoticed} == {"j2", "j4", "j7"}
    assert (run.health[200:, [1, 3, 6]] == Health.LOCKED).all()
    assert not run.known[:204].any()


def test_a_panda_of_a_file_loses_a_wrist_joint_on_a_circle():
    robot = MJCF["robosuite Panda"]
    try:
        distribution(robot.package[0])
    except ImportError:
        pytest.skip("pip install --no-deps robosuite")
    arm = robot.make()
    circle = sr.Circle(centre=[0.0, 0.08, 0.0], axis=[1, 0, 0], duration=4.0, relative=True, profile="minimum-jerk")
    scenario = sr.Scenario(
        arm=arm,
        start=START,
        motion=circle,
        loop="closed",
        track_gain=5.0,
        faults=[sr.Fault(arm.joint_names[4], at=1.5, known_after=0.04)],
        plant=MujocoPlant(model=str(robot.file)),
        task=sr.Task(rows="position"),
    )
    run = sr.simulate(scenario)
    assert run.summary().finished
    assert np.ptp(run.q[152:, 4]) < 1e-3
    assert np.ptp(run.q[:150, 4]) > 1e-3
    assert np.linalg.norm(run.pose[:, :3, 3] - run.target[:, :3, 3], axis=1).max() < 5e-3


def test_a_scenario_file_and_a_record_hold_it(tmp_path):
    text = """start = [0.1, 0.5, 1.0]
robot = { arm = "planar", n = 3 }
motion = [{ kind = "wait", duration = 0.2 }]
plant = { kind = "mujoco", gain = 200, delay = 0.02, gravity = true }
"""
    (tmp_path / "a.toml").write_text(text)
    scenario = sr.Scenario.load(tmp_path / "a.toml")
    assert scenario.plant == MujocoPlant(gain=200.0, delay=0.02, gravity=True)
    run = sr.simulate(scenario)
    run.save(tmp_path / "a.npz")
    again = sr.Run.load(tmp_path / "a.npz")
    assert again.scenario.plant == scenario.plant
    np.testing.assert_array_equal(sr.simulate(again.scenario).q, run.q)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"model": "no.xml"}, "model: got 'no.xml', expected an MJCF or URDF file that exists"),
        ({"gain": 0.0}, "gain: got 0"),
        ({"force": -1.0}, "force: got -1"),
        ({"gravity": 1}, "gravity: got 1"),
        ({"seed": -1}, "seed: got -1"),
    ],
)
def test_mistakes(settings, said):
    with pytest.raises(InputError, match=said):
        MujocoPlant(**settings).begin(PANDA, START, 0.01)


def test_a_model_of_another_robot(tmp_path):
    (tmp_path / "other.xml").write_text(
        '<mujoco><worldbody><body><joint name="a"/><geom size="1"/></body></worldbody></mujoco>'
    )
    with pytest.raises(InputError, match=r"model: got no joint panda_joint1, .* expected a joint for each"):
        MujocoPlant(model=str(tmp_path / "other.xml")).begin(PANDA, START, 0.01)
    (tmp_path / "broken.xml").write_text("<mujoco><nothing/></mujoco>")
    with pytest.raises(InputError, match=r"model: got broken.xml: XML Error: .*unrecognized element"):
        MujocoPlant(model=str(tmp_path / "broken.xml")).begin(PANDA, START, 0.01)


def test_what_needs_a_kinematic_plant():
    scenario = sr.Scenario(arm=PANDA, start=START, motion=sr.Wait(0.1), plant=MujocoPlant())
    with pytest.raises(InputError, match="integrator: got 'rk4'"):
        sr.simulate(replace(scenario, integrator="rk4"))
    with pytest.raises(InputError, match="task: got a scenario with MujocoPlant, expected one with KinematicPlant"):
        sr.tolerance.rehearse(scenario)
    assert isinstance(replace(scenario, plant=None).plant, KinematicPlant)
