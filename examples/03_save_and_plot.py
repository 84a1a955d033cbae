"""Save a run, load it again, plot it. Needs: pip install 'stillreach[netcdf,plot]'"""

import sys
from pathlib import Path

import numpy as np

import stillreach as sr

out = Path(sys.argv[1] if len(sys.argv) > 1 else ".")


def circle(t):
    """A twist that leads the tool once around in 8 s."""
    turn = 2 * np.pi * t / 8.0
    return [0.0, 0.15 * np.cos(turn), 0.15 * np.sin(turn), 0.0, 0.0, 0.0]


run = sr.simulate(
    sr.Scenario(
        arm=sr.arms.nasa_modular(),
        start=np.deg2rad([0, -50, 0, -30, 0, 70, 0, 30, 0, 0, 0]),
        motion=circle,
        faults=[sr.Fault("j4", at=2.0), sr.Fault("j8", at=4.0, kind=sr.Derated(0.05))],
        duration=8.0,
        name="once around, j4 locked at 2 s, j8 weak from 4 s on",
    )
)
run.save(out / "circle.nc")
again = sr.Run.load(out / "circle.nc")
print(again)
print("largest task error:", again.task_error.max())
print(again.to_xarray()["rates"].sel(joint="j8").attrs)
again.plot().savefig(out / "circle.png")
print(f"saved {out / 'circle.nc'} and {out / 'circle.png'}")
