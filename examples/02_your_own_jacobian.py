"""A law on its own: the best joint rates for a Jacobian that comes from anywhere."""

import numpy as np

import stillreach as sr

# a planar arm of four unit links at these relative angles; rows: vx, vy [m/s]
heading = np.cumsum(np.deg2rad([20.0, 50.0, -30.0, 40.0]))
links = np.stack([np.cos(heading), np.sin(heading)])
from_joint = np.cumsum(links[:, ::-1], axis=1)[:, ::-1]  # the tool seen from each joint
J = np.stack([-from_joint[1], from_joint[0]])
twist = np.array([1.8, 2.4])
bounds = sr.Bounds.symmetric([0.5, 0.5, 1.0, 1.0], n=4)

laws = [sr.Pseudoinverse(), sr.SingularityRobust(damping="exact"), sr.KeepDirection(), sr.LeastError(price=None)]
for broken in ([], [2]):
    print(f"joint {broken[0]} locked" if broken else "all joints work")
    for law in laws:
        out = law.solve(J, twist, bounds.lock(broken), row_kinds="vv")
        left = np.linalg.norm(out.residual)
        print(f"  {type(law).__name__:17} rates {np.round(out.rates, 3)}, error {left:.4f} m/s, {out.status!r}")
