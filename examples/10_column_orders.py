"""One Jacobian, 5,040 arms: which stays able to reach after a joint locks? Needs: pip install 'stillreach[plot]'

The columns of an arm's Jacobian at one configuration can be put in any order, each the axis of a joint. All these arms
have the same singular values there and lose the same with each joint: here as little as 7 joints allow, every relative
manipulability 1/sqrt(7). Farther away they differ (Xie and Maciejewski, 2017; Bader and Maciejewski, 2020): counted are
positions, with that attitude, reached within 45 deg, and with each joint locked at either end or in the middle of that.
python examples/10_column_orders.py [FOLDER] [NUMBER OF ORDERS]
"""

import itertools
import sys
import time
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.patches import Patch

import stillreach as sr

LIMIT, RADIUS = np.deg2rad(45.0), 2.0  # [rad] before the failure; [m] of the ball of positions around the tool
COARSE, MEDIUM, FINE = 0.65, 0.4, 0.05  # [m] between positions: for all orders, the best ones, the pictures


def revolute(J):
    """The nearest columns (v, w) that belong to revolute joints: w of length 1, and v across it."""
    w = J[3:] / np.linalg.norm(J[3:], axis=0)
    return np.vstack([J[:3] - w * np.sum(J[:3] * w, axis=0), w])


def best_jacobian(seed=4):
    """(6, 7) whose null vector has equal entries, by alternating projections; singular values as equal as they get."""
    rows = np.linalg.svd(np.ones((1, 7)))[2][1:] * np.sqrt(7 / 3)  # across the vector of ones
    J = revolute(np.random.default_rng(seed).normal(size=(6, 7)))
    for _ in range(2000):
        U, _, V = np.linalg.svd(J @ rows.T)
        J = revolute(U @ V @ rows)
    while np.abs(J.sum(axis=1)).max() > 1e-14:
        J = revolute(J - J.mean(axis=1, keepdims=True))
    return J


def poses_at(positions):
    poses = np.tile(np.eye(4), (len(positions), 1, 1))
    poses[:, :3, 3] = positions
    return poses


def arm_of(J):
    """The arm with these columns at zero, its tool at the origin; a joint turns about a line along w, through w x v."""
    v, w = J[:3].T, J[3:].T
    moves = poses_at(np.diff(np.vstack([np.zeros(3), np.cross(w, v), np.zeros(3)]), axis=0))
    return sr.Arm([sr.Joint(placement=T, axis=axis) for T, axis in zip(moves, w, strict=False)], tool=moves[7])


def grid(step, axes=3):
    """Poses with the attitude of zero, `step` apart in the ball, or in its slice z = 0."""
    ticks = step * np.arange(-round(RADIUS / step), round(RADIUS / step) + 1)
    at = np.stack(np.meshgrid(ticks, ticks, ticks if axes == 3 else [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    return poses_at(at[np.linalg.norm(at, axis=1) <= RADIUS])


def workspace(order, poses, **options):
    return sr.tolerance.workspace(arm_of(J[:, order]), poses, np.tile([-LIMIT, LIMIT], (7, 1)), **options)


J = best_jacobian()
local = sr.tolerance.report(arm_of(J), np.zeros(7), k=1).relative[0]
print(f"every relative manipulability {local.min():.4f} to {local.max():.4f}, condition number {np.linalg.cond(J):.3f}")

# The reverse of an order has the same workspace, mirrored.
orders = [list(order) for order in itertools.permutations(range(7)) if order[0] < order[-1]]
orders = orders[:: max(1, len(orders) // int(sys.argv[2]))] if len(sys.argv) > 2 else orders
poses, began = grid(COARSE), time.perf_counter()
shares = np.array([workspace(order, poses, angles=3, starts=30).share for order in orders])
print(f"{2 * len(orders)} orders in {time.perf_counter() - began:.0f} s, at {len(poses)} positions {COARSE} m apart:")
print(f"tolerant {shares.min():.0%} to {shares.max():.0%}, median {np.median(shares):.0%}")
poses, began, ranked = grid(MEDIUM), time.perf_counter(), np.argsort(-shares)
again = np.array([workspace(orders[k], poses, angles=5, starts=30).share for k in ranked[:40]])
print(f"the best {len(again)} again in {time.perf_counter() - began:.0f} s, at {len(poses)} positions:")
for place in np.argsort(-again)[:5]:
    print(f"  columns {' '.join(str(i + 1) for i in orders[ranked[place]])}: {again[place]:.1%}")

figure, axes = plt.subplots(1, 4, figsize=(16, 4.6), layout="constrained")
axes[0].hist(100 * shares, bins=np.arange(0, 101, 4), color="#1b4f8a", weights=np.full(len(shares), 2))
axes[0].set(xlabel="positions that stay reachable [%]", ylabel="arms", title=f"{2 * len(orders)} orders of 7 columns")
colours = np.array(["#dfe3e8", "#f0963c", "#1b4f8a"])
chosen = {"best": again.argmax(), "median": len(ranked) // 2, "worst": -1}
for place, (word, at) in zip(axes[1:], chosen.items(), strict=True):
    found = workspace(order := orders[ranked[at]], grid(FINE, axes=2), angles=5, starts=60)
    shown = colours[np.where(found.tolerant, 2, np.where(found.before, 1, 0))]
    place.scatter(*found.poses[:, :2, 3].T, c=shown, marker="s", s=11, linewidths=0)
    place.set(xlabel="x [m]", ylabel="y [m]", title=f"{word}: columns {np.array(order) + 1}, z = 0", aspect="equal")
named = zip(colours, ("not reached", "reached until a joint locks", "reached whichever joint locks"), strict=True)
figure.legend(handles=[Patch(color=c, label=name) for c, name in named], loc="outside lower center", ncols=3)
out = Path(sys.argv[1] if len(sys.argv) > 1 else ".") / "column-orders.png"
out.parent.mkdir(parents=True, exist_ok=True)
figure.savefig(out, dpi=110)
print(f"open {out}")
