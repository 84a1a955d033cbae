"""Which joints can a Panda lose while it picks and places? Needs: pip install 'stillreach[page,plot]'

Makes a recording, joint positions over time as a robot logs them, rehearses every failure on it, and writes a page.
"""

import sys
from pathlib import Path

import numpy as np

import stillreach as sr

out = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
out.mkdir(parents=True, exist_ok=True)

arm = sr.arms.panda()
start = np.deg2rad([-20, -20, -10, -110, 0, 95, 45])
down, up, over = [0, 0, -0.18], [0, 0, 0.02], [0.05, 0.42, 0]
stops = [down, up, over, [0.05, 0.42, -0.18], over, [0, 0, 0]]
times = 1.5 * np.arange(1, len(stops) + 1)
work = sr.Waypoints(stops, times=times, profile="minimum-jerk", relative=True)
healthy = sr.simulate(sr.Scenario(arm=arm, start=start, motion=work, loop="closed"))
names = ",".join(["time", *(f"{joint} [rad]" for joint in arm.joint_names)])
table = np.column_stack([healthy.time, healthy.q])
np.savetxt(out / "pick-and-place.csv", table, delimiter=",", header=names, comments="", fmt="%.9f")

recording = sr.Recording.load(out / "pick-and-place.csv", arm=arm)
rehearsal = sr.tolerance.rehearse(
    recording,
    kinds=["locked", "confined", "derated"],
    known_after=0.04,  # the controller learns of a failure 40 ms later
    allowed_distance=0.005,
    allowed_angle=np.deg2rad(1),
)
print(rehearsal)
rehearsal.plot().savefig(out / "rehearsal.png", dpi=110)
rehearsal.page(out / "rehearsal.html", f"--recording {out / 'pick-and-place.csv'} --robot panda")
print(f"\nopen {out / 'rehearsal.html'}")
