"""Inverse kinematics: what is found is right, what cannot be is never claimed, and no row depends on another."""

import math
import os
import subprocess
import sys

import numpy as np
import pytest
from scipy.optimize import minimize

import stillreach as sr
from stillreach import InputError
from tests.oracles.kinematics import planar_arm

FULL = bool(os.environ.get("STILLREACH_FULL"))
ARMS = ("panda", "iiwa14", "gen3", "xarm7", "canadarm2", "talos", "nasa_modular")


def ranges(arm):
    """(n, 2) position limits, half a turn to both sides where there are none."""
    lower, upper = arm.position_limits.T
    endless = ~(upper - lower <= 4 * np.pi)
    return np.column_stack((np.where(endless, -np.pi, lower), np.where(endless, np.pi, upper)))


def random_configurations(arm, count, seed=5):
    return np.random.default_rng(seed).uniform(*ranges(arm).T, (count, arm.n))


def check_reached(arm, result, poses, q):
    """Reached poses are met, inside the position limits."""
    lower, upper = arm.position_limits.T
    assert np.abs(arm.forward(q) - poses)[result.reached].max(initial=0.0) < 1e-8
    assert np.all((q >= lower) & (q <= upper))


@pytest.mark.parametrize("name", ARMS)
def test_poses_of_random_configurations_are_reached(name):
    """At least the shares that the documentation names: 99.99 % with all joints, 99.95 % with one held."""
    arm = getattr(sr.arms, name)()
    q = random_configurations(arm, 20_000 if FULL else 500)
    poses = arm.forward(q)
    result = arm.inverse(poses, starts=300)
    check_reached(arm, result, poses, result.q)
    assert result.share >= 0.9999
    start = random_configurations(arm, len(q), seed=6)
    for joint in range(arm.n) if FULL else (1, 3):
        start[:, joint] = q[:, joint]
        result = arm.inverse(poses, start, locked=[joint], starts=300)
        check_reached(arm, result, poses, result.q)
        assert np.array_equal(result.q[:, joint], q[:, joint])
        nearly_spherical = name == "xarm7" and joint == 3  # without its elbow it is nearly singular everywhere
        assert result.share >= (0.99 if nearly_spherical else 0.9995)


def two_link(position):
    """Both configurations (2, 2) of a planar arm of two unit links, in closed form."""
    x, y = position
    bend = math.acos((x * x + y * y - 2.0) / 2.0)
    first = math.atan2(y, x)
    return np.array([[first - bend / 2, bend], [first + bend / 2, -bend]])


def planar_task():
    return sr.Task(rows=[True, True, False, False, False, False])


def test_both_configurations_of_two_links_are_found():
    arm = sr.arms.planar(2)
    rng = np.random.default_rng(0)
    for _ in range(20):
        radius, angle = rng.uniform(0.2, 1.8), rng.uniform(-3.0, 3.0)
        target = np.eye(4)
        target[:2, 3] = radius * np.cos(angle), radius * np.sin(angle)
        result = arm.inverse(target, task=planar_task(), solutions=4, starts=50)
        assert result.found == 2
        assert result.starts == 50
        assert np.isnan(result.q[2:]).all()
        turns = np.exp(1j * result.q[:2])
        exact = np.exp(1j * two_link(target[:2, 3]))
        assert min(np.abs(turns - exact).max(), np.abs(turns - exact[::-1]).max()) < 1e-8


def test_joints_held_at_one_of_several_values():
    """Two unit links with the second at -1 or 2 rad reach two circles, of radius 2 cos(1/2) and 2 cos(1)."""
    arm = sr.arms.planar(2)
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, 0, 3] = 2 * math.cos(0.5), 2 * math.cos(1.0), 1.5
    result = arm.inverse(poses, locked={"j2": [-1.0, 2.0]}, task=planar_task(), starts=20)
    assert result.reached.tolist() == [True, True, False]
    assert result.q[:2, 1].tolist() == [-1.0, 2.0]
    assert result.residual[2] == pytest.approx(2 * math.cos(0.5) - 1.5, abs=1e-6)


def test_what_cannot_be_reached_is_never_claimed():
    """Beyond the stretched arm; and inside it where limits exclude it: a bend of at most 1 rad leaves a ring."""
    arm = sr.arms.planar(2).with_limits(position=[[-10.0, 10.0], [-1.0, 1.0]])
    rng = np.random.default_rng(1)
    radius = np.concatenate((rng.uniform(2.0001, 4.0, 100), rng.uniform(0.0, 2 * math.cos(0.5) - 1e-4, 100)))
    angle = rng.uniform(-np.pi, np.pi, 200)
    poses = np.tile(np.eye(4), (200, 1, 1))
    poses[:, 0, 3], poses[:, 1, 3] = radius * np.cos(angle), radius * np.sin(angle)
    result = arm.inverse(poses, task=planar_task(), starts=30)
    assert not result.reached.any()
    assert result.too_far.tolist() == [True] * 100 + [False] * 100
    assert (result.starts <= np.where(result.too_far, 3, 30)).all()
    closest = np.linalg.norm(arm.forward(result.q)[:, :2, 3] - poses[:, :2, 3], axis=1)
    ring = np.where(radius > 2.0, radius - 2.0, 2 * math.cos(0.5) - radius)
    assert np.allclose(closest, ring, atol=5e-3)
    assert (closest >= ring - 1e-12).all()
    assert "out of reach" in result.explain(0)
    assert "limit" in result.explain(150)


def test_a_panda_excluded_by_its_limits_by_a_dense_sample():
    """Poses of other limits whose positions no dense sample of the own ones comes near."""
    wide = sr.arms.panda()
    own = wide.with_limits(position=[[-0.4, 0.4]] * 3 + [[-1.4, -1.0]] + [[-0.4, 0.4]] * 3)
    sample = own.forward(random_configurations(own, 200_000, seed=2))[:, :3, 3]
    poses = wide.forward(random_configurations(wide, 300, seed=3))
    gap = np.array([np.linalg.norm(sample - place, axis=1).min() for place in poses[:, :3, 3]])
    excluded = poses[gap > 0.1]
    assert len(excluded) > 100
    assert not own.inverse(excluded, starts=30).reached.any()


def test_faults_restrict_the_range():
    arm = sr.arms.panda()
    q = random_configurations(arm, 300)
    poses = arm.forward(q)
    j2, j4, j6 = "panda_joint2", "panda_joint4", "panda_joint6"
    start = q[0]
    faults = {j2: sr.Confined(-0.5, 0.5), j4: sr.OneWay(-1.0), j6: sr.Derated(0.1), 0: sr.Locked()}
    result = arm.inverse(poses, start, faults=faults)
    at = result.q[result.reached]
    assert 0 < len(at) < 300
    assert (np.abs(at[:, 1]) <= 0.5).all()
    assert (at[:, 3] <= start[3]).all()
    assert (at[:, 0] == start[0]).all()
    assert result.held == ("panda_joint1",)


def nearest_by_scipy(start, place, first):
    """Distance from `start` of the configuration of `place` that sequential quadratic programming ends at."""
    result = minimize(
        lambda q: np.sum((q - start) ** 2),
        first,
        jac=lambda q: 2 * (q - start),
        bounds=[(-1.2, 1.2)] * 4,
        constraints={"type": "eq", "fun": lambda q: planar_arm(q)[0] - place, "jac": lambda q: planar_arm(q)[1]},
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 200},
    )
    assert np.abs(planar_arm(result.x)[0] - place).max() < 1e-6
    return math.sqrt(result.fun)


def test_the_nearest_configuration():
    """SciPy's SQP from the same start ends at the same distance; planar arm of four links, and its limits bind."""
    arm = sr.arms.planar(4).with_limits(position=[-1.2, 1.2])
    rng = np.random.default_rng(3)
    better = 0
    for _ in range(20):
        start, goal = rng.uniform(-1, 1, (2, 4))
        place, _ = planar_arm(goal)
        target = np.eye(4)
        target[:2, 3] = place
        near = arm.inverse(target, start, task=planar_task(), nearest=True)
        assert near.reached
        distance = np.linalg.norm(near.q - start)
        assert distance <= nearest_by_scipy(start, place, near.q) + 1e-6
        anyone = arm.inverse(target, start, task=planar_task())
        better += distance < np.linalg.norm(anyone.q - start) - 1e-9
    assert better >= 10


@pytest.mark.parametrize("distance", [0.2, 0.7, 1.6, 2.5])
def test_the_longest_self_motion(distance):
    """Unit planar 3R at distance R: |θ2|, |θ3| <= 2 acos(|R - 1| / 2), and no further."""
    arm = sr.arms.planar(3)
    target = np.eye(4)
    target[0, 3] = distance
    most = 2 * math.acos(abs(distance - 1.0) / 2)
    for joint in ("j2", "j3"):
        inside = arm.inverse(target, locked={joint: most - 1e-4}, task=planar_task())
        beyond = arm.inverse(target, locked={joint: most + 1e-4}, task=planar_task())
        assert inside.reached
        assert not beyond.reached


def test_a_row_depends_on_nothing_but_its_pose():
    arm = sr.arms.panda()
    q = random_configurations(arm, 400)
    poses = arm.forward(q)
    all_rows = arm.inverse(poses, starts=5, threads=1)
    some = np.random.default_rng(0).permutation(400)[:150]
    part = arm.inverse(poses[some], starts=5, threads=2)
    for name in ("q", "residual", "found", "starts", "steps"):
        assert np.array_equal(getattr(part, name), getattr(all_rows, name)[some])
    one = arm.inverse(poses[7], starts=5)
    assert np.array_equal(one.q, all_rows.q[7])
    other = arm.inverse(poses, starts=5, seed=1)
    assert not np.array_equal(other.q, all_rows.q)


BITS = """
import hashlib, numpy as np, stillreach as sr
arm = sr.arms.panda()
q = np.random.default_rng(5).uniform(*arm.position_limits.T, (200, 7))
result = arm.inverse(arm.forward(q.round(3)).round(6) @ np.eye(4), starts=4)
print(sr._core.instruction_set(), hashlib.sha256(result.q.tobytes()).hexdigest())
"""


def test_instruction_sets_with_fused_multiply_add_give_the_same_bits():
    found = {}
    for name in ("avx2", "avx512"):
        environment = os.environ | {"STILLREACH_INSTRUCTIONS": name}
        run = subprocess.run([sys.executable, "-c", BITS], env=environment, capture_output=True, text=True, check=True)
        used, bits = run.stdout.split()
        found[used] = bits
    if set(found) != {"avx2", "avx512"}:
        pytest.skip("needs a processor with AVX2 and AVX-512")
    assert found["avx2"] == found["avx512"]


def test_solutions_are_different_and_nearly_all():
    """Without one of a Panda's joints, few starts hold nearly all configurations that ten times as many find."""
    arm = sr.arms.panda()
    q = random_configurations(arm, 1000 if FULL else 20)
    poses = arm.forward(q)
    few = arm.inverse(poses, q, locked=[3], solutions=8, starts=200)
    many = arm.inverse(poses, q, locked=[3], solutions=64, starts=2000, seed=9)
    total = held = 0
    for row in range(len(q)):
        own = few.q[row, : few.found[row]]
        check_reached(arm, few, poses, few.q[:, 0])
        apart = np.abs(own[:, None] - own[None]).max(axis=2) + 9.0 * np.eye(len(own))
        assert apart.min() >= 1e-3
        for other in many.q[row, : many.found[row]]:
            total += 1
            held += np.abs(own - other).max(axis=1).min() < 1e-2
    assert held >= 0.95 * min(total, 8 * len(q))


def test_tasks():
    arm = sr.arms.panda()
    q = random_configurations(arm, 100)
    poses = arm.forward(q)
    place = arm.inverse(poses, task=sr.Task(rows="position"))
    assert place.reached.all()
    assert np.abs(arm.forward(place.q) - poses)[:, :3, 3].max() < 1e-8
    five = arm.inverse(poses, task=sr.Task(rows=[True] * 5 + [False], frame="tool"))
    assert five.reached.all()
    at = arm.forward(five.q)
    assert np.abs(at[:, :3, 3] - poses[:, :3, 3]).max() < 1e-8
    assert np.abs(at[:, :3, 2] - poses[:, :3, 2]).max() < 1e-8  # free to turn about the tool's z, which stays
    tool = np.eye(4)
    tool[2, 3] = 0.1
    moved = arm.inverse(poses @ tool, task=sr.Task(tool=tool))
    assert moved.reached.all()
    assert np.abs(arm.forward(moved.q) - poses).max() < 1e-8


def test_prismatic_joints():
    """A gantry of three slides has one answer, and limits decide whether it is reached."""
    slides = [sr.Joint(kind="prismatic", axis=axis, position_limits=(-1.0, 2.0)) for axis in np.eye(3)]
    arm = sr.Arm(slides)
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[:, :3, 3] = [[0.5, -0.7, 1.9], [0.5, -1.3, 0.0]]
    result = arm.inverse(poses, task=sr.Task(rows="position"))
    assert result.reached.tolist() == [True, False]
    assert np.allclose(result.q, [[0.5, -0.7, 1.9], [0.5, -1.0, 0.0]], atol=1e-9)


def test_shapes_and_words():
    arm = sr.arms.panda()
    q = random_configurations(arm, 6).reshape(2, 3, 7)
    result = arm.inverse(arm.forward(q), q)
    assert result.q.shape == (2, 3, 7)
    assert result.reached.shape == (2, 3)
    assert len(result) == 2
    assert np.array_equal(result.q, q)
    assert str(result) == "6 of 6 poses reached"
    assert result.explain((1, 2)) == "reached after 1 start"
    one = arm.inverse(arm.forward(q[0, 0]))
    assert one.q.shape == (7,)
    assert bool(one.reached)
    with pytest.raises(TypeError):
        len(one)
    assert math.isnan(arm.inverse(np.zeros((0, 4, 4))).share)
    by_name = arm.inverse(arm.forward(q[0, 0]), dict(zip(arm.joint_names, q[0, 0], strict=True)))
    assert np.array_equal(by_name.q, q[0, 0])


@pytest.mark.parametrize(("name", "joint"), [("xarm7", "joint4"), ("gen3", "joint_4"), ("iiwa14", "joint_4")])
def test_the_elbow_of_a_nearly_spherical_arm_is_named(name, joint):
    arm = sr.arms.by_name(name)
    q = random_configurations(arm, 40)
    result = arm.inverse(arm.forward(q), q[0], locked=[joint], starts=2)
    lost = np.flatnonzero(~result.reached)[0]
    J = arm.jacobian(random_configurations(arm, 2000, seed=8))
    whole, left = (np.linalg.svd(part)[1].prod(axis=-1) for part in (J, np.delete(J, 3, axis=2)))
    assert result.remaining == pytest.approx(np.median(left / whole), rel=0.3, abs=1e-6)
    said = f"Without {joint} this arm is nearly singular in most configurations"
    for text in (str(result), result.explain(lost)):
        assert said in text
    away = np.eye(4)
    away[0, 3] = 9.0
    whole_arm = arm.inverse(away @ arm.forward(q), starts=1)
    assert not whole_arm.reached.any()
    assert "nearly singular" not in str(whole_arm)
    assert whole_arm.remaining == 1.0


def test_other_joints_are_not_called_so():
    arm = sr.arms.panda()
    q = random_configurations(arm, 40)
    result = arm.inverse(arm.forward(q), q[0], locked=["panda_joint3"], starts=1)
    assert not result.reached.all()
    assert 0.3 < result.remaining < 0.7
    assert "nearly singular" not in str(result)


def test_fewer_joints_than_rows_and_a_joint_outside_its_limits_are_said():
    arm = sr.arms.planar(2).with_limits(position=[-1.0, 1.0])
    target = np.eye(4)
    target[0, 3] = 1.0
    one = arm.inverse(target, locked={"j2": 3.0}, task=planar_task())
    assert "with j2 held, j2 outside its position limits; " in one.explain()
    assert "1 free joint cannot follow the 2 rows of the task" in one.explain()
    both = arm.inverse(target, locked={"j1": 0.5, "j2": 0.5}, task=planar_task())
    assert both.explain().startswith("not reached from 100 starts with every joint held; the closest")


def test_the_pose_that_is_wrong_is_named():
    poses = np.tile(np.eye(4), (2, 3, 1, 1))
    poses[1, 2, 0, 3] = np.nan
    with pytest.raises(InputError, match=r"got nan at index \(0, 3\) in pose \(1, 2\)"):
        sr.arms.panda().inverse(poses)
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    with pytest.raises(InputError, match=r"poses: got a reflection \(determinant -1\), expected"):
        sr.arms.panda().inverse(mirror)


J4 = "panda_joint4"


@pytest.mark.parametrize(
    ("arguments", "argument"),
    [
        ({"poses": np.eye(3)}, "poses"),
        ({"poses": np.ones((2, 4, 4))}, "poses"),
        ({"poses": np.full((4, 4), np.nan)}, "poses"),
        ({"start": [0.0] * 6}, "start"),
        ({"start": np.zeros((2, 7))}, "start"),
        ({"locked": J4}, "locked"),
        ({"locked": [J4]}, "start"),
        ({"locked": {J4: []}}, "locked"),
        ({"locked": {J4: np.inf}}, "locked"),
        ({"locked": {J4: "0"}}, "locked"),
        ({"locked": {J4: 0.0, 3: 0.0}}, "locked"),
        ({"locked": {J4: [0.0] * 101, 0: [0.0] * 100}}, "locked"),
        ({"locked": ["j9"]}, "joint"),
        ({"faults": [J4]}, "faults"),
        ({"faults": {J4: sr.Runaway(0.1)}}, "faults"),
        ({"faults": {J4: sr.Confined(0.5, 1.0)}}, "faults"),
        ({"faults": {J4: sr.OneWay(1.0)}}, "start"),
        ({"faults": {J4: sr.Locked()}}, "start"),
        ({"faults": {J4: sr.Locked()}, "locked": {J4: -1.0}}, "faults"),
        ({"task": "position"}, "task"),
        ({"starts": 0}, "starts"),
        ({"starts": 10**7}, "starts"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"nearest": True}, "nearest"),
        ({"solutions": 0}, "solutions"),
        ({"apart": -1.0}, "apart"),
        ({"seed": -1}, "seed"),
        ({"threads": 0}, "threads"),
    ],
)
def test_invalid_arguments(arguments, argument):
    arm = sr.arms.panda()
    poses = arguments.pop("poses", np.eye(4)[None])
    with pytest.raises(InputError) as caught:
        arm.inverse(poses, **arguments)
    assert caught.value.argument == argument


def test_an_index_that_is_none():
    result = sr.arms.panda().inverse(np.eye(4)[None])
    for index in (1, "a", (0, 0)):
        with pytest.raises(InputError):
            result.explain(index)
