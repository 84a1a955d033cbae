"""Joints that follow other joints of the arm: one joint to everybody, two to the kinematics."""

import pickle
import time

import numpy as np
import pytest

import stillreach as sr
from tests.unit.arm.coupled_arms import coupled, uncoupled
from tests.unit.arm.file_peer import Peer
from tests.unit.arm.mjcf_peer import Peer as MujocoPeer
from tests.unit.arm.odd_arms import configurations, scale
from tests.unit.arm.urdf_texts import joint, random_coupled_tree, robot


def test_a_coupled_chain_is_the_free_chain_at_the_places_its_joints_are_led_to():
    arm = coupled()
    free, matrix, offsets = uncoupled(arm)
    assert (arm.n, free.n) == (7, 10)
    for q in configurations(arm.n, seed=4):
        p, size = matrix @ q + offsets, scale(free, matrix @ q + offsets)
        assert np.max(np.abs(arm.forward(q) - free.forward(p))) <= 1e-13 * size
        assert np.max(np.abs(arm.jacobian(q) - free.jacobian(p) @ matrix)) <= 1e-13 * size


def test_many_configurations_at_once_are_the_same_as_one_by_one():
    arm = coupled()
    q = np.random.default_rng(8).uniform(-2, 2, (5, 3, arm.n))
    assert np.array_equal(arm.jacobian(q)[4, 2], arm.jacobian(q[4, 2]))
    assert np.array_equal(arm.forward(q)[1, 0], arm.forward(q[1, 0]))


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 5, 6, 7, 11])
def test_chains_of_files_whose_joints_follow_each_other_are_pinocchios(seed):
    text, follows = random_coupled_tree(seed)
    peer, rng = Peer(text, follows), np.random.default_rng([2, seed])
    arms = {(base, tip): arm_or_none(text, f"link{base}", f"link{tip}") for base in (0, 11) for tip in range(1, 13)}
    for (base, tip), arm in arms.items():
        for q in rng.uniform(-3, 3, (5 if arm else 0, arm.n if arm else 0)):
            T, J = peer.chain(f"link{base}", f"link{tip}", arm.joint_names, q)
            assert np.max(np.abs(arm.forward(q) - T)) <= 1e-12
            assert np.max(np.abs(arm.jacobian(q) - J)) <= 1e-12
            again = sr.Arm.from_urdf(arm.to_urdf())
            assert np.max(np.abs(again.jacobian(q) - J)) <= 1e-12
            assert again.position_limits.tolist() == arm.position_limits.tolist()
    assert any(arm.followers for arm in arms.values() if arm)


def arm_or_none(text, base, tip):
    """The chain; None where nothing in it moves."""
    try:
        return sr.Arm.from_urdf(text, base=base, tip=tip)
    except sr.errors.RobotFileError as error:
        if "no joint that moves" in str(error):
            return None
        raise


def test_leader_and_follower_are_one_joint_within_the_limits_of_both():
    limit = 'lower="-1" upper="1" velocity="3"'
    text = robot(
        joint("j", "a", "b", limit='lower="-2" upper="2" velocity="2"'),
        joint("k", "b", "c", limit=limit, extra='<mimic joint="j" multiplier="-2" offset="0.5"/>'),
    )
    arm = sr.Arm.from_urdf(text)
    assert arm.joint_names == ("j",)
    assert arm.position_limits.tolist() == [[-0.25, 0.75]]
    assert arm.velocity_limits.tolist() == [1.5]
    assert "follows" in arm.describe()
    assert "-2 j + 0.5" in arm.describe()


def test_held_joints_free_their_followers_from_them():
    follow = '<mimic joint="j" multiplier="2"/>'
    text = robot(joint("j", "a", "b"), joint("k", "b", "c", extra=follow), joint("l", "c", "d"))
    assert sr.Arm.from_urdf(text, fixed={"j": 0.3}).joint_names == ("l",)
    apart = sr.Arm.from_urdf(text, fixed={"k": 0.6})
    assert apart.joint_names == ("j", "l")
    assert apart.followers == ()
    whole = sr.Arm.from_urdf(text)
    assert whole.forward([0.3, 0.1]) == pytest.approx(apart.forward([0.3, 0.1]), abs=1e-15)


CARELESS = {
    # what is wrong: (attributes of the follower's <limit>, its <mimic>)
    "no range": ('velocity="1" effort="1"', 'multiplier="-1"'),
    "no <limit>": ("", ""),
    "a range of one point": ('lower="0" upper="0" velocity="1"', ""),
    "the leader's range, not turned round": ('lower="0" upper="0.8" velocity="1"', 'multiplier="-1"'),
    "turned round, but not swapped": ('lower="0" upper="-0.8" velocity="1"', 'multiplier="-1"'),
    "a range out of reach": ('lower="-1" upper="2" velocity="1"', 'offset="9"'),
    "no velocity": ('lower="-1" upper="2" velocity="0"', ""),
    "a negative velocity": ('lower="-1" upper="2" velocity="-2"', ""),
}


@pytest.mark.parametrize("mistake", CARELESS)
def test_careless_limits_of_a_mimic_joint_do_not_hold_its_leader(mistake):
    limit, mimic = CARELESS[mistake]
    text = robot(
        joint("j", "a", "b", limit='lower="0" upper="0.8" velocity="1"'),
        joint("k", "b", "c", limit=limit, extra=f'<mimic joint="j" {mimic}/>'),
    )
    arm = sr.Arm.from_urdf(text)
    assert arm.position_limits.tolist() == [[0.0, 0.8]]
    assert arm.velocity_limits.tolist() == [1.0]


def test_one_careless_follower_does_not_free_the_leader_of_the_others():
    follow = '<mimic joint="j" multiplier="{}"/>'
    text = robot(
        joint("j", "a", "b", limit='lower="0" upper="0.8" velocity="1"'),
        joint("k", "b", "c", limit='lower="0" upper="0.8" velocity="1"', extra=follow.format(-1)),
        joint("l", "c", "d", limit='lower="0" upper="0.8" velocity="1"', extra=follow.format(2)),
    )
    arm = sr.Arm.from_urdf(text)
    assert arm.position_limits.tolist() == [[0.0, 0.4]]
    assert arm.velocity_limits.tolist() == [0.5]


def test_a_leader_that_its_own_limits_hold_stays_held():
    text = robot(
        joint("j", "a", "b", limit='lower="0.5" upper="0.5" velocity="1"'),
        joint("k", "b", "c", extra='<mimic joint="j"/>'),
        joint("l", "c", "d"),
    )
    assert sr.Arm.from_urdf(text).position_limits.tolist() == [[0.5, 0.5], [-1.0, 2.0]]


@pytest.mark.parametrize("count", [900, 4000])
def test_a_long_chain_of_followers_is_read_soon(count):
    """On the way from base to tip, and beside it."""
    follow = [
        f'<mimic joint="{"lead" if k == 0 else f"j{k - 1}"}" multiplier="-1" offset="0.25"/>' for k in range(count)
    ]
    beside = count > 1000
    links = [("base" if beside or k == 0 else f"l{k - 1}", f"l{k}") for k in range(count)]
    joints = [joint(f"j{k}", *links[k], "continuous", extra=follow[k]) for k in range(count)]
    last = joint("last", "mount", "tip", "continuous", extra=f'<mimic joint="j{count - 1}"/>')
    text = robot(
        joint("lead", "root", "base", "continuous"),
        *joints,
        joint("lift", "base" if beside else f"l{count - 1}", "mount", "fixed"),
        last,
    )
    before = time.process_time()
    arm = sr.Arm.from_urdf(text, base="root", tip="tip")
    assert time.process_time() - before < 8.0
    assert arm.joint_names == ("lead",)
    assert [(f.multiplier, f.offset) for f in arm.followers[:1]] == [(-1.0, 0.25)] if not beside else [(1.0, 0.0)]
    # position of j_k: lead after an even number of turns round, 0.25 - lead after an odd one
    assert (arm.followers[-1].multiplier, arm.followers[-1].offset) == (1.0, 0.0)


def test_a_long_chain_of_couplings_in_an_mjcf_file_is_read_soon():
    bodies = "".join(f'<body name="b{k}"><joint name="j{k}"/></body>' for k in range(1500))
    led = "".join(f'<joint joint1="j{k + 1}" joint2="j{k}" polycoef="0 -1 0 0 0"/>' for k in range(1499))
    text = f"<mujoco><worldbody>{bodies}</worldbody><equality>{led}</equality></mujoco>"
    before = time.process_time()
    with pytest.raises(sr.errors.RobotFileError, match="no joint that moves"):
        sr.Arm.from_mjcf(text, tip="b1499")
    assert time.process_time() - before < 8.0


def test_joints_coupled_in_an_mjcf_file_follow_each_other():
    text = """<mujoco><compiler angle="radian"/><worldbody>
      <body name="a"><joint name="j" axis="0 1 0" ref="0.2" range="-1 1"/><geom size="0.1"/>
        <body name="b" pos="0.5 0 0"><joint name="k" axis="0 1 1" ref="-0.3"/><geom size="0.1"/>
          <body name="c" pos="0 0.3 0"><joint name="l" type="slide"/><geom size="0.1"/></body></body></body>
      </worldbody><equality><joint joint1="k" joint2="j" polycoef="0.1 -2"/></equality></mujoco>"""
    arm = sr.Arm.from_mjcf(text, tip="c")
    assert arm.joint_names == ("j", "l")
    peer = MujocoPeer(text)
    for q in np.random.default_rng(1).uniform(-2, 2, (10, 2)):
        led = -0.3 + 0.1 - 2.0 * (q[0] - 0.2)
        T, J = peer.chain("world", "c", ("j", "k", "l"), [q[0], led, q[1]])
        assert np.max(np.abs(arm.forward(q) - T)) <= 1e-12
        assert np.max(np.abs(arm.jacobian(q) - J @ [[1, 0], [-2, 0], [0, 1]])) <= 1e-12


def test_a_controller_moves_them_together():
    arm = coupled()
    controller = sr.Controller(arm, velocity_limits=0.5, period=1e-4)
    controller.fail("j6")
    q = np.linspace(-0.4, 0.5, arm.n)
    twist = np.array([0.05, -0.02, 0.03, 0.1, 0.0, -0.05])
    answer = controller.step(q, twist)
    assert answer.rates[6] == 0.0
    moved = arm.forward(q + 1e-6 * answer.rates)[:3, 3] - arm.forward(q - 1e-6 * answer.rates)[:3, 3]
    assert moved / 2e-6 == pytest.approx(twist[:3] - answer.residual[:3], abs=1e-8)
    assert answer.task_error < 1e-9


@pytest.mark.parametrize(
    "law", [sr.LeastError(), sr.KeepDirection(), sr.SingularityRobust(), sr.Pseudoinverse()], ids=repr
)
def test_a_batch_gives_what_single_questions_give(law):
    arm, rng = coupled(), np.random.default_rng(0)
    q, twist, bounds = rng.uniform(-3, 3, (9, arm.n)), rng.normal(size=(9, 6)), sr.Bounds.symmetric(0.5, n=arm.n)
    many = sr.solve_batch(arm, law, q, twist, bounds).rates
    kinds = {"row_kinds": "vvvwww", "joint_kinds": "".join("RP"[kind] for kind in arm.kinds)}
    for k in range(9):
        assert np.array_equal(many[k], law.solve(arm.jacobian(q[k]), twist[k], bounds, **kinds).rates)


def test_a_tool_is_added_and_limits_are_set_without_losing_them():
    arm = coupled().with_limits(velocity=1.0)
    shifted = arm.with_tool(arm.tool @ arm.tool)
    q = np.ones(7)
    assert shifted.forward(q) == pytest.approx(arm.forward(q) @ arm.tool)
    assert shifted.followers == arm.followers == coupled().followers
    again = pickle.loads(pickle.dumps(arm))
    assert again == arm
    assert hash(again) == hash(arm)
    assert np.array_equal(again.jacobian(q), arm.jacobian(q))
    assert arm != sr.Arm(arm.joints, tool=arm.tool, name=arm.name)


def test_the_reach_counts_slides_that_follow():
    limits = {"position_limits": (-1.0, 2.0)}
    lift = sr.Joint(name="lift", kind="prismatic", **limits)
    second = sr.Follower(sr.Joint(name="second", kind="prismatic"), leader="lift", multiplier=-2.0, offset=0.5, place=1)
    assert sr.Arm([lift], followers=[second]).reach == 2.0 + 3.5


def test_wrong_followers_are_refused():
    j, k = sr.Joint(name="j"), sr.Joint(name="k")
    follow = sr.Follower(k, leader="j", place=1)
    for followers in (
        7,
        [k],
        [follow, follow],
        [sr.Follower(j, leader="j", place=1)],
        [sr.Follower(k, leader="j", place=2)],
    ):
        with pytest.raises(sr.InputError, match="followers"):
            sr.Arm([j], followers=followers)
    with pytest.raises(sr.InputError, match="leader of 'k': got 'i', expected 'j'"):
        sr.Arm([j], followers=[sr.Follower(k, leader="i", place=1)])
    for wrong in ({"place": -1}, {"multiplier": np.inf}, {"offset": "1"}, {"leader": 3}):
        with pytest.raises(sr.InputError):
            sr.Follower(k, **{"leader": "j", "place": 0} | wrong)
    with pytest.raises(sr.InputError, match="a Joint with a name"):
        sr.Follower(sr.Joint(), leader="j", place=1)
