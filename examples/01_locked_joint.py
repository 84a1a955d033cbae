"""Three joints of the paper's arm lock while it works; the tool goes on along its line."""

import numpy as np

import stillreach as sr

arm = sr.arms.nasa_modular()
start = np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 0, 0])
scenario = sr.Scenario(
    arm=arm,
    start=start,
    motion=[sr.ConstantTwist([-0.14, -0.06, 0.04, 0, 0, 0], duration=10.0)],  # [m/s, rad/s]
    faults=[sr.Fault("j1", at=3.0), sr.Fault("j6", at=5.0), sr.Fault("j7", at=5.0, until=8.0)],
    loop="closed",  # feedback on the pose
    period=0.01,
)
run = sr.simulate(scenario)

moved = run.pose[-1, :3, 3] - run.pose[0, :3, 3]
turned = np.linalg.norm(run.pose[-1, :3, :3] - run.pose[0, :3, :3])
print(run)
print(f"the tool moved by {np.round(moved, 4)} m, commanded were [-1.4 -0.6 0.4]")
print(f"its attitude changed by {np.rad2deg(turned / np.sqrt(2)):.3f} deg")
for time in (2.0, 4.0, 6.0, 9.0):
    tick = round(time / scenario.period)
    failed = [name for name, state in zip(run.joint_names, run.health[tick], strict=True) if state]
    print(f"t = {time:g} s: locked {failed or 'none'}, largest rate {np.rad2deg(abs(run.rates[tick]).max()):.1f} deg/s")
