"""Arms, poses and small questions that the controller's tests share."""

import numpy as np
import pytest

import stillreach as sr
from tests import refusals
from tests.unit.arm.odd_arms import placement, random_joints

Q_PAPER = np.deg2rad([45.0, -60.0, 10.0, -45.0, 20.0, 45.0, 90.0, 45.0, -10.0, 30.0, 20.0])
TWIST = np.array([0.05, -0.1, 0.02, 0.03, 0.1, -0.05])
LAWS = [
    sr.Pseudoinverse(),
    sr.SingularityRobust(),
    sr.SingularityRobust(damping="closed-form"),
    sr.LeastError(),
    sr.LeastError(price=None),
    sr.KeepDirection(),
]
EVERY_LAW = pytest.mark.parametrize("law", LAWS, ids=repr)


def paper():
    return sr.arms.nasa_modular()


def mixed(n=8, seed=7):
    """Skew joints, some of them slides, tool off to the side."""
    joints = random_joints(np.random.default_rng(seed), n, slides=0.3)
    return sr.Arm(joints, tool=placement((0.2, -0.1, 0.3), (1, 2, 3), 0.8), name="mixed")


def skew(n=9, seed=5):
    return sr.Arm(random_joints(np.random.default_rng(seed), n, slides=0.0), tool=placement((0.1, 0.2, 0.3)))


def slide(**limits):
    """One joint along x: its rate is the tool's."""
    joint = sr.Joint(kind="prismatic", axis=(1, 0, 0))
    return sr.Controller(sr.Arm([joint]), task=ALONG_X, law=sr.LeastError(price=None), **limits)


ALONG_X = sr.Task(rows=(True, False, False, False, False, False))


def pushed(controller, rate, q=0.0):
    """What a `slide` answers when the tool is asked to move at `rate`."""
    return controller.step([q], [rate, 0, 0, 0, 0, 0])


def configuration(arm, seed=0):
    return np.random.default_rng(seed).uniform(-1.5, 1.5, arm.n)


def null_projector(j, working=None):
    """I - J^+ J over the working joints, zero elsewhere (n, n), by an SVD."""
    n = j.shape[1]
    keep = np.ones(n, bool) if working is None else working
    out = np.zeros((n, n))
    k = np.flatnonzero(keep)
    out[np.ix_(k, k)] = np.eye(len(k)) - np.linalg.pinv(j[:, k], rcond=1e-10) @ j[:, k]
    return out


def refused(call, argument, *data):
    """The call raises InputError about `argument` that shows the data."""
    with refusals.refused(argument, *data):
        call()
