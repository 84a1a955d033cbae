"""What an arm can afford to lose at a configuration: every set of joints, and speeds before and after."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach._words import aligned, direction, joined, share, shown
from stillreach.arm import Arm
from stillreach.arm.dexterity import (
    LEAST_SPEED,
    LEAST_TURN,
    checked_task,
    directions,
    full_rates,
    least_speeds,
    task_jacobian,
)
from stillreach.arm.relative import best_possible, failure_sets, null_basis, without
from stillreach.errors import InputError
from stillreach.faults import FaultKind, fault_kind
from stillreach.task import Task
from stillreach.tolerance.speeds import along, guaranteed, normals, row_scales

HEAD = ("lost", "remaining", "speed everywhere", "directions lost")
"""Columns of the table."""
MOST_SETS = 2_000_000
CRITICAL = 0.1
"""Relative manipulability below which a joint is called critical."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Report:
    """The tolerance of an arm at a configuration; ``str()`` returns a table and a verdict.

    Args:
        arm: the arm.
        q: (n,) [rad, m].
        task: the task.
        working: indices of the joints that work before the failures.
        k: the largest number of joints that fail.
        rank: number of directions in which the tool can move.
        sets: for each size from 1 on, (C, size) the sets of joints that fail, by index.
        relative: for each size (C,) relative manipulability: w(J without the set) / w(J), 0 to 1.
        loses: for each size (C,) whether a direction of the tool is lost, by gain: full rates give less than 1 mm/s or
            0.1 deg/s in it.
        speed: the guaranteed speed in every direction [m/s, rad/s], in the units of the task's weights.
        speeds: for each size (C,) the same after the failure; of more than 16 joints an upper bound.
        exact: whether these are exact.
        below: relative manipulability below which a joint is critical.
    """

    arm: Arm
    q: FloatArray
    task: Task
    working: tuple[int, ...]
    k: int
    rank: int
    sets: tuple[npt.NDArray[np.int64], ...]
    relative: tuple[FloatArray, ...]
    loses: tuple[npt.NDArray[np.bool_], ...]
    speed: float
    speeds: tuple[FloatArray, ...]
    exact: bool
    below: float

    def relative_to(self, joints: Iterable[str | int]) -> float:
        """Relative manipulability without some joints.

        Raises:
            InputError: if the report has no such set.
        """
        size, place = self._place(joints)
        return float(self.relative[size][place])

    def _place(self, joints: Iterable[str | int]) -> tuple[int, int]:
        given = [joints] if isinstance(joints, str | int) else list(joints)
        wanted = sorted({self.arm.joint_index(joint) for joint in given})
        size = len(wanted) - 1
        found = np.zeros(0, dtype=np.int64)
        if 0 <= size < self.k:
            found = np.flatnonzero((self.sets[size] == wanted).all(axis=1))
        if not len(found):
            raise InputError("joints", _door.describe(joints), f"1 to {self.k} of the joints that work")
        return size, int(found[0])

    def names(self, joints: Iterable[int]) -> str:
        """``"j2 + j4"``."""
        return " + ".join(self.arm.joint_names[joint] for joint in joints)

    def worst(self, size: int = 1) -> tuple[tuple[str, ...], float]:
        """The set of so many joints whose loss leaves least, by name, and its relative manipulability.

        Raises:
            InputError: if the report has no sets of that size.
        """
        count = _door.count("size", size)
        if count > self.k:
            raise InputError("size", f"{count}", f"at most {self.k}")
        place = int(np.argmin(self.relative[count - 1]))
        return tuple(self.arm.joint_names[j] for j in self.sets[count - 1][place]), float(
            self.relative[count - 1][place]
        )

    def bound(self, size: int = 1) -> float:
        """What the worst set of so many joints has at best, in any arm of as many working joints."""
        return best_possible(len(self.working), self.rank, _door.count("size", size))

    @property
    def critical(self) -> tuple[str, ...]:
        """Joints without which a direction is lost, or less than ``below`` of the manipulability is left."""
        bad = self.loses[0] | (self.relative[0] < self.below)
        return tuple(self.arm.joint_names[joint] for joint in self.sets[0][bad, 0])

    @property
    def depth(self) -> int:
        """How many joints, whichever they are, can fail without a loss of a direction; at most ``k``."""
        lost = [bool(np.any(loses)) for loses in self.loses]
        return lost.index(True) if any(lost) else self.k

    def lost_directions(self, joints: Iterable[str | int]) -> FloatArray:
        """(lost, m) unit twists in the task's rows [m, rad] that are possible only with these joints."""
        size, place = self._place(joints)
        J, rates, least = self._jacobian()
        served = self._served()
        rest = np.delete(served.T @ (J * rates), self._columns(self.sets[size][place]), axis=1)
        return np.ascontiguousarray((served @ directions(rest, least, served).lost).T)

    def weakest_direction(self, joints: Iterable[str | int]) -> tuple[FloatArray, float]:
        """The direction of the tool that suffers most from the loss of these joints.

        Returns:
            (m,) unit twist in the task's rows [m, rad], and what is left of the tool's motion in it, 0 to 1: norm of
            the direction's row of the Jacobian without the joints over that with them. For one joint, it is the
            relative manipulability. Where a direction is lost, it is that.
        """
        size, place = self._place(joints)
        J, _, _ = self._jacobian()
        served = self._served()
        U, L = np.linalg.qr((served.T @ J).T)  # J' = U L
        rest = np.delete(U, self._columns(self.sets[size][place]), axis=0)
        _, sigma, Vt = np.linalg.svd(rest, full_matrices=True)
        found = served @ np.linalg.solve(L, Vt[-1])
        left = sigma[-1] if len(sigma) == len(Vt) else 0.0
        return np.ascontiguousarray(found / np.linalg.norm(found)), float(left)

    def _served(self) -> FloatArray:
        """(m, rank) directions in which the tool can move."""
        J, rates, least = self._jacobian()
        return directions(J * rates, least).served

    def jump(self, rates: npt.ArrayLike) -> FloatArray:
        """(n,) [rad/s, m/s] the jump of all rates (their norm) when each joint locks, from minimum-norm rates (n,).

        |rate| / relative manipulability: inf where nothing is left and the joint moves; 0 where it stands still.
        """
        moving = np.abs(_door.vector("rates", rates, self.arm.n, labels=self.arm.labels))
        left = np.full(self.arm.n, np.nan)
        left[list(self.working)] = self.relative[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(moving > 0.0, moving / left, 0.0)

    def speed_along(self, twist: npt.ArrayLike, faults: Mapping[str | int, FaultKind] | None = None) -> float:
        """The largest speed of the tool along a twist, with nothing in the task's other directions.

        Args:
            twist: (m,) or (6,) direction [m, rad], of any length but 0: the result is a multiple of the unit twist.
            faults: joints that fail in addition, e.g. ``{"j2": Derated(0.5)}``; a Confined joint keeps its speed.

        Raises:
            InputError: if an argument is invalid, or a joint runs away.
            UnknownJointError: if the arm has no such joint.
        """
        rows = self.task.indices
        given = _door.array("twist", twist, f"{len(rows)} or 6 numbers")
        wanted = given[list(rows)] if given.shape == (6,) and len(rows) < 6 else given
        wanted = _door.unit_vector("twist", wanted, len(rows))
        lower, upper = self._bounds(faults or {})
        J, _, _ = self._jacobian()
        scales = row_scales(self.task)
        return along(J * scales[:, None], wanted * scales, lower, upper)

    def speed_after(self, faults: Mapping[str | int, FaultKind]) -> float:
        """The guaranteed speed in every direction after faults, e.g. ``{"j2": Derated(0.5)}``; as for ``speed``."""
        J, _, _ = self._jacobian()
        weighted = J * row_scales(self.task)[:, None]
        return float(guaranteed(weighted, normals(weighted)[0], *self._bounds(faults)))

    def _weakest_words(self, joint: str) -> str:
        return direction(self.weakest_direction([joint])[0], self.task.indices, signed=False)

    def _bounds(self, faults: Mapping[str | int, FaultKind]) -> tuple[FloatArray, FloatArray]:
        """Bounds of the working joints' rates."""
        if not isinstance(faults, Mapping):
            raise InputError("faults", _door.describe(faults), "a mapping from joints to faults")
        _, rates, _ = self._jacobian()
        lower, upper = -rates, rates.copy()
        for joint, given in faults.items():
            index, kind = self.arm.joint_index(joint), fault_kind("faults", given)
            if index not in self.working:
                continue
            place = self.working.index(index)
            if kind.driven(0.0, 1.0) != 0.0:
                raise InputError("faults", f"{kind} of {self.arm.joint_names[index]}", "faults that leave 0 as a rate")
            limit = float(rates[place])
            lower[place], upper[place] = kind.driven(-limit, limit), kind.driven(limit, limit)
        return lower, upper

    def _jacobian(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        return _jacobian(self.arm, self.q, self.task, self.working)

    def _columns(self, joints: Iterable[int]) -> list[int]:
        return [self.working.index(joint) for joint in joints]

    def table(self) -> list[tuple[str, ...]]:
        """Cells below HEAD: each joint, then the worst set of each larger size."""
        rows: list[tuple[str, ...]] = []
        for size in range(self.k):
            places = range(len(self.sets[0])) if size == 0 else [int(np.argmin(self.relative[size]))]
            for place in places:
                joints = self.sets[size][place]
                lost = self.lost_directions(joints.tolist())
                words = "; ".join(direction(twist, self.task.indices, signed=False) for twist in lost)
                left = 0.0 if self.loses[size][place] else float(self.relative[size][place])
                rows.append((self.names(joints), share(left), f"{self.speeds[size][place]:.3g}", words or "-"))
        return rows

    @property
    def verdict(self) -> str:
        """The result in words."""
        m = self.task.m
        if self.rank < m:
            return (
                f"The arm is already singular here: it moves its tool in {self.rank} of {m} directions, and the "
                "figures are for these alone."
            )
        critical = self.critical
        if len(critical) == len(self.working):
            text = "Every joint is critical."
        elif critical:
            which = "joints are" if len(critical) > 1 else "joint is"
            lost = {name: self.lost_directions([name]) for name in critical}
            words = [
                f"{name} ({'; '.join(direction(twist, self.task.indices, signed=False) for twist in lost[name])})"
                if len(lost[name])
                else f"{name} ({share(self.relative_to([name]))} remaining, least of {self._weakest_words(name)})"
                for name in critical
            ]
            text = f"The critical {which} {joined(words, 'and')}."
        else:
            one, left = self.worst()
            text = f"Any one joint can be lost; {one[0]} costs most, {share(left)} remaining."
        if self.k > 1 and not critical:
            several, left = self.worst(self.k)
            cost = "a direction is lost" if self.depth < self.k else f"{share(left)} remaining"
            text += f" Of {self.k} at once, {joined(several, 'and')} cost most: {cost}."
        best, reached = self.bound(1), float(np.min(self.relative[0]))
        return f"{text} The worst joint leaves {share(reached)}, where the best arm possible leaves {share(best)}."

    def facts(self) -> dict[str, Any]:
        """The main numbers, for JSON."""
        return {
            "rank": self.rank,
            "depth": self.depth,
            "critical": list(self.critical),
            "guaranteed_speed": self.speed,
            "exact": self.exact,
            "verdict": self.verdict,
            "worst": [
                {
                    "joints": list(self.worst(size)[0]),
                    "relative_manipulability": self.worst(size)[1],
                    "best_possible": self.bound(size),
                    "guaranteed_speed": float(np.min(self.speeds[size - 1])),
                }
                for size in range(1, self.k + 1)
            ],
        }

    def __str__(self) -> str:
        lines = [aligned([HEAD, *self.table()]), ""]
        units = " and ".join(
            shown(self.speed, unit, rate=True)
            for unit, asked in (("m", min(self.task.indices) < 3), ("rad", max(self.task.indices) >= 3))
            if asked
        )
        lines += ["remaining: relative manipulability; speed everywhere: what the tool reaches in every direction,"]
        lines += [f"with all joints {self.speed:.3g} ({units}){'' if self.exact else '; an upper bound'}", ""]
        return "\n".join([*lines, self.verdict])

    def __repr__(self) -> str:
        names, left = self.worst()
        return f"<Report of {self.arm.name}: {names[0]} leaves {share(left)}, depth {self.depth}>"


def report(
    arm: Arm,
    q: npt.ArrayLike,
    *,
    k: int = 2,
    task: Task | None = None,
    failed: Iterable[str | int] = (),
    below: float = CRITICAL,
) -> Report:
    """What an arm can afford to lose at a configuration.

    Args:
        arm: the arm.
        q: (n,) [rad] or [m], or by joint name.
        k: the largest number of joints that fail at once.
        task: rows, frame and point; None: the full pose. Its weights set the units in which speeds are compared.
        failed: joints that stand still already; everything is relative to the others.
        below: relative manipulability below which a joint is called critical.

    Raises:
        InputError: if an argument is invalid.
        UnknownJointError: if the arm has no such joint.
    """
    if not isinstance(arm, Arm):
        raise InputError("arm", _door.describe(arm), "an Arm")
    chosen = Task() if task is None else task
    checked_task(chosen)
    at = _door.vector("q", q, arm.n, labels=arm.labels)
    given = [failed] if isinstance(failed, str | int) else list(failed)
    still = {arm.joint_index(joint) for joint in given}
    working = tuple(joint for joint in range(arm.n) if joint not in still)
    count = _door.count("k", k)
    if count > len(working):
        raise InputError("k", f"{count}", f"at most the {len(working)} joints that work")
    limit = _door.positive("below", below, or_zero=True)
    J, rates, least = _jacobian(arm, at, chosen, working)
    served = directions(J * rates, least).served
    Z = null_basis(served.T @ (J * (rates > 0.0)))
    weighted = J * row_scales(chosen)[:, None]
    facets, exact = normals(weighted)
    places = np.arange(len(working))
    sets, relative, loses, speeds = [], [], [], []
    for size in range(1, count + 1):
        own = failure_sets(places.tolist(), size)
        if len(own) > MOST_SETS:
            raise InputError("k", f"{count}", f"sizes with at most {MOST_SETS} sets of {len(working)} joints")
        sets.append(np.array(working)[own])
        relative.append(without(Z, own))
        loses.append(_loses(served.T @ (J * rates), least, served, own))
        moving = np.ones((len(own), len(working)))
        np.put_along_axis(moving, own, 0.0, axis=1)
        speeds.append(guaranteed(weighted, facets, -rates * moving, rates * moving))
    return Report(
        arm=arm,
        q=_door.frozen(at),
        task=chosen,
        working=working,
        k=count,
        rank=served.shape[1],
        sets=tuple(sets),
        relative=tuple(_door.frozen(values) for values in relative),
        loses=tuple(loses),
        speed=float(guaranteed(weighted, facets, -rates, rates)),
        speeds=tuple(_door.frozen(values) for values in speeds),
        exact=exact,
        below=limit,
    )


def _jacobian(
    arm: Arm, q: FloatArray, task: Task, working: tuple[int, ...]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Jacobian (m, w) of the joints that work, their full rates (w,), and the least speeds of the rows (m,)."""
    J = task_jacobian(arm, q, task)[:, list(working)]
    return J, full_rates(arm.velocity_limits)[list(working)], least_speeds(task.indices, LEAST_SPEED, LEAST_TURN)


def _loses(J: FloatArray, least: FloatArray, served: FloatArray, sets: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """(C,) whether a direction that full rates serve is lost without each set of joints, as ``directions`` has it.

    Args:
        J: (k, n) Jacobian in the coordinates of the served directions, scaled by full rates.
        least: (m,) least speeds of the rows.
        served: (m, k).
        sets: (C, f).
    """
    k, n = J.shape
    if n - sets.shape[1] < k:
        return np.ones(len(sets), dtype=bool)
    scaled = np.linalg.qr(served / least[:, None])[1] @ J
    keep = np.ones((len(sets), n), dtype=bool)
    np.put_along_axis(keep, sets, False, axis=1)
    rest = scaled[:, np.nonzero(keep)[1].reshape(len(sets), -1)].transpose(1, 0, 2)
    U = np.linalg.svd(rest, full_matrices=False)[0]
    reach = np.sum(np.abs(U.transpose(0, 2, 1) @ rest), axis=2)
    return np.asarray(np.any(reach < 1.0, axis=1))
