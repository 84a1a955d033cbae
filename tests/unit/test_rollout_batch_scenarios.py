"""rollout_batch goes where a Controller goes that does the same, and where a simulated Scenario does."""

import numpy as np
import pytest

import stillreach as sr

ARM = sr.arms.nasa_modular()
LIMITED = ARM.with_limits(position=(-1.2, 1.2), acceleration=3.0)
ARMS = {
    "free": ARM,
    "position": ARM.with_limits(position=(-1.2, 1.2)),
    "acceleration": ARM.with_limits(acceleration=3.0),
    "both": LIMITED,
}
RATE, PERIOD, STEPS, ROWS = 0.8, 0.01, 80, 6
LAWS = (sr.LeastError(price=None), sr.KeepDirection(), sr.SingularityRobust(damping="exact"))
"""Their answers do not depend on the bounds that were active a tick ago, and hardly on rounding."""


def rows(seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(-1, 1, (ROWS, 11)), rng.normal(size=(ROWS, 6)) * 0.15, rng.integers(0, 11, ROWS)


def bounds_of(faults):
    """What a controller makes of rate limits and faults: row i's is (joint, kind)."""
    upper = np.full((len(faults), 11), RATE)
    lower = -upper
    for row, (joint, kind) in enumerate(faults):
        if isinstance(kind, sr.Derated):
            lower[row, joint], upper[row, joint] = -kind.fraction * RATE, kind.fraction * RATE
        elif kind is not None:
            lower[row, joint] = upper[row, joint] = kind.rate if isinstance(kind, sr.Runaway) else 0.0
    return lower, upper


KINDS = (sr.Locked(), sr.Derated(0.25), sr.Runaway(0.05), None, sr.Locked(), sr.Derated(0.0))


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_controllers_go_there(arm, law):
    """Joints locked, derated and running away; tick by tick, each controller in its own loop."""
    q, twist, joints = rows()
    faults = list(zip(joints, KINDS, strict=True))
    run = sr.rollout_batch(
        arm, law, q, twist, bounds_of(faults), period=PERIOD, steps=STEPS, record=("q", "rates", "task_error", "status")
    )
    for row, (joint, kind) in enumerate(faults):
        controller = sr.Controller(arm, law=law, period=PERIOD, velocity_limits=RATE, transition_rate=0.0)
        if kind is not None:
            controller.fail(int(joint), kind)
        at = q[row].copy()
        for tick in range(STEPS):
            answer = controller.step(at, twist[row])
            assert np.allclose(run.q[row, tick], at, rtol=0, atol=1e-9), (row, tick)
            assert np.allclose(run.rates[row, tick], answer.rates, rtol=0, atol=1e-6), (row, tick)
            assert abs(run.task_error[row, tick] - answer.task_error) < 1e-8
            at = at + PERIOD * answer.rates


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_simulations_go_there(arm, law, integrator):
    """A fault from the beginning, and the joints of all ticks."""
    q, twist, joints = rows(1)
    bounds = bounds_of([(joint, sr.Locked()) for joint in joints])
    batch = sr.rollout_batch(
        arm,
        law,
        q,
        twist,
        bounds,
        period=PERIOD,
        steps=STEPS,
        integrator=integrator,
        record=("q", "rates", "task_error"),
    )
    for row in range(ROWS):
        run = sr.simulate(
            sr.Scenario(
                arm=arm,
                start=q[row],
                motion=[sr.ConstantTwist(twist[row], duration=PERIOD * STEPS)],
                faults=[sr.Fault(f"j{joints[row] + 1}", at=0.0)],
                law=law,
                period=PERIOD,
                integrator=integrator,
                velocity_limits=RATE,
                transition_rate=0.0,
            )
        )
        assert np.allclose(batch.q[row], run.q[:-1], rtol=0, atol=1e-9)
        assert np.allclose(batch.final_q[row], run.q[-1], rtol=0, atol=1e-9)
        assert np.allclose(batch.rates[row], run.rates[:-1], rtol=0, atol=1e-6)
        assert abs(batch.worst_error[row] - run.task_error[:-1].max()) < 1e-8


def test_a_fault_on_the_way_is_two_rollouts():
    """A command that changes, and a joint that locks after 0.3 s while it moves within acceleration limits."""
    law, onset = LAWS[0], 30
    q, twist, joints = rows(2)
    twists = np.repeat(np.stack([twist, -twist[:, ::-1]], axis=1), STEPS // 2, axis=1)
    given = {"period": PERIOD, "record": "q"}
    before = sr.rollout_batch(LIMITED, law, q, twists[:, :onset], (-RATE, RATE), steps=onset, **given)
    after = sr.rollout_batch(
        LIMITED,
        law,
        before.final_q,
        twists[:, onset:],
        bounds_of([(joint, sr.Locked()) for joint in joints]),
        last_rates=before.final_rates,
        steps=STEPS - onset,
        **given,
    )
    for row in range(ROWS):
        parts = [sr.ConstantTwist(twists[row, k], duration=PERIOD * STEPS / 2) for k in (0, -1)]
        run = sr.simulate(
            sr.Scenario(
                arm=LIMITED,
                start=q[row],
                motion=parts,
                faults=[sr.Fault(f"j{joints[row] + 1}", at=PERIOD * onset)],
                law=law,
                period=PERIOD,
                velocity_limits=RATE,
                transition_rate=0.0,
            )
        )
        assert np.allclose(np.concatenate([before.q[row], after.q[row]]), run.q[:-1], rtol=0, atol=1e-9)
        assert np.allclose(after.final_q[row], run.q[-1], rtol=0, atol=1e-9)
