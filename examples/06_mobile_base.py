"""A base on two wheels carries an arm: wheels are joints, too, and one gets weak. Needs: pip install stillreach pin"""

import numpy as np
import pinocchio as pin

import stillreach as sr

RADIUS, TRACK = 0.1, 0.5  # [m] of the wheels, and between them
arm = sr.Arm.from_modules("RPRPRP", lengths=[0.4, 0.35, 0.35, 0.15]).with_limits(velocity=1.0, position=(-3.0, 3.0))
# A planar root has 3 velocities (forward, sideways, turn) in the base's own axes, and 4 numbers for its position.
model = pin.buildModelFromXML(arm.to_urdf(), pin.JointModelPlanar())
data = model.createData()
tool = model.getFrameId("tool")

# What the wheels' rates [rad/s] make of the base: forward r (l + r) / 2, sideways nothing, turn r (r - l) / track.
WHEELS = np.array([[RADIUS / 2, RADIUS / 2], [0.0, 0.0], [-RADIUS / TRACK, RADIUS / TRACK]])
MOTION = np.zeros((model.nv, 2 + arm.n))  # the model's velocities from the rates that drives command: wheels, then arm
MOTION[:3, :2] = WHEELS
MOTION[3:, 2:] = np.eye(arm.n)

NAMES = ("left wheel", "right wheel", *arm.joint_names)
LIMITS = sr.Bounds.symmetric([6.0, 6.0, *arm.velocity_limits], n=len(NAMES))
WEAK = np.array([1.0, 0.05, *np.ones(arm.n)])
FAULTS = {
    "nothing is broken": LIMITS,
    "the right wheel has 5 % of its rate": sr.Bounds(WEAK * LIMITS.lower, WEAK * LIMITS.upper),
    "j4 is locked": LIMITS.lock([5]),
    "both wheels are locked": LIMITS.lock([0, 1]),
}
PERIOD, SECONDS, GAIN = 0.02, 10.0, 3.0  # [s], [s], [1/s]
VELOCITY = np.array([0.15, 0.04, 0.0])  # [m/s] of the tool along the world's axes; its attitude is free
# Wheels are cheap: ten of their radians count as much as one of the arm's.
law = sr.LeastError(weights=sr.Weights(joints=[0.01, 0.01, *np.ones(arm.n)]))


def see(q):
    """The tool's position and the Jacobian from the drives' rates, rows v along the world's axes."""
    J = pin.computeFrameJacobian(model, data, q, tool, pin.LOCAL_WORLD_ALIGNED)
    pin.framesForwardKinematics(model, data, q)
    return data.oMf[tool].translation.copy(), J[:3] @ MOTION


def drive(bounds):
    """Distance from the line at the end [m], the largest use of each drive, and the last configuration."""
    q = pin.neutral(model)
    q[4:] = [0.0, 0.6, 0.0, 0.9, 0.0, 0.4]  # behind x, y, cos and sin of the base
    (begin, _), most = see(q), np.zeros(len(NAMES))
    for tick in range(round(SECONDS / PERIOD)):
        place, J = see(q)
        twist = VELOCITY + GAIN * (begin + VELOCITY * tick * PERIOD - place)
        rates = law.solve(J, twist, bounds).rates
        assert np.all((bounds.lower <= rates) & (rates <= bounds.upper))
        q = pin.integrate(model, q, MOTION @ rates * PERIOD)
        most = np.maximum(most, np.abs(rates))
    return np.linalg.norm(begin + VELOCITY * SECONDS - see(q)[0]), most, q


for fault, bounds in FAULTS.items():
    off, most, q = drive(bounds)
    wheels = f"wheels up to {most[0]:.2f} and {most[1]:.2f} rad/s, base {np.hypot(*q[:2]):.2f} m from its start"
    print(f"{fault}: {100 * off:.2f} cm beside the line; {wheels}")
    assert off < 2e-3 or fault == "both wheels are locked"

rates, step = np.random.default_rng(1).uniform(-1.0, 1.0, len(NAMES)), 1e-6
there, J = see(q)
moved = (see(pin.integrate(model, q, MOTION @ rates * step))[0] - there) / step
print(f"the Jacobian against a difference of Pinocchio's positions: {np.abs(moved - J @ rates).max():.0e} m/s")
assert np.abs(moved - J @ rates).max() < 1e-5
