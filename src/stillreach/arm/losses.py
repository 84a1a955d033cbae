"""What an arm can do at a configuration, and what the loss of each joint costs it there."""

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
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm.model import Arm

CONFIGURATIONS = 200
SEED = 1994
HEAD = ("joint", "locked at", "smallest σ", "left", "typical", "lost")


@dataclass(frozen=True)
class Loss:
    """What locking one joint costs.

    Args:
        joint: name.
        singular_values: (min(m, n - 1),) of the Jacobian without the joint, falling [m, rad].
        rank: in how many directions the tool can move without it.
        remaining: manipulability without it over manipulability with it, 0 to 1; 0 where a direction is lost.
        lost: (lost, m) orthonormal unit twists that were possible and no longer are [m, rad].
    """

    joint: str
    singular_values: FloatArray
    rank: int
    remaining: float
    lost: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Losses:
    """What the loss of each joint costs an arm at a configuration; ``str()`` of it is a table and a verdict.

    ``losses["j4"]`` is the ``Loss`` of a joint; iterating gives the joints' names.

    Args:
        arm: the arm.
        q: (n,) [rad, m].
        task: rows, axes and point of the task; None: all six rows at the arm's tool.
        lost_below: speeds [m/s] and [rad/s]; a direction in which all joints at full rates give less is lost.
        singular_values: (min(m, n),) of the whole arm's Jacobian, falling [m, rad].
        rank: in how many directions the whole arm can move its tool.
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
        """(n,) the same as the median over the arm's range; 0 where a direction is lost over most of it."""
        places = [_Place.of(self.arm, q, self.task, self.lost_below) for q in _configurations(self.arm)]
        return _door.frozen(np.median([place.left() for place in places], axis=0))

    @property
    def rows(self) -> tuple[int, ...]:
        """(m,) which ones of [v; w] the task's rows are."""
        return _rows(self.task)

    @property
    def frame(self) -> str:
        """The axes that the rows are taken along, "base" or "tool"."""
        return "base" if self.task is None else self.task.frame

    @property
    def least_spared(self) -> str:
        """The joint that leaves least over the arm's range, and among equals here."""
        return self.arm.joint_names[min(range(self.arm.n), key=lambda i: (self.typical[i], self.remaining[i]))]

    @property
    def verdict(self) -> str:
        """Which joint the arm can spare least, in words."""
        names = self.arm.joint_names
        always = [name for name, left in zip(names, self.typical, strict=True) if left == 0.0]
        here = [loss.joint for loss in self.by_joint.values() if len(loss.lost)]
        if len(always) == self.arm.n:
            text = "This arm can spare no joint: without any of them the tool loses a direction over most of the range"
        elif always:
            text = f"What this arm can spare least {'is' if len(always) == 1 else 'are'} {joined(always, 'and')}: "
            text += f"without {'it' if len(always) == 1 else 'any of them'} the tool loses a direction over most of "
            text += "the range"
        else:
            left = share(float(self.typical[names.index(self.least_spared)]))
            text = f"What this arm can spare least is {self.least_spared}: without it a median of {left} of the "
            text += "manipulability is left over the range"
        if here == always:
            return f"{text}."
        if not here:
            return f"{text}. Here it can spare any one joint."
        return f"{text}. Here it cannot spare {'any joint' if len(here) == self.arm.n else joined(here, 'or')}."

    def table(self) -> list[tuple[str, ...]]:
        """Cells of the table below its HEAD, a row a joint."""
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
        """What the columns of the table mean, in lines."""
        lines = [
            "left: manipulability without the joint, in per cent of the whole arm's",
            "typical: the same, as the median over the arm's range; lost: over most of it",
        ]
        if any(len(loss.lost) for loss in self.by_joint.values()):
            asked = min(self.rows) < 3, max(self.rows) >= 3
            speeds = zip(self.lost_below, ("m", "rad"), asked, strict=True)
            least = [shown(speed, unit, rate=True) for speed, unit, counts in speeds if counts]
            lines += [
                "lost: direction [m/s, rad/s] in which all joints but this one, at full rates,",
                f"      give less than {' and '.join(least)}",
            ]
        return lines

    def __str__(self) -> str:
        return "\n".join([aligned([HEAD, *self.table()]), "", *self.legend(), "", self.verdict])

    def __repr__(self) -> str:
        return (
            f"<Losses of {self.arm.name}: {', '.join(f'{k} {share(v.remaining)}' for k, v in self.by_joint.items())}>"
        )


def losses(arm: Arm, q: npt.ArrayLike | None, task: Asked | None, least: tuple[float, float]) -> Losses:
    """What the loss of each joint costs; arguments as of ``Arm.losses``."""
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
    """(n,) where an arm moves best of a sample of its range [rad, m].

    It has the most directions, and among equals the largest manipulability, with rates measured in their limits.
    """
    marks = []
    for q in _configurations(arm):
        gains = _Place.of(arm, q, task, least).whole.gains
        marks.append((len(gains), float(np.sum(np.log(gains)))))
    return _door.frozen(_configurations(arm)[max(range(CONFIGURATIONS), key=marks.__getitem__)])


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
        """(m, lost) orthonormal directions that the whole arm serves, and not without a joint."""
        served = self.whole.served
        rest = np.delete(served.T @ (self.J * self.rates), joint, axis=1)
        return served @ directions(rest, self.least, served).lost

    def left(self) -> FloatArray:
        """(n,) manipulability without each joint over manipulability with it; 0 where a direction is lost.

        It is the length of the joint's row in an orthonormal basis of the null space of J, of the served directions.
        """
        served = self.whole.served
        _, _, Vt = np.linalg.svd(served.T @ self.J, full_matrices=True)
        kept = np.linalg.norm(Vt[served.shape[1] :], axis=0)
        return np.array([0.0 if self.lost_without(i).size else kept[i] for i in range(len(kept))])


def _rows(task: Asked | None) -> tuple[int, ...]:
    return tuple(range(6)) if task is None else task.indices


def _singular_values(J: FloatArray) -> FloatArray:
    """(min(m, n),) falling; none for no column."""
    return np.asarray(np.linalg.svd(J, compute_uv=False)) if J.size else np.zeros(0)


def _configurations(arm: Arm) -> FloatArray:
    """(CONFIGURATIONS, n) [rad, m] within the position limits, half a turn or 1 m to both sides where there are none.

    They are random, and always the same.
    """
    lower, upper = arm.position_limits.T
    span = np.where(arm.kinds == 1, 1.0, np.pi)
    low = np.where(np.isfinite(lower), lower, np.minimum(upper, span) - 2 * span)
    low = np.where(np.isfinite(lower) | np.isfinite(upper), low, -span)
    high = np.where(np.isfinite(upper), upper, low + 2 * span)
    return np.random.default_rng(SEED).uniform(low, high, (CONFIGURATIONS, arm.n))
