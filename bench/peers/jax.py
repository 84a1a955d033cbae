"""JAX: kinematics and a damped solve written by hand for one row, `vmap` over all, compiled by `jit`; float64.

The solve is written out too, so that XLA makes it part of the vectorised loop; its own calls LAPACK row by row.
"""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from bench.peers.base import Robot

DAMPING = 1e-12
jax.config.update("jax_enable_x64", True)


class Peer:
    packages = ("jax", "jaxlib")

    def __init__(self, robot: Robot) -> None:
        self.working, self.n = robot.working, robot.n
        self.one_jacobian = jax.jit(partial(jacobian, robot.placements, robot.axes, robot.tool))
        self.all_rates = jax.jit(jax.vmap(partial(rates, robot)))

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        return np.asarray(self.one_jacobian(q[self.working]))

    def solve(self, q: np.ndarray, twist: np.ndarray) -> np.ndarray:
        return np.asarray(self.all_rates(q, twist))


def jacobian(placements: np.ndarray, axes: np.ndarray, tool: np.ndarray, q: jax.Array) -> jax.Array:
    """(6, k) of one row, q (k,) of the joints that work."""
    R, p, origins, directions = jnp.eye(3), jnp.zeros(3), [], []
    for T, axis, angle in zip(placements, axes, q, strict=True):
        p, R = p + R @ T[:3, 3], R @ T[:3, :3]
        origins.append(p)
        directions.append(R @ axis)
        K = np.cross(np.eye(3), axis)
        R = R @ (jnp.eye(3) + jnp.sin(angle) * K + (1.0 - jnp.cos(angle)) * (K @ K))
    end, z = p + R @ tool[:3, 3], jnp.stack(directions)
    return jnp.concatenate([jnp.cross(z, end - jnp.stack(origins)), z], axis=1).T


def solve(G: jax.Array, b: jax.Array) -> list[jax.Array]:
    """G x = b by G = L D Lᵀ, element by element."""
    n = len(b)
    L: list[list[jax.Array]] = [[] for _ in range(n)]
    D: list[jax.Array] = []
    for i in range(n):
        for j in range(i):
            L[i].append((G[i, j] - sum(L[i][k] * L[j][k] * D[k] for k in range(j))) / D[j])
        D.append(G[i, i] - sum(L[i][k] ** 2 * D[k] for k in range(i)))
    y: list[jax.Array] = []
    for i in range(n):
        y.append(b[i] - sum(L[i][k] * y[k] for k in range(i)))
    x = [y[i] / D[i] for i in range(n)]
    for i in reversed(range(n)):
        x[i] -= sum(L[k][i] * x[k] for k in range(i + 1, n))
    return x


def rates(robot: Robot, q: jax.Array, twist: jax.Array) -> jax.Array:
    """(n,) of one row."""
    J = jacobian(robot.placements, robot.axes, robot.tool, q[robot.working])
    found = J.T @ jnp.stack(solve(J @ J.T + DAMPING * jnp.eye(6), twist))
    found *= jnp.minimum(1.0, robot.limit / jnp.max(jnp.abs(found)))
    return jnp.zeros(robot.n).at[robot.working].set(found)
