"""Where a survey asks whether the tool can still go: cells of a plane, and of the space around the arm."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.errors import InputError
from stillreach.simulation.document import arm_of, settings_text
from stillreach.task import Task

CELLS_OF_SLICE, CELLS_OF_CLOUD = 40, 16
"""Along each axis."""
NEEDED = "a task with two or three rows of the tool's position, two of them along base axes"


@dataclass(frozen=True)
class Cells:
    """Cells of a plane or of a cube around the first joint of an arm, seen by their middles.

    Args:
        axes: of the base, in the order of the arrays from the last dimension on.
        centre: (3,) [m] the first joint.
        half: [m] from there to the rim.
        count: along each axis.
    """

    axes: tuple[int, ...]
    centre: tuple[float, float, float]
    half: float
    count: int

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the arrays."""
        return (self.count,) * len(self.axes)

    def middles(self, axis: int) -> FloatArray:
        """(count,) [m] middles of the cells along an axis of the base."""
        own: FloatArray = self.centre[axis] + self.half * ((2.0 * np.arange(self.count) + 1.0) / self.count - 1.0)
        return own

    def edges(self, axis: int) -> FloatArray:
        """(count + 1,) [m] edges of the cells along an axis of the base."""
        own: FloatArray = self.centre[axis] + self.half * (2.0 * np.arange(self.count + 1) / self.count - 1.0)
        return own

    def points(self) -> FloatArray:
        """(cells, 3) [m] middles of the cells, in the order of the flat arrays."""
        found = np.tile(np.array(self.centre), (self.count ** len(self.axes), 1))
        along = np.meshgrid(*[self.middles(axis) for axis in reversed(self.axes)], indexing="ij")
        for axis, values in zip(reversed(self.axes), along, strict=True):
            found[:, axis] = values.ravel()
        return found

    def order(self, chosen: npt.NDArray[np.int64], seed: int) -> npt.NDArray[np.int64]:
        """Cells in a random order, of which each 4th along every axis comes first, and each 2nd before the others.

        So that few tries are spread evenly.

        Args:
            chosen: flat indices of the cells.
            seed: of the order.
        """
        places = np.stack(np.unravel_index(chosen, self.shape))
        late = (places % 4 != 0).any(axis=0).astype(np.int64) + (places % 2 != 0).any(axis=0)
        mixed = np.random.default_rng([seed, 2]).permutation(len(chosen))
        ordered: npt.NDArray[np.int64] = chosen[mixed][np.argsort(late[mixed], kind="stable")]
        return ordered

    def inside(self) -> npt.NDArray[np.int64]:
        """Flat indices of the cells within the ball around the first joint that holds all positions of the tool."""
        away = self.points() - np.array(self.centre)
        return np.flatnonzero(away[:, 0] ** 2 + away[:, 1] ** 2 + away[:, 2] ** 2 <= self.half**2)


@dataclass(frozen=True)
class Region:
    """Where a survey looks.

    Args:
        arm: with the task's point as its tool.
        task: the rows of the position.
        slice: cells of the plane through the first joint.
        cloud: cells of the space; None for a task in a plane.
    """

    arm: Arm
    task: Task
    slice: Cells
    cloud: Cells | None


def region_of(arm: Arm, task: Task) -> Region:
    """The positions of a survey: the x-z plane and the space around the first joint, or the plane of a task in one.

    Raises:
        InputError: if the task has no plane, or the reach of the arm has no end.
    """
    axes = tuple(row for row in task.indices if row < 3)
    if len(axes) < 2 or (len(axes) == 2 and task.frame != "base"):
        raise InputError(
            "metrics", f"positions of a task of {', '.join(task.row_names)} in the {task.frame} frame", NEEDED
        )
    own = arm if task.tool is None else arm.with_tool(arm.tool @ task.tool)
    x, y, z = own.joints[0].placement[:3, 3].tolist()
    half = own.reach - (x * x + y * y + z * z) ** 0.5
    if not np.isfinite(half):
        raise InputError("metrics", "positions of an arm whose reach is endless", "position limits for each slide")
    plane = Cells((axes[0], axes[-1]), (x, y, z), half, CELLS_OF_SLICE)
    cloud = Cells(axes, (x, y, z), half, CELLS_OF_CLOUD) if len(axes) == 3 else None
    return Region(own, task_of_rows(axes), plane, cloud)


def reached_cells(region: Region, cells: Cells, search: dict[str, Any]) -> npt.NDArray[np.int64]:
    """Flat indices of the cells that the tool reaches with all joints; each process searches them once.

    Args:
        region: the arm and its task.
        cells: of this region.
        search: settings of ``arm.inverse``.
    """
    settings = tuple((name, value) for name, value in search.items() if name != "task")
    return _reached(settings_text(region.arm), region.task.indices, cells, settings)


@lru_cache(maxsize=8)
def _reached(
    robot: str, rows: tuple[int, ...], cells: Cells, settings: tuple[tuple[str, Any], ...]
) -> npt.NDArray[np.int64]:
    inside = cells.inside()
    task = task_of_rows(rows)
    found = arm_of(robot).inverse(poses_at(cells.points()[inside]), task=task, **dict(settings))
    reached: npt.NDArray[np.int64] = inside[found.reached]
    reached.setflags(write=False)
    return reached


def task_of_rows(rows: tuple[int, ...]) -> Task:
    """The task of these rows along base axes."""
    return Task(rows=tuple(row in rows for row in range(6)))


def poses_at(points: FloatArray) -> FloatArray:
    """(N, 4, 4) poses at points (N, 3) [m]; their attitude does not count."""
    poses = np.tile(np.eye(4), (len(points), 1, 1))
    poses[:, :3, 3] = points
    return poses
