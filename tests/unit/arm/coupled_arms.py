"""Arms with joints that follow other joints."""

import numpy as np

import stillreach as sr
from tests.unit.arm.odd_arms import placement


def coupled():
    """Seven joints and three followers: one before its leader, one of another kind, one beside its leader."""
    kinds = ["revolute", "prismatic", "revolute", "revolute", "revolute", "prismatic", "revolute"]
    joints = [
        sr.Joint(
            name=f"j{i}", kind=kind, axis=(1, i, 2 - i), placement=placement((0.3, 0.1 * i, 0.2), (i, 1, 1), 0.5 * i)
        )
        for i, kind in enumerate(kinds)
    ]
    early = sr.Joint(name="early", axis=(0, 1, 2), placement=placement((0.1, 0, 0.3)))
    rack = sr.Joint(name="rack", kind="prismatic", axis=(1, 0, 1), placement=placement((0, 0.2, 0), (1, 0, 0), 0.4))
    finger = sr.Joint(name="finger", axis=(0, 1, 0), placement=placement((0.2, 0, 0)))
    followers = [
        sr.Follower(finger, leader="j6", place=9),
        sr.Follower(early, leader="j2", multiplier=-0.5, offset=0.2, place=0),
        sr.Follower(rack, leader="j3", multiplier=0.3, offset=-0.1, place=4),
    ]
    return sr.Arm(joints, tool=placement((0.1, 0.2, 0.3), (1, 2, 3), 1.0), name="coupled", followers=followers)


def uncoupled(arm):
    """The same chain without couplings, and the map (k, n), (k,) from the coupled arm's positions to its own."""
    matrix, offsets = np.zeros((len(arm.chain), arm.n)), np.zeros(len(arm.chain))
    for row, moving in enumerate(arm.chain):
        matrix[row, moving.leader], offsets[row] = moving.factor, moving.offset
    return sr.Arm([moving.joint for moving in arm.chain], tool=arm.tool), matrix, offsets
