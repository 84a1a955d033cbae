"""The arrays of a survey: one table, from which they are computed, stored and labelled."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach.tolerance.surveys.plan import Plan
from stillreach.tolerance.surveys.positions import CELLS_OF_CLOUD, CELLS_OF_SLICE

Arrays = dict[str, npt.NDArray[Any]]

BINS = 200
"""Bins of relative manipulability, equally wide in its fourth root: small values are resolved, too."""
EDGES = (np.arange(BINS + 1) / BINS) ** 2 * (np.arange(BINS + 1) / BINS) ** 2
CELLS = 48
"""Cells of the map along each axis, over the reach of the arm."""
PLANES = ("x-y", "x-z")
SPEEDS = tuple(
    float(f"{digits}e{power}")
    for power in range(-4, 3)
    for digits in ("1", "1.25", "1.6", "2", "2.5", "3.15", "4", "5", "6.3", "8")
)
"""Edges between the bins of speeds [m/s, rad/s]; below the first one and above the last one are bins, too."""
SPEED_EDGES = np.array([0.0, *SPEEDS, SPEEDS[-1]])


class Variable(NamedTuple):
    """An array of a survey.

    Args:
        metric: that has it; "" for all, "cloud" for positions in space.
        dims: after the first one, which is "chunk", or "configuration" of those kept with ``keep="all"``.
        dtype: of its numbers.
        meaning: in words.
        empty: what it holds before a configuration counts.
        units: "joint" for those of each joint.
        largest: of all chunks the largest counts, and not their sum.
    """

    metric: str
    dims: tuple[str, ...]
    dtype: str
    meaning: str
    empty: float = 0.0
    units: str = "1"
    largest: bool = False


_LEAST, _MOST = np.inf, -np.inf
_SLICE, _CLOUD = ("slice_up", "slice_across"), ("cloud_z", "cloud_y", "cloud_x")
REDUCED = {
    "configurations": Variable("", (), "i8", "configurations that count"),
    "unreached": Variable("", (), "i8", "poses that no start reached, which do not count"),
    "singular": Variable("relative", (), "i8", "configurations whose Jacobian has not full rank; they are left out"),
    "relative": Variable("relative", ("joint", "bin"), "i8", "histogram of relative manipulability without each joint"),
    "worst": Variable("relative", ("size", "bin"), "i8", "the same without the worst set of each size"),
    "worst_set": Variable("relative", ("set",), "i8", "how often each set is the worst of its size"),
    "weakest": Variable("relative", ("size",), "f8", "relative manipulability at the worst configuration", _LEAST),
    "weakest_set": Variable("relative", ("size",), "i4", "its worst set, by index", -1),
    "weakest_q": Variable("relative", ("size", "joint"), "f8", "that configuration", np.nan, "joint"),
    "strongest": Variable("relative", ("size",), "f8", "the same of the worst set at the best configuration", _MOST),
    "strongest_set": Variable("relative", ("size",), "i4", "its worst set, by index", -1),
    "strongest_q": Variable("relative", ("size", "joint"), "f8", "that configuration", np.nan, "joint"),
    "map_count": Variable("relative", ("plane", "up", "across"), "i8", "configurations with the tool in each cell"),
    "map_sum": Variable("relative", ("plane", "up", "across"), "f8", "sum of what the worst joint leaves there"),
    "map_best": Variable(
        "relative", ("plane", "up", "across"), "f8", "the most that the worst joint leaves there", largest=True
    ),
    "speed": Variable("speed", ("speed_bin",), "i8", "histogram of the speed in every direction, with all joints"),
    "speed_joint": Variable("speed", ("joint", "speed_bin"), "i8", "the same without each joint"),
    "speed_worst": Variable("speed", ("size", "speed_bin"), "i8", "the same without the worst set of each size"),
    "depth": Variable("depth", ("losses",), "i8", "configurations by how many joints they can lose"),
    "reach_before": Variable("reach", (), "i8", "poses reached with all joints"),
    "reach_after": Variable("reach", ("set",), "i8", "poses reached without each set of joints"),
    "slice_before": Variable("positions", _SLICE, "i1", "1: all joints reach the middle of the cell", largest=True),
    "slice_tried": Variable("positions", _SLICE, "i4", "how often joints were locked to reach it again"),
    "slice_after": Variable("positions", ("joint", *_SLICE), "i4", "how often it was reached without each joint"),
    "cloud_before": Variable("cloud", _CLOUD, "i1", "1: all joints reach the middle of the cell", largest=True),
    "cloud_tried": Variable("cloud", _CLOUD, "i4", "how often joints were locked to reach it again"),
    "cloud_after": Variable("cloud", ("joint", *_CLOUD), "i4", "how often it was reached without each joint"),
}
ALL = {
    "counts": Variable("", (), "?", "whether the configuration counts: its pose is reached"),
    "q": Variable("", ("joint",), "f8", "joint positions", np.nan, "joint"),
    "every_relative": Variable("relative", ("set",), "f8", "relative manipulability without each set", np.nan),
    "every_speed": Variable("speed", (), "f8", "speed in every direction with all joints", np.nan, "m/s, rad/s"),
    "every_speed_after": Variable("speed", ("set",), "f8", "the same without each set", np.nan, "m/s, rad/s"),
    "every_depth": Variable("depth", (), "i1", "how many joints can fail; -1: already singular", -2),
    "goal": Variable("reach", ("joint",), "f8", "configuration whose pose is to be reached", np.nan, "joint"),
    "every_reach_before": Variable("reach", (), "?", "whether the goal is reached with all joints"),
    "every_reach_after": Variable("reach", ("set",), "?", "whether it is reached without each set"),
}


def variables(plan: Plan, table: dict[str, Variable]) -> dict[str, Variable]:
    """Those that a survey has; of ALL without ``keep="all"`` only which of the given poses are reached."""
    if table is ALL and plan.keep != "all":
        return {"counts": ALL["counts"]} if plan.kind == "poses" else {}
    space = ["cloud"] if plan.region is not None and plan.region.cloud is not None else []
    return {name: entry for name, entry in table.items() if entry.metric in ("", *plan.metrics, *space)}


def lengths(plan: Plan) -> dict[str, int]:
    """Of the dimensions."""
    return {
        "chunk": plan.chunks,
        "configuration": plan.count,
        "joint": plan.arm.n,
        "set": len(plan.sets),
        "size": plan.k,
        "bin": BINS,
        "speed_bin": len(SPEEDS) + 1,
        "losses": plan.k + 2,
        "plane": len(PLANES),
        "up": CELLS,
        "across": CELLS,
        **dict.fromkeys(_SLICE, CELLS_OF_SLICE),
        **dict.fromkeys(_CLOUD, CELLS_OF_CLOUD),
    }


def coordinates(plan: Plan) -> dict[str, tuple[str, npt.NDArray[Any], str]]:
    """Labels: dimension, values and meaning by name."""
    names = plan.arm.joint_names
    reach = plan.arm.reach
    middles = reach * ((2.0 * np.arange(CELLS) + 1.0) / CELLS - 1.0)
    found: dict[str, tuple[str, npt.NDArray[Any], str]] = {
        "joint": ("joint", np.array(names), "joint"),
        "joint_unit": ("joint", np.array(plan.arm.joint_units), "unit of the joint's position"),
        "set": ("set", np.array(["+".join(names[j] for j in joints) for joints in plan.sets]), "joints that fail"),
        "set_size": ("set", np.array([len(joints) for joints in plan.sets], dtype=np.int32), "how many these are"),
        "size": ("size", np.arange(1, plan.k + 1, dtype=np.int32), "joints that fail together"),
        "bin": ("bin", EDGES[:-1], "lower edge of the bin"),
        "speed_bin": ("speed_bin", np.array([0.0, *SPEEDS]), "lower edge of the bin [m/s, rad/s]"),
        "losses": ("losses", np.arange(-1, plan.k + 1, dtype=np.int32), "joints that can fail; -1: already singular"),
        "plane": ("plane", np.array(PLANES), "axes of a map of the tool's position"),
        "up": ("up", middles, "second axis, middle of the cell [m]"),
        "across": ("across", middles, "first axis, middle of the cell [m]"),
    }
    region = plan.region
    if region is not None:
        for dims, cells in ((_SLICE, region.slice), (_CLOUD, region.cloud)):
            if cells is not None:
                for dim, axis in zip(dims, reversed(cells.axes), strict=True):
                    found[dim] = (dim, cells.middles(axis), f"{'xyz'[axis]} of the middle of the cell [m]")
    return found


def size_in_bytes(plan: Plan) -> int:
    """Of the arrays of a whole survey, before compression."""
    lengths_of, total = lengths(plan), 0
    for table, first in ((REDUCED, plan.chunks), (ALL, plan.count)):
        for entry in variables(plan, table).values():
            numbers = first
            for dim in entry.dims:
                numbers *= lengths_of[dim]
            total += numbers * np.dtype(entry.dtype).itemsize
    return total


def empty(plan: Plan, table: dict[str, Variable], first: int | None) -> Arrays:
    """Arrays of a chunk before a configuration counts; first: the length of their first axis, or None for none."""
    sizes = lengths(plan)
    return {
        name: np.full(
            (*(() if first is None else (first,)), *(sizes[dim] for dim in entry.dims)), entry.empty, dtype=entry.dtype
        )
        for name, entry in variables(plan, table).items()
    }


def quantile(histogram: FloatArray, edges: FloatArray, part: float) -> float:
    """The value below which so large a part of a histogram lies, in its bin by proportion; NaN for an empty one.

    The first bin holds what is too small to be told from 0.
    """
    total = float(histogram.sum())
    if total == 0.0:
        return float("nan")
    rising = np.cumsum(histogram)
    place = min(int(np.searchsorted(rising, part * total)), len(histogram) - 1)
    if place == 0:
        return float(edges[0])
    inside = (part * total - (rising[place] - histogram[place])) / max(float(histogram[place]), 1.0)
    low, high = edges[place], edges[place + 1]
    return float(low + (high - low) * min(max(inside, 0.0), 1.0))
