"""Which two joints can the paper's arm lose on its line? All 55 pairs at once, each a simulation of its own."""

from itertools import combinations

import numpy as np

import stillreach as sr

arm = sr.arms.nasa_modular()
start = np.deg2rad([45, -60, 0, -45, 0, 45, 90, 45, 0, 0, 0])
twist = np.array([-0.14, -0.06, 0.04, 0, 0, 0])  # [m/s, rad/s] of the tool: a line, the attitude held
PERIOD, SECONDS, RATE = 0.01, 10.0, np.deg2rad(15)  # [s], [s], [rad/s] what a joint may do
STEPS = round(SECONDS / PERIOD)

pairs = list(combinations(range(arm.n), 2))
upper = np.full((len(pairs), arm.n), RATE)
for row, pair in enumerate(pairs):
    upper[row, pair] = 0.0  # locked
run = sr.rollout_batch(
    arm,
    sr.LeastError(),
    np.tile(start, (len(pairs), 1)),
    twist,
    (-upper, upper),
    period=PERIOD,
    steps=STEPS,
    integrator="rk4",
)
kept = run.worst_error < 1e-6  # of the twist, in m/s and rad/s, all the way
ends = arm.forward(run.final_q)[:, :3, 3]
off = 1000 * np.linalg.norm(ends - arm.forward(start)[:3, 3] - twist[:3] * SECONDS, axis=1)  # [mm]

print(
    f"{len(pairs)} pairs, {len(pairs) * STEPS:,} steps: the tool keeps up without {np.count_nonzero(kept)} of them (-)."
)
print("Without the others it ends so many millimetres from where it should be:")
print("     " + "".join(f"{name:>6}" for name in arm.joint_names[1:]))
for j in range(arm.n - 1):
    cells = [""] * j + ["-" if kept[row] else f"{off[row]:.1f}" for row, pair in enumerate(pairs) if pair[0] == j]
    print(f"{arm.joint_names[j]:>5}" + "".join(f"{cell:>6}" for cell in cells))
assert off[kept].max() < 0.1
