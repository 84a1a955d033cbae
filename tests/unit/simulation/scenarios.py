"""Scenarios that the simulation is tested on."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

import stillreach as sr
from tests.unit.arm.odd_arms import placement, random_joints


def eight_joints():
    """Eight skew joints of both kinds, well away from singularities at `eight_joints_start`."""
    return sr.Arm(random_joints(np.random.default_rng(3), 8), tool=placement((0.2, 0.1, 0.3)), name="eight joints")


def eight_joints_start():
    return np.linspace(-0.6, 0.8, 8)


def followed(T_start, twists, durations):
    """(K + 1, 4, 4) poses of a tool that follows K twists, each held for a time, with SciPy's rotations."""
    poses = [np.asarray(T_start)]
    for (*v, wx, wy, wz), held in zip(twists, np.broadcast_to(durations, len(twists)), strict=True):
        T = poses[-1].copy()
        T[:3, 3] += held * np.array(v)
        T[:3, :3] = Rotation.from_rotvec([held * wx, held * wy, held * wz]).as_matrix() @ T[:3, :3]
        poses.append(T)
    return np.array(poses)


def waving(t):
    """A smooth twist that is never the same twice."""
    return [0.3 * np.cos(2 * t), 0.2 * np.sin(3 * t), 0.1 * t, 0.2 * np.sin(t), -0.1, 0.3 * np.cos(t)]


def first_ticks(run, ticks):
    """A run that Ctrl-C ended after so many ticks."""
    return replace(run, interrupted=True, **{name: array[:ticks] for name, array in run.arrays().items()})


def small_run(**changes):
    """A second and a half of an arm of both joint kinds, with every kind of fault: 31 ticks."""
    arm = eight_joints().with_limits(velocity=0.5)
    faults = [
        sr.Fault("j2", at=0.5),
        sr.Fault(4, at=0.25, kind=sr.Derated(0.3), until=1.0),
        sr.Fault("j7", at=0.75, kind=sr.Runaway(0.05), until=1.25),
    ]
    settings = {"motion": waving, "period": 0.05, "duration": 1.5, "law": sr.SingularityRobust(), "name": "a small run"}
    return sr.simulate(
        sr.Scenario(**{"arm": arm, "start": eight_joints_start(), "faults": faults, **settings, **changes})
    )
