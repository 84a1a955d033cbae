"""What an arm can do at a configuration, and the cost of losing each joint."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._words import aligned, direction, joined, share, shown
from stillreach.arm.dexterity import (
    LEAST_SPEED,
    LEAST_TURN,
    Asked,
    Directions,
    checked_task,
    directions,
    full_rates,
    least_speeds,
    task_jacobian,
)
from stillreach.arm.limits import sampling_range
from stillreach.arm.relative import failure_sets, null_basis, without
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm.model import Arm

CONFIGURATIONS = 200
SEED = 1994
HEAD = ("joint", "locked at", "smallest σ", "remaining", "typical", "lost")


@dataclass(frozen=True)
class Loss:
    """The cost of locking one joint.

    Args:
        joint: name.
        singular_values: (min(m, n - 1),) of the Jacobian without the joint, descending [m, rad].
        rank: number of directions in which the tool can move without it.
        remaining: manipulability without it over manipulability with it, 0 to 1; 0 where a direction is lost.
        lost: (lost, m) orthonormal unit twists that are possible only with the joint [m, rad].
    """

    joint: str
    singular_values: FloatArray
    rank: int
    remaining: float
    lost: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Losses:
    """The cost of losing each joint at a configuration; ``str()`` returns a table and a verdict.

    ``losses["j4"]`` is the ``Loss`` of a joint; iterating gives the joints' names.

    Args:
        arm: the arm.
        q: (n,) [rad, m].
        task: rows, frame and point of the task; None: all six rows at the arm's tool.
        lost_below: speeds [m/s] and [rad/s]; a direction in which all joints at full rates give less counts as lost.
        singular_values: (min(m, n),) of the whole arm's Jacobian, descending [m, rad].
        rank: number of directions in which the whole arm can move its tool.
        by_joint: the loss of each joint by name.
    """

    arm: Arm
    q: FloatArray
    task: Asked | None
    lost_below: tuple[float, float]
    singular_values: FloatArray
    rank: int
    by_joint: dict[str, Loss]

    def __getitem__(self, joint: str | int) -> Loss:
        return self.by_joint[self.arm.joint_names[self.arm.joint_index(joint)]]

    def __iter__(self) -> Iterator[str]:
        return iter(self.by_joint)

    def __len__(self) -> int:
        return len(self.by_joint)

    @cached_property
    def remaining(self) -> FloatArray:
        """(n,) remaining manipulability without each joint, 0 to 1."""
        return _door.frozen([loss.remaining for loss in self.by_joint.values()])

    @cached_property
    def typical(self) -> FloatArray:
        """(n,) median of ``remaining`` over the arm's range; 0 where a direction is lost over most of it."""
        places = [_Place.of(self.arm, q, self.task, self.lost_below) for q in random_configurations(self.arm)]
        return _door.frozen(np.median([place.left() for place in places], axis=0))

    @property
    def rows(self) -> tuple[int, ...]:
        """(m,) indices of the task's rows in [v; w]."""
        return _rows(self.task)

    @property
    def frame(self) -> str:
        """The axes of the rows, "base" or "tool"."""
        return "base" if self.task is None else self.task.frame

    @property
    def least_spared(self) -> str:
        """The joint with the lowest typical value; among equals, the lowest remaining value."""
        return self.arm.joint_names[min(range(self.arm.n), key=lambda i: (self.typical[i], self.remaining[i]))]

    @property
    def verdict(self) -> str:
        """The most critical joints, in words."""
        names = self.arm.joint_names
        always = [name for name, left in zip(names, self.typical, strict=True) if left == 0.0]
        here = [loss.joint for loss in self.by_joint.values() if len(loss.lost)]
        if len(always) == self.arm.n:
            text = "Every joint is critical: without any one of them the tool loses a direction over most of the range"
        elif always:
            one = len(always) == 1
            text = f"The most critical {'joint is' if one else 'joints are'} {joined(always, 'and')}: without "
            text += f"{'it' if one else 'any one of them'} the tool loses a direction over most of the range"
        else:
            left = share(float(self.typical[names.index(self.least_spared)]))
            text = f"The most critical joint is {self.least_spared}: without it the median remaining manipulability "
            text += f"over the range is {left}"
        if here == always:
            return f"{text}."
        if not here:
            return f"{text}. Here the loss of any one joint costs no direction."
        lost = "any joint" if len(here) == self.arm.n else joined(here, "or")
        return f"{text}. Here the loss of {lost} costs a direction."

    def table(self) -> list[tuple[str, ...]]:
        """Cells of the table below HEAD, one row for each joint."""
        return [
            (
                loss.joint,
                shown(self.q[i], self.arm.joint_units[i]),
                f"{loss.singular_values[self.rank - 1] if 0 < self.rank == loss.rank else 0.0:.3g}",
                "0 %" if len(loss.lost) else share(loss.remaining),
                share(float(self.typical[i])) if self.typical[i] else "lost",
                "; ".join(direction(twist, self.rows, signed=False) for twist in loss.lost) or "-",
            )
            for i, loss in enumerate(self.by_joint.values())
        ]

    def legend(self) -> list[str]:
        """Explanations of the columns, one a line."""
        lines = [
            "remaining: manipulability without the joint, in per cent of the whole arm's",
            "typical: median over the arm's range; lost: a direction is lost over most of it",
        ]
        if any(len(loss.lost) for loss in self.by_joint.values()):
            asked = min(self.rows) < 3, max(self.rows) >= 3
            speeds = zip(self.lost_below, ("m", "rad"), asked, strict=True)
            least = [shown(speed, unit, rate=True) for speed, unit, counts in speeds if counts]
            lines += [
                "lost: direction [m/s, rad/s] in which the other joints at full rates give less",
                f"      than {' and '.join(least)}",
            ]
        return lines

    def __str__(self) -> str:
        return "\n".join([aligned([HEAD, *self.table()]), "", *self.legend(), "", self.verdict])

    def __repr__(self) -> str:
        return (
            f"<Losses of {self.arm.name}: {', '.join(f'{k} {share(v.remaining)}' for k, v in self.by_joint.items())}>"
        )


def losses(arm: Arm, q: npt.ArrayLike | None, task: Asked | None, least: tuple[float, float]) -> Losses:
    """The cost of losing each joint; arguments as for ``Arm.losses``."""
    checked_task(task)
    speeds = _door.vector("lost_below", least, 2, minimum=0.0)
    if not np.all(speeds > 0.0):
        raise InputError("lost_below", _door.describe(least), "two speeds above 0 [m/s] and [rad/s]")
    speed, turn = map(float, speeds)
    at = best(arm, task, (speed, turn)) if q is None else _door.vector("q", q, arm.n, labels=arm.labels)
    place = _Place.of(arm, at, task, (speed, turn))
    left, rank = place.left(), place.whole.served.shape[1]
    found = {}
    for i, name in enumerate(arm.joint_names):
        lost = np.ascontiguousarray(place.lost_without(i).T)
        sigma = _singular_values(np.delete(place.J, i, axis=1))
        found[name] = Loss(name, sigma, rank - len(lost), float(left[i]), lost)
    return Losses(arm, at, task, (speed, turn), _singular_values(place.J), rank, found)


def best(arm: Arm, task: Asked | None = None, least: tuple[float, float] = (LEAST_SPEED, LEAST_TURN)) -> FloatArray:
    """(n,) the best configuration in a sample of an arm's range [rad, m].

    It has the most directions and, among equals, the largest manipulability, with rates relative to their limits.
    """
    marks = []
    for q in random_configurations(arm):
        gains = _Place.of(arm, q, task, least).whole.gains
        marks.append((len(gains), float(np.sum(np.log(gains)))))
    return _door.frozen(random_configurations(arm)[max(range(CONFIGURATIONS), key=marks.__getitem__)])


@dataclass(frozen=True)
class _Place:
    """An arm at a configuration.

    Args:
        J: (m, n) Jacobian of the task's rows; 0 for joints that cannot move [m, rad].
        rates: (n,) full rates.
        least: (m,) least speeds of the rows.
        whole: directions of the whole arm.
    """

    J: FloatArray
    rates: FloatArray
    least: FloatArray
    whole: Directions

    @classmethod
    def of(cls, arm: Arm, q: FloatArray, task: Asked | None, least: tuple[float, float]) -> _Place:
        """The arm at q (n,) [rad, m]."""
        rates, speeds = full_rates(arm.velocity_limits), least_speeds(_rows(task), *least)
        J = task_jacobian(arm, q, task) * (rates > 0.0)
        return cls(J, rates, speeds, directions(J * rates, speeds))

    def lost_without(self, joint: int) -> FloatArray:
        """(m, lost) orthonormal directions that the arm serves only with a joint."""
        served = self.whole.served
        rest = np.delete(served.T @ (self.J * self.rates), joint, axis=1)
        return served @ directions(rest, self.least, served).lost

    def left(self) -> FloatArray:
        """(n,) manipulability without each joint over manipulability with it; 0 where a direction is lost.

        That of J in the served directions.
        """
        served = self.whole.served
        kept = without(null_basis(served.T @ self.J), failure_sets(range(self.J.shape[1]), 1))
        return np.array([0.0 if self.lost_without(i).size else kept[i] for i in range(len(kept))])


def _rows(task: Asked | None) -> tuple[int, ...]:
    return tuple(range(6)) if task is None else task.indices


def _singular_values(J: FloatArray) -> FloatArray:
    """(min(m, n),) singular values, descending; empty for a matrix without columns."""
    return np.asarray(np.linalg.svd(J, compute_uv=False)) if J.size else np.zeros(0)


def random_configurations(arm: Arm) -> FloatArray:
    """(CONFIGURATIONS, n) random configurations [rad, m] with a fixed seed."""
    low, high = sampling_range(arm.kinds, *arm.position_limits.T)
    return np.random.default_rng(SEED).uniform(low, high, (CONFIGURATIONS, arm.n))
