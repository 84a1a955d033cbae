"""What every law promises, whatever the arm, the fault and the limit."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.kinematics import INCH
from oracles.price import EPS, typical_rate
from stillreach import Status, Weights
from stillreach.laws import LAWS as ALL_LAWS
from tests.conformance.registry import LAWS, SUBJECTS
from tests.conformance.scenes import Broken, scenes

EVERY_LAW = pytest.mark.parametrize("law", LAWS)
EVERY_ARM = pytest.mark.parametrize("arm", SUBJECTS)
EVERY_SPATIAL_ARM = pytest.mark.parametrize("arm", [arm for arm in SUBJECTS if len(SUBJECTS[arm].rows) == 6])
EVERY_OPTIMUM = pytest.mark.parametrize("law", [law for law in LAWS if LAWS[law].optimal])

CLOSE, ROUNDED = 1e-9, 1e-12
"""How far rates may move, relative to the largest, where numbers are only rounded differently: well conditioned, and
times the condition number of the working joints' Jacobian."""


LEAST_PRICE = 8.0
"""Of the laws in the registry."""


def test_every_law_is_in_the_registry():
    promised = {(type(contract.make()), contract.bounded) for contract in LAWS.values()}
    assert promised == {(law, law.keeps_bounds) for law in ALL_LAWS}


@pytest.fixture
def broken():
    return Broken()


def closeness(scene):
    """Largest relative change of the rates that rounding explains."""
    return max(CLOSE, ROUNDED / np.min(scene.ratios[scene.ratios > 1e-12], initial=1.0))


def same(scene, contract, one, other, joint=1.0, error=1.0):
    """Two answers to one question: equal rates; where the law may jump with rounding, at least an equal error.

    The other's rates are `joint` times as large, its error `error` times.
    """
    gap = np.max(np.abs(one.rates - other.rates / joint))
    if gap <= closeness(scene) * scene.size(one.rates):
        return True
    if one.status & Status.CLIPPED:  # the other joints' rates are rounded as those that were clipped were
        unclipped = scene.without_limits().ask(contract.make()).rates
        if gap <= CLOSE * scene.size(unclipped):
            return True
    reach = np.linalg.norm(scene.twist) + np.linalg.norm(scene.j, axis=0) @ np.abs(one.rates)
    return not contract.continuous and abs(one.task_error - other.task_error / error) <= 1e-9 * reach


def rounded_damping(scene, rates):
    """The damping that rounding of the error makes: the error over a price, which counts in bounds, be they tiny."""
    reach = np.linalg.norm(scene.twist) + np.linalg.norm(scene.j, axis=0) @ np.abs(rates)
    typical = typical_rate(scene.lower, scene.upper)
    return EPS * reach / (LEAST_PRICE * typical) if typical > 0.0 else 0.0


@EVERY_LAW
@EVERY_ARM
def test_rates_are_finite_inside_the_bounds_and_failed_joints_keep_theirs(law, arm, broken):
    contract = LAWS[law]
    for scene in scenes(arm):
        rates = scene.ask(contract.make()).rates
        broken.unless(np.all(np.isfinite(rates)), scene)
        broken.unless(np.array_equal(rates[scene.fixed], scene.lower[scene.fixed]), scene)
        if contract.bounded:
            broken.unless(np.all((scene.lower <= rates) & (rates <= scene.upper)), scene)
    broken.settle(len(scenes(arm)))


@EVERY_LAW
@EVERY_ARM
def test_an_answer_checks_its_own_promises(law, arm, broken):
    contract = LAWS[law]
    for scene in scenes(arm):
        answer = scene.ask(contract.make())
        found = answer.check()
        broken.unless(found.finite and found.fixed and found.residual, scene, found.residual_error)
        broken.unless(found.inside or (not contract.bounded and Status.OVER_LIMIT in answer.status), scene)
    broken.settle(len(scenes(arm)))


@EVERY_LAW
@EVERY_ARM
def test_twist_and_bounds_times_a_number_give_the_rates_times_it(law, arm, broken):
    contract = LAWS[law]
    for i, scene in enumerate(scenes(arm)):
        s = (2.0**-40, 7.0, 2.0**30, 1e-3)[(i + i // 4) % 4] if scene.has_clear_rank() else 0.5
        one, other = scene.ask(contract.make()), scene.times(s).ask(contract.make())
        gap, exact = np.max(np.abs(other.rates / s - one.rates)), np.log2(s).is_integer()
        fine = gap <= 1e-15 * scene.size(one.rates) if exact else same(scene, contract, one, other, s, s)
        broken.unless(fine, scene, s, gap)
        kappa, other_kappa = one.damping, other.damping
        tolerance = 0.0 if exact else 1e-9 * max(kappa, 1e-6) + rounded_damping(scene, one.rates)
        broken.unless(abs(other_kappa - kappa) <= tolerance, scene, s, kappa, other_kappa)
        tolerance = 1e-15 if exact else 1e-9
        broken.unless(abs(other.scale - one.scale) <= tolerance, scene, s, one.scale, other.scale)
    broken.settle(len(scenes(arm)))


@EVERY_LAW
@EVERY_SPATIAL_ARM
def test_turning_the_base_leaves_the_rates(law, arm, broken):
    contract = LAWS[law]
    asked = [scene for scene in scenes(arm) if scene.has_clear_rank()]
    if contract.of_vectors:
        asked = [scene for scene in asked if scene.has_distinct_singular_values()]
    R, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    turn = np.kron(np.eye(2), R * np.linalg.det(R))
    for scene in asked:
        turned = replace(scene, j=turn @ scene.j, twist=turn @ scene.twist)
        one, other = scene.ask(contract.make()), turned.ask(contract.make())
        broken.unless(same(scene, contract, one, other), scene, one.task_error, other.task_error)
    broken.settle(len(asked))


@EVERY_LAW
@EVERY_ARM
def test_inches_with_matching_weights_leave_the_rates(law, arm, broken):
    contract = LAWS[law]
    asked = [scene for scene in scenes(arm) if scene.has_clear_rank()]
    in_inches = contract.make(weights=Weights(length=1.0 / INCH))
    for scene in asked:
        row = np.where(np.array(list(scene.rows)) == "v", 1.0 / INCH, 1.0)
        joint = np.where(np.array(list(scene.joints)) == "P", 1.0 / INCH, 1.0)
        j, twist = row[:, None] * scene.j / joint, row * scene.twist
        bounds = {"lower": joint * scene.lower, "upper": joint * scene.upper, "limits": joint * scene.counted_limits}
        other = replace(scene, j=j, twist=twist, length=scene.length / INCH, **bounds).ask(in_inches)
        one = scene.ask(contract.make())
        broken.unless(same(scene, contract, one, other, joint), scene, one.task_error, other.task_error)
    broken.settle(len(asked))


@EVERY_LAW
@EVERY_ARM
def test_a_warm_start_changes_no_answer(law, arm, broken):
    contract, rng = LAWS[law], np.random.default_rng(11)
    asked = [scene for scene in scenes(arm) if scene.has_clear_rank()]
    for scene in asked:
        before = replace(scene, twist=rng.normal(size=len(scene.twist)) * 5.0).ask(contract.make())
        cold = scene.ask(contract.make())
        for start in (before.active, rng.integers(-1, 2, len(scene.lower)).astype(np.int8)):
            warm = scene.ask(contract.make(), start=start)
            gap = np.max(np.abs(warm.rates - cold.rates), initial=0.0)
            fine = gap <= closeness(scene) * scene.size(cold.rates)
            broken.unless(fine, scene, gap, warm.task_error, cold.task_error, warm.scale, cold.scale)
    broken.settle(2 * len(asked))


@EVERY_OPTIMUM
@EVERY_ARM
def test_more_room_never_makes_it_worse(law, arm, broken):
    contract, rng = LAWS[law], np.random.default_rng(12)
    count = 0
    for scene in scenes(arm):
        if not scene.has_clear_rank(1e-11, 1e-9 if contract.optimal == "error" else 1e-6):
            continue
        room = 10.0 ** rng.uniform(-3, 1, (2, len(scene.lower))) * ~scene.fixed
        wide = replace(scene, lower=scene.lower - room[0], upper=scene.upper + room[1])
        tight, loose = scene.ask(contract.make()), wide.ask(contract.make())
        if contract.optimal == "scale":
            fine = loose.scale >= tight.scale - 1e-12
        elif tight.damping > 0.0 or loose.damping > 0.0:
            continue
        else:
            lost = np.max(scene.ratios[scene.ratios <= 1e-11], initial=0.0)  # what the rank tolerance leaves undone
            size = np.linalg.norm(scene.twist) + np.linalg.norm(scene.j, axis=0) @ np.abs(tight.rates)
            rounding = (1e-14 + lost) * size
            fine = loose.task_error <= tight.task_error * (1 + 1e-12) + rounding
        count += 1
        broken.unless(fine, scene, tight.task_error, loose.task_error, tight.scale, loose.scale)
    broken.settle(count)
