"""Why a tool did not arrive: each sentence is judged by linear programs and least squares of SciPy.

Jacobians come from differences of the forward kinematics, so that nothing but the recorded bounds and commands is the
run's own.
"""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import linprog, lsq_linear

import stillreach as sr
from stillreach._rotations import log
from tests.unit.simulation.scenarios import first_ticks

PLANE = sr.Task(rows=(True, True, False, False, False, False))
BENT = [0.3, 0.9, -0.8]


def planar(motion, **settings):
    """Three links of 1 m, each joint up to 1 rad/s."""
    arm = sr.arms.planar(3).with_limits(velocity=1.0)
    return sr.Scenario(**{"arm": arm, "start": BENT, "motion": motion, "task": PLANE, "loop": "closed"} | settings)


def line(x, y, duration):
    return sr.Line(to=[x, y, 0], relative=True, duration=duration)


def rest(duration):
    return sr.ConstantTwist(np.zeros(6), duration=duration)


def without_elbow():
    motion = sr.Line(to=[2, -1.5, 1.5], relative=True, duration=9.0)
    start = np.deg2rad([0, 20, -60, 100, -60, 30, 0])
    arm = sr.arms.canadarm2().with_limits(velocity=1.0)
    return sr.Scenario(arm=arm, start=start, motion=motion, loop="closed", faults=[sr.Fault("j4", at=3.0)])


SCENARIOS = {
    "an elbow is locked": without_elbow,
    "the goal is out of reach": lambda: planar(sr.ConstantTwist([0.5, 0, 0, 0, 0, 0], duration=4.0)),
    "drives get weak": lambda: planar(
        line(-0.6, 0.8, 2.0), faults=[sr.Fault(joint, at=0.5, kind=sr.Derated(0.2)) for joint in range(3)]
    ),
    "position limits are in the way": lambda: planar(
        [line(-1.6, 1.2, 3.0), rest(1.0)], position_limits=[(-3, 0.6), (-3, 1.2), (-3, 3)]
    ),
    "an arm brakes, then can hardly move": lambda: sr.Scenario(
        arm=sr.arms.panda(),
        start=np.deg2rad([20, -45, 20, -125, 20, 95, 45]),
        motion=sr.Circle(centre=[0, 0.12, 0], axis=[1, 0, 0], duration=6.0, relative=True),
        loop="closed",
        faults=[sr.Fault("panda_joint4", at=2.0)],
    ),
    "a joint runs away": lambda: planar(
        rest(3.0), faults=[sr.Fault(0, at=0.5, kind=sr.Runaway(0.4)), sr.Fault(1, at=0.8)]
    ),
    "two of three are locked, open loop": lambda: planar(
        sr.ConstantTwist([-0.2, 0.1, 0, 0, 0, 0], duration=3.0),
        loop="open",
        faults=[sr.Fault(j, at=1.0) for j in (0, 1)],
    ),
    "no joint works for a while, open loop": lambda: planar(
        sr.ConstantTwist([-0.2, 0.1, 0, 0, 0, 0], duration=3.0),
        loop="open",
        faults=[sr.Fault(j, at=1.0, until=2.0) for j in range(3)],
    ),
    "rate limits of 0": lambda: planar(line(-0.2, 0.1, 1.0), velocity_limits=0.0),
    "the paper's second example": lambda: sr.Scenario.load("paper-example-2"),
    "a law that keeps the direction": lambda: replace(SCENARIOS["drives get weak"](), law=sr.KeepDirection()),
}
SLOW = r"from [01]\.[0-9]+ s on the arm is too slow along .* vx .*: at most .* % .*; at .* % of the speed it could$"
HARDLY = "from {} the arm (can|could) hardly move along "
SENTENCES = {
    "an elbow is locked": HARDLY.format("[34].* s on") + ".*; without orientation it could$",
    "the goal is out of reach": HARDLY.format(".* s on") + "[0-9. vxy+]*$",
    "drives get weak": SLOW,
    "position limits are in the way": HARDLY.format(".* s on"),
    "an arm brakes, then can hardly move": HARDLY.format("2 s on") + ".*; without position it could$",
    "a joint runs away": "from 0.8 s on a runaway joint moves the tool against .*, and the others cannot stop it$",
    "two of three are locked, open loop": HARDLY.format("1 s on"),
    "no joint works for a while, open loop": HARDLY.format("1 to 2 s") + ".*; open loop does not correct the error$",
    "rate limits of 0": HARDLY.format("0 s on"),
    "the paper's second example": HARDLY.format("[234].* s on") + r"-?[0-9.]+ vx [+-] [0-9.]+ vz$",
    "a law that keeps the direction": SLOW,
}
NAMED = pytest.mark.parametrize("name", SCENARIOS)


@cache
def told(name):
    """Scenario, run and summary."""
    scenario = SCENARIOS[name]()
    run = sr.simulate(scenario)
    return scenario, run, run.summary()


def jacobian(scenario, q):
    """(m, n) of the task's rows along base axes, by central differences of the pose."""
    columns = []
    for joint in range(scenario.arm.n):
        step = np.zeros(scenario.arm.n)
        step[joint] = 1e-5
        before, after = (scenario.arm.forward(q + sign * step) for sign in (-1, 1))
        turn = log((after[:3, :3] @ before[:3, :3].T)[None])[0]
        columns.append(np.concatenate([after[:3, 3] - before[:3, 3], turn]) / 2e-5)
    return np.array(columns).T[list(scenario.task.indices)]


def units(scenario):
    """(m,) what counts as 1 in each row."""
    weights = scenario.task.weights or sr.Weights()
    return np.where(np.less(scenario.task.indices, 3), weights.length, weights.angle)


def at_tick(scenario, run, tick):
    """Jacobian and command in units of the weights, and the pairs of bounds, at a tick."""
    J = jacobian(scenario, run.q[tick]) / units(scenario)[:, None]
    return J, run.command[tick, list(scenario.task.indices)] / units(scenario), np.c_[run.lower[tick], run.upper[tick]]


def most_along(J, box, direction):
    """The largest motion along a direction, by a linear program."""
    found = linprog(-(direction @ J), bounds=box)
    assert found.status == 0
    return -found.fun


def fraction(J, wanted, box):
    """The largest part, up to 1, of a twist that rates in the box do, by a linear program; 0 where there is none."""
    cost = np.zeros(J.shape[1] + 1)
    cost[-1] = -1.0
    scale = np.max(np.abs(wanted))
    found = linprog(cost, A_eq=np.c_[J, -wanted] / scale, b_eq=np.zeros(len(J)), bounds=[*box, (0.0, 1.0)])
    return -found.fun if found.status == 0 else 0.0


def possible(J, wanted, box):
    """Along the residual of the least squares in the box, the part of the command that can be done; 1 where all can."""
    moves = box[:, 0] < box[:, 1]
    rest = wanted - J[:, ~moves] @ box[~moves, 0]
    left = rest
    if moves.any():
        found = lsq_linear(J[:, moves], rest, bounds=box[moves].T, method="bvls", max_iter=500, tol=1e-14)
        left = rest - J[:, moves] @ found.x
    if np.linalg.norm(left) <= 0.01 * np.linalg.norm(wanted):
        return 1.0
    return most_along(J, box, left) / (left @ wanted) if left @ wanted > 0.0 else -np.inf


@NAMED
def test_none_of_them_arrives_and_each_says_why_in_a_sentence(name):
    _, _, found = told(name)
    assert not found.finished
    assert re.match(SENTENCES[name], found.why.sentence), found.why.sentence
    assert "\n" not in found.why.sentence


@NAMED
def test_the_direction_is_one_along_which_no_rates_give_what_is_commanded(name):
    scenario, run, found = told(name)
    J, wanted, box = at_tick(scenario, run, round(found.why.at / scenario.period))
    assert np.linalg.norm(found.why.direction) == pytest.approx(1.0)
    most, asked = most_along(J, box, found.why.direction), found.why.direction @ wanted
    assert asked > most
    assert most / asked == pytest.approx(found.why.possible, rel=1e-4, abs=1e-6)
    if " hardly " in found.why.sentence:
        assert most <= 0.1 * asked
    if " too slow " in found.why.sentence:
        assert 0.1 * asked < most
        said = float(re.search(r"at most ([0-9.]+) %", found.why.sentence)[1])
        assert said == pytest.approx(100 * most / asked, rel=0.01)


@NAMED
def test_it_is_so_from_then_on_and_was_not_before(name):
    scenario, run, found = told(name)
    why, period = found.why, scenario.period
    since, end = round(why.since / period), len(run) - 1 if why.until is None else round(why.until / period)
    limit = 0.1 if " hardly " in why.sentence else 0.999
    inside = np.unique(np.linspace(since, end - 1, 15).astype(int))
    parts = [possible(*at_tick(scenario, run, tick)) for tick in inside if np.any(run.command[tick])]
    assert parts[0] <= limit * 1.0001
    assert np.mean(np.array(parts) <= limit * 1.0001) > 0.8
    if since > 0:
        before = possible(*at_tick(scenario, run, since - 1))
        assert before > (limit if limit == 0.1 else 0.98)


@NAMED
def test_what_it_could_still_do_is_possible_and_what_is_not_named_is_not(name):
    scenario, run, found = told(name)
    J, wanted, box = at_tick(scenario, run, round(found.why.at / scenario.period))
    if not np.any(wanted):
        assert found.why.instead is None
        return
    whole, linear = fraction(J, wanted, box), np.less(scenario.task.indices, 3)
    assert whole < 1.0
    if found.why.instead == "slower":
        said = float(re.search(r"at ([0-9.]+) % of the speed", found.why.sentence)[1])
        assert said == pytest.approx(100 * whole, rel=0.01)
        return
    assert whole < 0.1
    assert np.any(linear)
    if found.why.instead == "position":
        assert fraction(J[linear], wanted[linear], box) > 0.99
    elif np.any(~linear):
        assert fraction(J[linear], wanted[linear], box) < 0.99


def test_a_law_that_does_less_than_it_could_is_named():
    scenario = planar(
        sr.ConstantTwist([-0.2, 0.1, 0, 0, 0, 0], duration=3.0), loop="open", law=sr.SingularityRobust(damping=0.5)
    )
    run = sr.simulate(scenario)
    found = run.summary()
    assert found.why.sentence.startswith("from 0 s on SingularityRobust leaves up to ")
    assert found.why.direction is None
    for tick in range(0, len(run) - 1, 30):
        assert fraction(*at_tick(scenario, run, tick)) > 1 - 1e-9


def test_steps_of_an_open_loop_are_named_where_every_tick_does_its_command():
    scenario = planar(sr.ConstantTwist([-0.2, 0.3, 0, 0, 0, 0], duration=3.0), loop="open", period=0.25)
    run = sr.simulate(scenario)
    found = run.summary()
    assert np.max(run.task_error) < 1e-9
    assert found.why.sentence == (
        "every tick executes the commanded twist; the error comes from the open loop with steps of 250 ms"
    )
    assert found.why.since is None


def test_a_tool_that_arrives_or_was_interrupted_needs_no_reason():
    scenario = planar(line(-0.2, 0.1, 2.0))
    run = sr.simulate(scenario)
    assert run.summary().why is None
    assert first_ticks(run, 40).summary().why is None


def test_which_part_of_the_task_gave_way_and_by_how_much():
    _, run, found = told("an elbow is locked")
    shift = np.linalg.norm(run.target[:, :3, 3] - run.pose[:, :3, 3], axis=1)
    cosine = (np.einsum("tij,tij->t", run.target[:, :3, :3], run.pose[:, :3, :3]) - 1.0) / 2.0
    turn = np.arccos(np.clip(cosine, -1.0, 1.0))
    assert (found.distance.value, found.goal_distance) == pytest.approx((np.max(shift), shift[-1]))
    assert (found.angle.value, found.goal_angle) == pytest.approx((np.max(turn), turn[-1]), rel=1e-5)
    parts = {"position": np.max(shift) > found.allowed_distance, "orientation": np.max(turn) > found.allowed_angle}
    assert found.gave_way == tuple(part for part, gave in parts.items() if gave)
    assert "position" in found.gave_way


def test_an_arm_that_brakes_after_its_motion_has_no_runaway_joint():
    """A fault ends before a motion that ends at full speed: the last ticks brake within the acceleration limits."""
    scenario = sr.Scenario(
        arm=sr.arms.panda(),
        start=np.deg2rad([20, -45, 20, -125, 20, 95, 45]),
        motion=[sr.ConstantTwist([-0.1, 0.05, 0.05, 0, 0, 0], 3.0), sr.Wait(0.05)],
        faults=[sr.Fault("panda_joint4", at=1.0, until=2.5)],
    )
    why = sr.simulate(scenario).summary().why
    assert why is not None
    assert "runaway" not in why.sentence
    assert why.since >= 1.0
    assert why.until == pytest.approx(2.5, abs=0.05)


def test_a_runaway_joint_is_blamed_from_its_own_time_on():
    """The arm misses its command from 1 s on, when two joints lock; the third runs away at 2 s."""
    scenario = sr.Scenario(
        arm=sr.arms.panda(),
        start=np.deg2rad([20, -45, 20, -125, 20, 95, 45]),
        motion=sr.ConstantTwist([-0.1, 0.05, 0.05, 0, 0, 0], 4.0),
        law=sr.KeepDirection(),
        faults=[
            sr.Fault("panda_joint4", at=1.0),
            sr.Fault("panda_joint6", at=1.0),
            sr.Fault("panda_joint5", at=2.0, kind=sr.Runaway(0.5)),
        ],
    )
    run = sr.simulate(scenario)
    assert run.task_error[150] > 0.01
    why = run.summary().why
    assert why is not None
    assert why.sentence.startswith("from 2 s on a runaway joint moves the tool")
    assert why.since == pytest.approx(2.0)
