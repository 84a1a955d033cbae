"""A survey in words: the verdict, the table, the main numbers."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stillreach._words import joined, share
from stillreach.arm.relative import best_possible
from stillreach.tolerance.losses import MOST_FACETS, facets
from stillreach.tolerance.surveys.arrays import ALL, SPEED_EDGES, quantile, size_in_bytes, variables
from stillreach.tolerance.surveys.plan import Plan

if TYPE_CHECKING:
    from stillreach.tolerance.survey import Survey

HEADS = {
    "relative": ("remaining, median", "worst 5 %"),
    "speed": ("speed, median",),
    "reach": ("poses reached",),
    "positions": ("positions reached",),
}
"""Columns of the table by metric."""
LEAST_SHARE = 1e-4
"""Shares below are not told apart in the table."""


def verdict(of: Survey) -> str:
    """The main findings in words."""
    count = of.configurations
    if not count:
        lost = int(of.total("unreached"))
        return f"None of the {lost:,} poses is reached." if lost else "No configuration is done."
    parts = [unreached(of), _relative(of), _depth(of), _reach(of), positions(of), _left_out(of)]
    return " ".join(part for part in parts if part) or f"{counted(of)}."


def counted(of: Survey) -> str:
    """``1 configuration``."""
    return f"{of.configurations:,} configuration{'' if of.configurations == 1 else 's'}"


def unreached(of: Survey) -> str:
    """How many of the given poses are not reached; empty where all are."""
    lost = int(of.total("unreached"))
    if not lost:
        return ""
    verb = "is" if lost == 1 else "are"
    return f"{lost:,} of {of.configurations + lost:,} poses {verb} not reached and {verb} left out."


def _relative(of: Survey) -> str:
    if "relative" not in of.metrics:
        return ""
    left, names = of.remaining(), of.arm.joint_names
    if not np.isfinite(left).all():
        return "All configurations are singular."
    worst, best = int(np.argmin(left)), int(np.argmax(left))
    return (
        f"At the median of {counted(of)} the loss of {names[worst]} costs most, "
        f"{share(left[worst])} remaining, and that of {names[best]} least, {share(left[best])}."
    )


def _depth(of: Survey) -> str:
    if "depth" not in of.metrics:
        return ""
    any_one = float(of.total("depth")[2:].sum()) / of.configurations
    return f"In {share(any_one)} of them any one joint can fail without the loss of a direction."


def _reach(of: Survey) -> str:
    if "reach" not in of.metrics:
        return ""
    worst = int(np.argmin(of.reached))
    before = float(of.total("reach_before")) / of.configurations
    return (
        f"Of the poses of other configurations it reaches {share(before)} with all joints and "
        f"{share(float(of.reached[worst]))} without {joined(of.sets[worst], 'and')}."
    )


def positions(of: Survey) -> str:
    """What is left of the positions around the arm, in a sentence."""
    if "positions" not in of.metrics:
        return ""
    left, names = of.positions, of.arm.joint_names
    if np.isnan(left).all():
        return "No position around it was tried."
    worst, best = int(np.nanargmin(left)), int(np.nanargmax(left))
    text = f"Of the positions that it reaches with all joints, in any attitude, {share(left[worst])} stay within reach"
    if worst == best or share(left[worst]) == share(left[best]):
        return f"{text} without {'any one joint' if worst != best else names[worst]}."
    return f"{text} without {names[worst]} and {share(left[best])} without {names[best]}."


def _left_out(of: Survey) -> str:
    """Why an arm with many joints has no speeds; empty for others."""
    many = facets(of.arm.n, of.task.m)
    if many <= MOST_FACETS or "relative" not in of.metrics:
        return ""
    return f"Speed and depth are left out: with {of.arm.n} joints each configuration has {many:,} facets to look at."


def head(of: Survey) -> tuple[str, ...]:
    """Titles of the columns of the table."""
    return ("lost", *(title for metric in of.metrics for title in HEADS.get(metric, ())))


def table(of: Survey) -> list[tuple[str, ...]]:
    """Cells below the head: each joint, that whose loss costs most first."""
    rows = []
    by_set = dict(zip(of.sets, of.reached, strict=True)) if "reach" in of.metrics else {}
    for joint in of.ranking:
        name = of.arm.joint_names[joint]
        cells = [name]
        if "relative" in of.metrics:
            cells += [_or_dash(float(of.remaining(part)[joint])) for part in (0.5, 0.05)]
        if "speed" in of.metrics:
            cells.append(f"{quantile(of.total('speed_joint')[joint], SPEED_EDGES, 0.5):.3g}")
        if "reach" in of.metrics:
            cells.append(share(by_set[(name,)]) if (name,) in by_set else "-")
        if "positions" in of.metrics:
            cells.append(_or_dash(float(of.positions[joint])))
        rows.append(tuple(cells))
    return rows


def _or_dash(part: float) -> str:
    if 0.0 < part < LEAST_SHARE:
        return f"<{share(LEAST_SHARE)}"
    return "-" if np.isnan(part) else share(part)


def facts(of: Survey) -> dict[str, Any]:
    """The main numbers, for JSON."""
    names, count = of.arm.joint_names, max(of.configurations, 1)
    found: dict[str, Any] = {
        "name": of.arm.name,
        "configurations": of.configurations,
        "unreached": int(of.total("unreached")),
        "complete": of.complete,
        "metrics": list(of.metrics),
        "ranking": [names[joint] for joint in of.ranking],
        "verdict": of.verdict,
    }
    if "relative" in of.metrics:
        found["singular"] = int(of.total("singular"))
        found["remaining"] = _by_name(names, of.remaining())
        found["worst"] = [
            {"size": size + 1, "remaining": _or_none(float(left)), "best_possible": _bound(of, size + 1)}
            for size, left in enumerate(of.remaining_worst())
        ]
    if "speed" in of.metrics:
        found["speed"] = _or_none(quantile(of.total("speed"), SPEED_EDGES, 0.5))
    if "depth" in of.metrics:
        labels = ["singular", *map(str, range(len(of.total("depth")) - 1))]
        found["depth"] = dict(zip(labels, of.total("depth").tolist(), strict=True))
    if "reach" in of.metrics:
        found["reach_before"] = float(of.total("reach_before")) / count
        found["reach_after"] = {
            "+".join(joints): part for joints, part in zip(of.sets, of.reached.tolist(), strict=True)
        }
    if "positions" in of.metrics:
        found["positions_after"] = _by_name(names, of.positions)
    return found


def _by_name(names: tuple[str, ...], values: Any) -> dict[str, float | None]:
    return {name: _or_none(float(value)) for name, value in zip(names, values, strict=True)}


def _or_none(value: float) -> float | None:
    return None if np.isnan(value) else value


def _bound(of: Survey, size: int) -> float:
    m = of.task.m
    return best_possible(of.arm.n, m, size) if m <= of.arm.n else 0.0


def say_size(plan: Plan, folder: Path) -> None:
    """How much a survey that keeps all writes, on standard error."""
    if sys.stderr is not None:
        each = sum(1 for _ in variables(plan, ALL))
        size = f"{size_in_bytes(plan) / 1e6:,.0f} MB before compression"
        print(f"stillreach: {each} arrays of every configuration, {size}, go to {folder}", file=sys.stderr)
