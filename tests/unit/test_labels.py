"""Values with labels are read by label, at every door; or refused, but never read by their order."""

from collections import OrderedDict
from types import MappingProxyType

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import stillreach as sr
from tests.unit.control.robots import mixed, refused

NAMES = ("shoulder_pan", "shoulder_lift", "elbow", "wrist")
ALPHABETICAL = tuple(sorted(NAMES))
Q = np.array([0.2, -0.5, 0.9, 0.4])
BY_NAME = {name: float(Q[NAMES.index(name)]) for name in ALPHABETICAL}  # as a joint_states message has them
TWIST = np.array([0.1, -0.2, 0.3, 0.05, 0.02, -0.1])

FORMS = {
    "dict": lambda d: dict(d),
    "ordered": lambda d: OrderedDict(reversed(list(d.items()))),
    "mapping": lambda d: MappingProxyType(d),
    "series": lambda d: pd.Series(d),
    "nullable series": lambda d: pd.Series(d, dtype="Float64"),
    "NumPy numbers": lambda d: {name: np.float64(value) for name, value in d.items()},
    "data array": lambda d: xr.DataArray(list(d.values()), dims=["joint"], coords={"joint": list(d)}),
}
EVERY_FORM = pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)


def arm(**limits):
    joints = [
        sr.Joint(name=name, placement=joint.placement, axis=joint.axis)
        for name, joint in zip(NAMES, mixed(4).joints, strict=True)
    ]
    return sr.Arm(joints).with_limits(velocity=1.0, **limits)


@EVERY_FORM
def test_an_arm_reads_joint_values_by_name(form):
    given = form(BY_NAME)
    for method in ("forward", "jacobian", "singular_values", "manipulability"):
        np.testing.assert_array_equal(getattr(arm(), method)(given), getattr(arm(), method)(Q), err_msg=method)


@EVERY_FORM
def test_a_controller_reads_joint_values_by_name(form):
    given, target = form(BY_NAME), arm().forward(Q + 0.1)
    a, b = (sr.Controller(arm()) for _ in range(2))
    np.testing.assert_array_equal(a.step(given, TWIST).rates, b.step(Q, TWIST).rates)
    np.testing.assert_array_equal(a.track(given, target).rates, b.track(Q, target).rates)
    a.reset(given)
    np.testing.assert_array_equal(a.last_rates, Q)


@EVERY_FORM
def test_settings_read_joint_values_by_name(form):
    given = form(BY_NAME)
    for null_motion, by_place in (
        (sr.null_motions.Posture(q=given), sr.null_motions.Posture(q=Q)),
        (given, Q),
        (sr.null_motions.Rates(rates=given), Q),
    ):
        a, b = (sr.Controller(arm(), null_motion=motion) for motion in (null_motion, by_place))
        np.testing.assert_array_equal(a.step(np.zeros(4), TWIST).rates, b.step(np.zeros(4), TWIST).rates)
    scenario = sr.Scenario(arm=arm(), start=given, motion=sr.ConstantTwist(TWIST, duration=0.1))
    np.testing.assert_array_equal(scenario.start, Q)
    limits = form({name: abs(value) for name, value in BY_NAME.items()})
    np.testing.assert_array_equal(sr.Controller(arm(), velocity_limits=limits).velocity_limits[:, 1], abs(Q))
    np.testing.assert_array_equal(sr.Controller(arm(), acceleration_limits=limits).acceleration_limits, abs(Q))


def test_a_gradient_may_answer_by_name():
    a, b = (
        sr.Controller(arm(), null_motion=sr.null_motions.Gradient(gradient=lambda q, made=made: made))
        for made in (pd.Series(BY_NAME), Q)
    )
    np.testing.assert_array_equal(a.step(Q, TWIST).rates, b.step(Q, TWIST).rates)


TABLE = np.random.default_rng(3).uniform(-1, 1, (5, 4))
SHUFFLED = [NAMES.index(name) for name in ALPHABETICAL]
TABLES = {
    "frame": pd.DataFrame(TABLE[:, SHUFFLED], columns=ALPHABETICAL),
    "columns": {name: TABLE[:, NAMES.index(name)] for name in ALPHABETICAL},
    "data array": xr.DataArray(TABLE[:, SHUFFLED], dims=["time", "joint"], coords={"joint": list(ALPHABETICAL)}),
}


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_many_configurations_are_read_by_the_names_of_their_columns(table):
    np.testing.assert_array_equal(arm().forward(table), arm().forward(TABLE))
    bounds = sr.Bounds.symmetric(1.0, n=4)
    rates = sr.solve_batch(arm(), sr.LeastError(), table, TWIST, bounds, reference=table).rates
    np.testing.assert_array_equal(
        rates, sr.solve_batch(arm(), sr.LeastError(), TABLE, TWIST, bounds, reference=TABLE).rates
    )
    ends = [
        sr.rollout_batch(arm(), sr.LeastError(), rows, TWIST, bounds, period=0.01, steps=3).final_q
        for rows in (table, TABLE)
    ]
    np.testing.assert_array_equal(*ends)


def test_as_many_columns_as_rows_are_not_mixed_up():
    square = {name: TABLE[:4, NAMES.index(name)] for name in ALPHABETICAL}
    np.testing.assert_array_equal(arm().forward(square), arm().forward(TABLE[:4]))


def test_twists_are_read_by_the_names_of_their_rows():
    by_name = dict(zip(("wx", "wy", "wz", "vx", "vy", "vz"), np.roll(TWIST, 3), strict=True))
    a, b = (sr.Controller(arm()) for _ in range(2))
    for given in (by_name, pd.Series(by_name)):
        np.testing.assert_array_equal(a.step(Q, given).rates, b.step(Q, TWIST).rates)
        np.testing.assert_array_equal(sr.ConstantTwist(given).twist, TWIST)
    refused(lambda: a.step(Q, {**by_name, "vz": np.nan}), "twist", "nan")
    refused(lambda: a.step(Q, {"vx": 1.0}), "twist", "vy")


def test_integers_as_labels_are_indices_of_joints():
    np.testing.assert_array_equal(arm().forward(pd.Series(Q)), arm().forward(Q))
    np.testing.assert_array_equal(arm().forward(pd.Series(Q[::-1], index=[3, 2, 1, 0])), arm().forward(Q))
    np.testing.assert_array_equal(arm().forward({3: 0.4, 2: 0.9, 0: 0.2, 1: -0.5}), arm().forward(Q))
    refused(lambda: arm().forward(pd.Series(Q, index=[4, 3, 2, 1])), "q", "4")
    refused(lambda: arm().forward(pd.Series(Q, index=[True, 0, 2, 3])), "q", "True")


WRONG = {
    "missing": (dict.fromkeys(NAMES[:3], 0.0), "'wrist'"),
    "unknown": ({**BY_NAME, "gripper": 0.0}, "'gripper'"),
    "mistyped": ({**dict.fromkeys(NAMES[:3], 0.0), "wirst": 0.0}, "'wirst'"),
    "twice": (pd.Series([0.0] * 5, index=[*NAMES, "elbow"]), "twice"),
    "by name and index": ({**BY_NAME, 0: 0.0}, "twice"),
    "nan": ({**BY_NAME, "elbow": np.nan}, "nan"),
    "missing value": (pd.Series({**BY_NAME, "elbow": None}, dtype="Float64"), ""),
    "text": ({**BY_NAME, "elbow": "bent"}, "numbers"),
    "boolean": ({**BY_NAME, "elbow": True}, "numbers"),
    "empty": ({}, "shoulder_pan"),
    "columns of two lengths": ({**{name: np.zeros(3) for name in NAMES[:3]}, "wrist": np.zeros(2)}, "length"),
    "no name": ({**BY_NAME, None: 0.0}, "None"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_labels_that_are_not_the_joints_are_refused_and_named(kind):
    given, word = WRONG[kind]
    ctl = sr.Controller(arm())
    for call, argument in (
        (lambda: arm().forward(given), "q"),
        (lambda: ctl.step(given, TWIST), "q"),
        (lambda: ctl.track(given, np.eye(4)), "q"),
        (lambda: sr.Scenario(arm=arm(), start=given, motion=sr.ConstantTwist(TWIST, duration=0.1)), "start"),
    ):
        refused(call, argument, word)
    assert not ctl.last_rates.any()


def test_where_entries_have_no_names_labels_are_refused_and_counting_ones_are_not():
    labelled = pd.Series([1.0] * 4, index=NAMES)
    refused(lambda: sr.Bounds(-labelled, labelled), "lower", "without labels")
    refused(lambda: sr.Weights(joints=labelled), "joints", "without labels")
    np.testing.assert_array_equal(sr.Bounds(pd.Series([-1.0] * 4), pd.Series([1.0] * 4)).upper, np.ones(4))


def test_names_of_followers_may_come_along_and_are_not_read():
    leader = sr.Joint(name="finger")
    follower = sr.Follower(sr.Joint(name="mimic"), leader="finger", place=1, multiplier=2.0)
    hand = sr.Arm([leader], followers=[follower])
    np.testing.assert_array_equal(hand.forward({"mimic": 0.6, "finger": 0.3}), hand.forward([0.3]))
    np.testing.assert_array_equal(
        sr.Controller(hand).step({"mimic": 0.6, "finger": 0.3}, TWIST).rates,
        sr.Controller(hand).step([0.3], TWIST).rates,
    )
