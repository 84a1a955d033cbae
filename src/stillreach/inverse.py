"""Inverse kinematics: the joint positions that bring the tool to a pose, with joints that stand still."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach import _core, _door
from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.arm.limits import sampling_range
from stillreach.batch import threads_of
from stillreach.errors import InputError
from stillreach.faults import FaultKind, Loses, fault_kind
from stillreach.inverse_result import Inverse
from stillreach.laws import LeastError
from stillreach.task import Task, task_of

STEP = 0.6
"""[rad] largest step of a revolute joint; a prismatic one moves at most this part of the arm's reach."""
STEPS = 40
"""Most steps of one start."""
FEW = 3
"""Starts for a pose that is farther away than the arm is long."""
MOST_STARTS = 1_000_000
MOST_CHOICES = 10_000
"""Combinations of positions at which joints are held."""
LAW = LeastError(price=None)

FREE, AT_START, AT_VALUE = range(3)
"""Hold of the core."""

Held = Iterable[str | int] | Mapping[str | int, npt.ArrayLike]


def inverse(
    arm: Arm,
    poses: npt.ArrayLike,
    start: npt.ArrayLike | None,
    locked: Held,
    faults: Mapping[str | int, FaultKind],
    task: Task | None,
    starts: int,
    tolerance: float,
    nearest: bool,
    solutions: int,
    apart: float,
    seed: int,
    threads: int | None,
) -> Inverse:
    """Joint positions for poses; arguments as for ``Arm.inverse``."""
    fixed = _fixed(_Same(arm, task))
    targets = _poses(poses)
    shape = targets.shape[:-2]
    count = math.prod(shape)
    begin = None if start is None else _start(start, shape, arm)
    if nearest and begin is None:
        raise InputError("nearest", "True without start", "a start, to which the configurations are near")
    room = _room(arm, locked, faults, begin) if locked or faults else fixed.room
    far = fixed.too_far(targets.reshape(count, 4, 4))
    most, ways = _door.count("starts", starts), _door.count("solutions", solutions)
    if most > MOST_STARTS:
        raise InputError("starts", str(most), f"at most {MOST_STARTS}")
    allowed = np.full(count, most, dtype=np.int32)
    if far.any():
        allowed[far] = min(FEW, most)
    given: dict[str, Any] = {
        "poses": targets.reshape(count, 4, 4),
        "step": fixed.step,
        **vars(room),
        "choices": len(room.values),
        "starts": allowed,
        "steps": STEPS,
        "solutions": ways,
        "apart": _door.positive("apart", apart),
        "tolerance": _door.positive("tolerance", tolerance),
        "nearest": bool(nearest),
        "seed": _door.count("seed", seed, minimum=0),
    }
    if begin is not None:
        given["start"] = begin
    answers: dict[str, Any] = {
        "q": np.full((count, ways, arm.n), np.nan),
        "residual": np.full((count, ways), np.nan),
        **{name: np.zeros(count, dtype=np.int32) for name in ("found", "used", "taken")},
    }
    own = fixed.task
    settings = fixed.law, fixed.metric, fixed.model, own.indices, own.frame == "tool", count
    try:
        _core.inverse(*settings, given, answers, threads_of(threads))
    except InputError as error:
        if error.argument == "poses":
            _refuse_pose(targets)
        raise
    last = (ways,) if ways > 1 else ()
    return Inverse(
        arm=arm,
        task=task,
        poses=targets,
        tolerance=float(tolerance),
        held=() if room is fixed.room else room.held(arm),
        q=answers["q"].reshape((*shape, *last, arm.n)),
        residual=answers["residual"].reshape((*shape, *last)),
        found=answers["found"].reshape(shape),
        too_far=far.reshape(shape),
        starts=answers["used"].reshape(shape),
        steps=answers["taken"].reshape(shape),
    )


class _Same:
    """An arm and a task as a key by identity: both are immutable, and comparing them takes longer than a search."""

    def __init__(self, arm: Arm, task: Task | None) -> None:
        self.arm, self.task = arm, task

    def __hash__(self) -> int:
        return hash((id(self.arm), id(self.task)))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.arm is other.arm and self.task is other.task


@dataclass(frozen=True)
class _Room:
    """Where the joints may be, as the core reads it.

    Args:
        lower: (n,) lower position limits [rad, m].
        upper: (n,) upper ones.
        hold: (n,) FREE, AT_START or AT_VALUE.
        values: (choices, n) positions of joints that are held at values; start s takes row s, in turns.
        low_start: (n,) random starts lie from here
        range: (n,) to this much further.
        turns: (n,) 1 where a whole turn leads back to the same pose, and there are no limits.
    """

    lower: FloatArray
    upper: FloatArray
    hold: npt.NDArray[np.int8]
    values: FloatArray
    low_start: FloatArray
    range: FloatArray
    turns: npt.NDArray[np.int8]

    @classmethod
    def of(
        cls, arm: Arm, lower: FloatArray, upper: FloatArray, hold: npt.NDArray[np.int8], values: FloatArray
    ) -> _Room:
        """With random starts over the limits, or a range of them."""
        low, high = sampling_range(arm.kinds, lower, upper)
        turns = ((arm.kinds == 0) & ~np.isfinite(lower) & ~np.isfinite(upper)).astype(np.int8)
        return cls(lower, upper, hold, values, low, high - low, turns)

    def held(self, arm: Arm) -> tuple[str, ...]:
        """Names of the joints that are held."""
        return tuple(arm.joint_names[i] for i in np.flatnonzero(self.hold))


@dataclass(frozen=True)
class _Fixed:
    """What depends on the arm and the task alone.

    Args:
        task: the task; all six rows at the arm's tool where none is given.
        first: (3,) [m] the first joint's place.
        linear: axes of the positions that the task asks for, as an index.
        length: [m] the largest distance of the task's point from there; inf where there is no such bound.
        step: (n,) largest steps [rad, m].
    """

    metric: _core.Metric
    model: _core.ArmModel
    task: Task
    law: _core.Law
    room: _Room
    first: FloatArray
    linear: list[int] | slice
    length: float
    step: FloatArray

    def too_far(self, targets: FloatArray) -> npt.NDArray[np.bool_]:
        """(N,) whether the position of a pose is farther from the first joint than the stretched arm is long."""
        if self.length == math.inf:
            return np.zeros(len(targets), dtype=bool)
        away = targets[:, self.linear, 3] - self.first[self.linear]
        away *= away
        return np.asarray(away.sum(axis=1) > self.length**2)


@lru_cache(maxsize=32)
def _fixed(key: _Same) -> _Fixed:
    arm = key.arm
    metric, model, task = task_of(arm, LAW.weights, key.task)
    own = arm if task.tool is None else arm.with_tool(arm.tool @ task.tool)
    first = own.joints[0].placement[:3, 3]
    axes = [row for row in task.indices if row < 3]
    linear = slice(3) if len(axes) == 3 else axes  # of an array a slice is taken several times faster
    bounded = len(axes) == 3 or (axes and task.frame == "base")
    lower, upper = (np.ascontiguousarray(side) for side in arm.position_limits.T)
    return _Fixed(
        metric,
        model,
        task,
        LAW.core(task.row_names, arm.reach, task.weights),
        _Room.of(arm, lower, upper, np.zeros(arm.n, dtype=np.int8), np.zeros((1, arm.n))),
        first,
        linear,
        (own.reach - math.hypot(*first)) * (1.0 + 1e-12) if bounded else math.inf,
        np.where(arm.kinds == 1, STEP * arm.reach, STEP),
    )


def _poses(poses: Any) -> FloatArray:
    expected = "rigid transforms, an array (..., 4, 4)"
    targets = _door.array("poses", poses, expected)
    if targets.shape[-2:] != (4, 4):
        raise InputError("poses", _door.describe(targets), expected)
    return targets


def _refuse_pose(targets: FloatArray) -> None:
    """Raises what is wrong with the first pose that is not rigid."""
    for index in np.ndindex(targets.shape[:-2]):
        try:
            _door.pose("poses", targets[index])
        except InputError as error:
            place = f" in pose {index[0] if len(index) == 1 else index}" if index else ""
            raise InputError("poses", f"{error.got}{place}", error.expected) from None


def _start(start: Any, shape: tuple[int, ...], arm: Arm) -> FloatArray:
    """(n,) or (N, n) joint positions where the first search begins."""
    begin = _door.configurations("start", start, arm.labels)
    if begin.ndim == 1:
        return begin
    if begin.shape[:-1] != shape:
        each = (*shape, arm.n)
        raise InputError("start", _door.describe(begin), f"{arm.n} joint positions, or those of each pose, {each}")
    return begin.reshape(-1, arm.n)


def _room(arm: Arm, locked: Any, faults: Any, begin: FloatArray | None) -> _Room:
    """What locked joints and faults leave of the position limits."""
    hold = np.zeros(arm.n, dtype=np.int8)
    lower, upper = (np.ascontiguousarray(side) for side in arm.position_limits.T)
    positions: dict[int, FloatArray] = {}
    if isinstance(locked, str) or not isinstance(locked, Iterable):
        raise InputError("locked", _door.describe(locked), "names of joints, or joints with their positions")
    for joint in locked:
        i = arm.joint_index(joint)
        if hold[i]:
            raise InputError("locked", f"{arm.joint_names[i]} twice", "each joint once")
        hold[i] = AT_START
        if isinstance(locked, Mapping):
            hold[i] = AT_VALUE
            values = _door.array("locked", locked[joint], f"a position of {arm.joint_names[i]}, or several").ravel()
            if not len(values) or not np.isfinite(values).all():
                got = _door.describe(locked[joint])
                raise InputError("locked", got, f"finite positions of {arm.joint_names[i]} [{arm.joint_units[i]}]")
            positions[i] = values
    for joint, kind in _by_joint(faults).items():
        i = arm.joint_index(joint)
        if hold[i]:
            raise InputError("faults", f"{arm.joint_names[i]}, which is locked", "each joint once")
        _restrict(arm, i, fault_kind(f"faults[{joint!r}]", kind), begin, hold, lower, upper)
    if begin is None and (hold == AT_START).any():
        name = arm.joint_names[int(np.flatnonzero(hold == AT_START)[0])]
        raise InputError("start", "None", f"the position at which {name} is locked, or locked={{{name!r}: position}}")
    total = math.prod(len(values) for values in positions.values())
    if total > MOST_CHOICES:
        raise InputError("locked", f"{total} combinations of positions", f"at most {MOST_CHOICES}")
    choices = np.zeros((total, arm.n))
    for row, choice in enumerate(itertools.product(*positions.values())):
        choices[row, list(positions)] = choice
    return _Room.of(arm, lower, upper, hold, choices)


def _by_joint(faults: Any) -> Mapping[str | int, Any]:
    if not isinstance(faults, Mapping):
        raise InputError("faults", _door.describe(faults), "a mapping of joints to faults, such as {'j4': Locked()}")
    return faults


def _restrict(
    arm: Arm,
    joint: int,
    kind: FaultKind,
    begin: FloatArray | None,
    hold: npt.NDArray[np.int8],
    lower: FloatArray,
    upper: FloatArray,
) -> None:
    """What a fault leaves of a joint's range."""
    name = arm.joint_names[joint]
    if kind.driven(0.0, 1.0) != 0.0:
        raise InputError("faults", f"{name}, {kind.word}", "faults with which the tool can stand still")
    if kind.loses is Loses.CHOICE:
        hold[joint] = AT_START
        return
    at = None if begin is None or begin.ndim > 1 else np.clip(begin[joint], lower[joint], upper[joint])
    if at is None and kind.positions(0.0) != kind.positions(1.0):
        raise InputError("start", _door.describe(begin), f"one position for all poses: {name} moves one way from it")
    low, high = kind.positions(0.0 if at is None else float(at))
    lower[joint], upper[joint] = max(low, lower[joint]), min(high, upper[joint])
    if lower[joint] > upper[joint]:
        got = f"{name}, {kind.sentence(slides=bool(arm.kinds[joint]))}"
        raise InputError("faults", got, "a range that is within its position limits")
