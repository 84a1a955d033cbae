"""What `stillreach inspect` says of real robots: for each joint that cannot be spared, which direction is lost.

Judged by eigenvectors of J Jᵀ, and by rates at their limits that make the most of a direction.
"""

import re

import numpy as np
import pytest

from stillreach.arm.losses import best
from stillreach.cli._inspection import print_inspection
from tests.robots.catalogue import ROBOTS

LEAST = np.array([1e-3] * 3 + [np.deg2rad(0.1)] * 3)
LOOKED_AT = [name for name, robot in ROBOTS.items() if robot.n <= 8 and not name.startswith(("TALOS", "robosuite B"))]
NEAR = 1.5
"""Speeds within this factor of the least one are left to either side."""
NOTHING_LOST_NOTHING_LEFT = re.compile(r"(?<!\S)0 %.*\s-\s*$", re.MULTILINE)


def full(arm):
    return np.where(np.isfinite(arm.velocity_limits), arm.velocity_limits, 1.0)


def largest(J, rates, along):
    """How many least speeds a direction gets at most."""
    best = rates * np.sign(along @ J)
    return along @ (J @ best) / np.linalg.norm(along * LEAST)


def weak(J, rates, factor):
    """How many eigenvectors of the scaled J Jᵀ get less than so many least speeds."""
    scaled = J * rates / LEAST[:, None]
    _, vectors = np.linalg.eigh(scaled @ scaled.T)
    return sum(largest(J, rates, vector / LEAST) < factor for vector in vectors.T)


def poses(arm, best):
    lower, upper = np.clip(arm.position_limits, -np.pi, np.pi).T
    return [best, (lower + upper) / 2, np.random.default_rng(7).uniform(lower, upper)]


@pytest.mark.parametrize("name", LOOKED_AT)
def test_a_joint_that_cannot_be_spared_has_its_lost_direction_named(name, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    arm = ROBOTS[name].make()
    rates = full(arm)
    for q in poses(arm, best(arm)):
        found, J = arm.losses(q), arm.jacobian(q)
        for i, lock in enumerate(found.by_joint.values()):
            rest, others = np.delete(J, i, axis=1), np.delete(rates, i)
            assert (lock.remaining == 0.0) == (len(lock.lost) > 0)
            for direction in lock.lost:
                assert largest(rest, others, direction) < 1.0
            few, many = (weak(rest, others, factor) for factor in (1.0 / NEAR, NEAR))
            assert few - weak(J, rates, NEAR) <= len(lock.lost) <= many - weak(J, rates, 1.0 / NEAR)
        print_inspection("here", found)
        printed = capsys.readouterr().out
        assert not NOTHING_LOST_NOTHING_LEFT.search(printed)
        assert " ".join(printed.split()).endswith(found.verdict)


def test_at_least_ten_robots_are_looked_at():
    assert len(LOOKED_AT) >= 10


ROUNDED = {"iiwa 14": ("joint_a4", "iiwa of PyBullet", "lbr_iiwa_joint_4")}
"""A file that rounds π/2, its elbow, and the same robot from a file that does not (or less so)."""


@pytest.mark.parametrize("name", ROUNDED)
def test_a_file_that_rounds_right_angles_tells_the_story_of_one_that_does_not(name):
    elbow, exact, its_elbow = ROUNDED[name]
    for robot, joint in ((name, elbow), (exact, its_elbow)):
        arm = ROBOTS[robot].make()
        found = arm.losses()
        typical = dict(zip(found, found.typical, strict=True))
        assert typical.pop(joint) == 0.0
        assert min(typical.values()) > 0.05
        assert found.verdict.startswith(f"What this arm can spare least is {joint}: ")


def test_xarm7_folded_in_a_plane_cannot_spare_the_joints_that_move_in_it():
    arm = ROBOTS["xArm7"].make()
    lower, upper = arm.position_limits.T
    found = arm.losses((lower + upper) / 2)
    assert [name for name in found if len(found[name].lost)] == ["joint2", "joint4", "joint6"]
    for lock in found.by_joint.values():  # each alone moves the tool in the plane of x, z and wy
        for lost in lock.lost:
            assert np.allclose(lost[[1, 3, 5]], 0.0, atol=1e-3)
