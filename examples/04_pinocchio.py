"""Pinocchio gives pose and Jacobian, a law the rates; a joint locks on the way. Needs: pip install stillreach pin"""

import numpy as np
import pinocchio as pin

import stillreach as sr

ours = sr.arms.panda()
model = pin.buildModelFromXML(ours.to_urdf())  # any URDF will do
data = model.createData()
tool = model.getFrameId("tool")

PERIOD, SECONDS, GAIN = 0.01, 4.0, 5.0  # [s], [s], [1/s]
START = np.array([0.0, -0.5, 0.2, -2.0, 0.1, 1.7, 0.6])
VELOCITY = np.array([0.05, 0.04, -0.05])  # [m/s] of the tool, whose attitude is to stay
LOCKED, ONSET = 2, 1.0  # the third joint, [s]


def see(q):
    """Pose of the tool and its Jacobian, rows [v; w] along the base's axes, one column for each velocity."""
    J = pin.computeFrameJacobian(model, data, q, tool, pin.LOCAL_WORLD_ALIGNED)
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[tool], J


def follow_line(choose_rates):
    """Joint values at the end, and how far the tool was from where it should be, at most [m]."""
    q, (start, _) = START, see(START)
    begin, attitude, farthest = start.translation.copy(), start.rotation.copy(), 0.0
    for tick in range(round(SECONDS / PERIOD)):
        pose, J = see(q)
        off = begin + VELOCITY * tick * PERIOD - pose.translation
        turn = pin.log3(attitude @ pose.rotation.T)  # along the base's axes, as the twist is
        broken = [LOCKED] if tick * PERIOD >= ONSET else []
        rates = choose_rates(J, np.concatenate([VELOCITY + GAIN * off, GAIN * turn]), broken)
        rates[broken] = 0.0  # a locked joint stands still, whatever was computed
        q = pin.integrate(model, q, rates * PERIOD)
        farthest = max(farthest, np.linalg.norm(off))
    return q, farthest


def unaware(J, twist, broken):
    """What is done without knowing of the fault."""
    return np.linalg.pinv(J) @ twist


law, bounds = sr.LeastError(), sr.Bounds.symmetric(model.velocityLimit, n=model.nv)
with_law = lambda J, twist, broken: law.solve(J, twist, bounds.lock(broken)).rates.copy()  # noqa: E731

q, error = follow_line(with_law)
_, error_unaware = follow_line(unaware)
difference = max(np.abs(see(q)[1] - ours.jacobian(q)).max(), np.abs(see(q)[0].homogeneous - ours.forward(q)).max())
print(f"joint {ours.joint_names[LOCKED]} locks after {ONSET:g} s of {SECONDS:g} s")
print(f"tool off its line: {1e3 * error:.2f} mm with the law, {1e3 * error_unaware:.2f} mm without")
print(f"pose and Jacobian at the end, Pinocchio's and ours: {difference:.0e} apart")
assert error < 1e-3 < error_unaware
assert difference < 1e-12
