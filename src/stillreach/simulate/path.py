"""Where commanded twists lead.

Followed exactly from a pose (p, R) for a time t, a held twist [v; w] along base axes leads to (p + v t, exp(w t) R):
the point moves on a straight line while the attitude turns about a fixed axis.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.simulate.motion import Motion, Twist, commands

GAUSS = np.array([0.5 - np.sqrt(3.0) / 6.0, 0.5 + np.sqrt(3.0) / 6.0])
"""Nodes of the two-point rule on [0, 1]."""


def followed(T_start: npt.ArrayLike, twists: npt.ArrayLike, durations: npt.ArrayLike) -> FloatArray:
    """The poses of a tool that follows held twists exactly, one after the other.

    Args:
        T_start: (4, 4) [m] pose at the start.
        twists: (K, 6) [m/s, rad/s].
        durations: (K,) or one for all [s] how long each is held.

    Returns:
        (K + 1, 4, 4) [m], the start first.

    Raises:
        InputError: a start that is not rigid, twists of another shape, or another number of durations.
    """
    held = _door.matrix("twists", twists, (None, 6))
    times = _door.vector("durations", durations, len(held))
    return _moved(_door.pose("T_start", T_start), held * times[:, None])


def led_to(T_start: FloatArray, motion: Sequence[Motion], part: int, times: FloatArray) -> FloatArray:
    """The poses at some times (K,) [s] within one part of a motion, from the pose at the first of them, (K, 4, 4) [m].

    A held twist is followed exactly, a function of time to fourth order in the differences of the times (Magnus
    expansion).
    """
    steps = np.diff(times)[:, None]
    if part >= len(motion) or isinstance(motion[part], Twist):
        return _moved(T_start, commands(motion, times[:-1], part) * steps)
    nodes = times[:-1, None] + steps * GAUSS
    early, late = np.moveaxis(commands(motion, nodes.ravel(), part).reshape(-1, 2, 6), 1, 0)
    moves = 0.5 * steps * (early + late)
    moves[:, 3:] += np.sqrt(3.0) / 12.0 * steps**2 * np.cross(late[:, 3:], early[:, 3:])
    return _moved(T_start, moves)


def _moved(T_start: FloatArray, moves: FloatArray) -> FloatArray:
    """The poses after moves (K, 6), shift [m] and rotation vector [rad] along base axes; the start first."""
    poses = np.tile(np.eye(4), (len(moves) + 1, 1, 1))
    poses[0] = T_start
    poses[1:, :3, 3] = T_start[:3, 3] + np.cumsum(moves[:, :3], axis=0)
    for k, turn in enumerate(_rotations(moves[:, 3:])):
        poses[k + 1, :3, :3] = turn @ poses[k, :3, :3]
    return poses


def _rotations(vectors: FloatArray) -> FloatArray:
    """exp([w]) of rotation vectors (K, 3) [rad], (K, 3, 3): Rodrigues' formula, without cancellation near 0."""
    angle = np.linalg.norm(vectors, axis=1)
    first = np.sinc(angle / np.pi)[:, None, None]  # sin a / a
    second = 0.5 * np.sinc(angle / (2 * np.pi))[:, None, None] ** 2  # (1 - cos a) / a²
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    K = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    turns: FloatArray = np.eye(3) + first * K + second * (K @ K)
    return turns
