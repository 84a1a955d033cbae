"""What `stillreach inspect` prints for a person."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from stillreach._door import FloatArray
    from stillreach.arm import Arm
    from stillreach.cli._locks import Insight, Lock

NAMED = 4
"""Joints that a sentence names; of more, it says how many."""


def print_inspection(arm: Arm, source: str, found: Insight) -> None:
    """Joints, what the arm can do at a configuration, what it loses with each joint, and a verdict."""
    from stillreach.cli._terminal import console, print_table
    from stillreach.show.words import shown_length

    out = console()
    slides = int(arm.kinds.sum())
    kinds = " + ".join(f"{k} {kind}" for k, kind in ((arm.n - slides, "revolute"), (slides, "prismatic")) if k)
    out.print(f"{arm.name}: {kinds} joint{'s' if arm.n > 1 else ''}, reach at most {shown_length(arm.reach)}\n")
    print_table(_joint_table(arm))
    place = ", ".join(shown_length(x) for x in arm.forward(found.q)[:3, 3])
    out.print(f"\n{source[0].upper()}{source[1:]}: the tool is at ({place}).")
    for line in _mobility(arm, found):
        out.print(line)
    out.print("\nIf one joint is locked there:\n", style="bold")
    print_table(_lock_table(arm, found))
    for line in _legend(found):
        out.print(line)
    out.print(f"\n{verdict(arm, found)}")


def verdict(arm: Arm, found: Insight) -> str:
    """Which joint the arm can spare least, in words."""
    names = [lock.joint for lock in found.locks]
    always = [name for name, left in zip(names, found.typical, strict=True) if left == 0.0]
    here = [lock.joint for lock in found.locks if len(lock.lost)]
    if len(always) == arm.n:
        text = "This arm can spare no joint: without any of them the tool loses a direction over most of the range"
    elif always:
        text = f"What this arm can spare least {'is' if len(always) == 1 else 'are'} {_named(always, 'and')}: without "
        text += f"{'it' if len(always) == 1 else 'any of them'} the tool loses a direction over most of the range"
    else:
        worst = least_spared(found)
        left = _share(float(found.typical[names.index(worst)]))
        text = f"What this arm can spare least is {worst}: without it a median of {left} of the manipulability is left "
        text += "over the range"
    if here == always:
        return f"{text}."
    if not here:
        return f"{text}. Here it can spare any one joint."
    return f"{text}. Here it cannot spare {'any joint' if len(here) == arm.n else _named(here, 'or')}."


def least_spared(found: Insight) -> str:
    """The joint that leaves least over the arm's range, and among equals here."""
    order = [(left, lock.manipulability) for left, lock in zip(found.typical, found.locks, strict=True)]
    return found.locks[min(range(len(order)), key=order.__getitem__)].joint


def axes_at_zero(arm: Arm) -> FloatArray:
    """(n, 3) axes in the base frame with all joints at 0."""
    import numpy as np

    J = arm.jacobian(np.zeros(arm.n))
    return np.where(arm.kinds == 1, J[:3], J[3:]).T


def unit_of(arm: Arm, i: int) -> str:
    """Unit of a joint's value."""
    return "m" if arm.kinds[i] else "rad"


def _named(names: list[str], word: str) -> str:
    if len(names) > NAMED:
        return f"{', '.join(names[:NAMED])} {word} {len(names) - NAMED} more"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {word} {names[-1]}"


def _mobility(arm: Arm, found: Insight) -> list[str]:
    """What the tool can do with all joints, in lines."""
    from stillreach.cli._locks import COMPONENTS

    rows = found.gauge.task.indices
    along = ", tool axes" if found.gauge.task.frame == "tool" else ""
    lines = []
    if len(rows) < 6 or along:
        lines.append(f"The task is {', '.join(COMPONENTS[row] for row in rows)}{along}.")
    kept = list(found.singular_values[: found.rank])
    values = " ".join([*(f"{value:.3g}" for value in kept), *["0"] * (len(rows) - len(kept))])
    lines.append(f"Singular values of the Jacobian [m, rad]: {values}")
    if found.rank < len(rows):
        why = "it has too few joints for more" if found.rank == arm.n else "--q looks elsewhere"
        lines.append(f"The tool can move in {found.rank} of {len(rows)} directions here; {why}.")
    return lines


def _legend(found: Insight) -> list[str]:
    lines = [
        "",
        "left: manipulability without the joint, in per cent of the whole arm's",
        "typical: the same, as the median over the arm's range; lost: over most of it",
    ]
    if any(len(lock.lost) for lock in found.locks):
        lines += [
            "lost: direction [m/s, rad/s] in which all joints but this one, at full rates,",
            f"      give less than {_least(found)}",
        ]
    return lines


def _least(found: Insight) -> str:
    from stillreach.show.words import shown

    rows = found.gauge.task.indices
    parts = [shown(found.gauge.speed, "m", rate=True)] if min(rows) < 3 else []
    return " and ".join([*parts, shown(found.gauge.turn, "rad", rate=True)] if max(rows) >= 3 else parts)


def _joint_table(arm: Arm) -> Table:
    from stillreach.cli._terminal import table
    from stillreach.show.words import shown

    made = table("joint", "kind", "axis at zero", "range", "rate limit", right=(4,), wrap=(0,))
    for joint, axis, unit in zip(arm.joints, axes_at_zero(arm), (unit_of(arm, i) for i in range(arm.n)), strict=True):
        rate = "none" if joint.velocity_limit == float("inf") else shown(joint.velocity_limit, unit, rate=True)
        made.add_row(str(joint.name), joint.kind, _axis(axis), _range(joint.position_limits, unit), rate)
    return made


def _lock_table(arm: Arm, found: Insight) -> Table:
    from stillreach.cli._locks import direction
    from stillreach.cli._terminal import table
    from stillreach.show.words import shown

    made = table("joint", "locked at", "smallest σ", "left", "typical", "lost", right=(1, 2, 3, 4), wrap=(0, 5))
    for i, lock in enumerate(found.locks):
        lost = "; ".join(direction(twist, found.gauge.task.indices) for twist in lock.lost)
        lost = lost.replace(" - ", " -").replace(" + ", " +")  # a line does not end with a sign
        made.add_row(
            lock.joint,
            shown(found.q[i], unit_of(arm, i)),
            f"{_smallest(found, lock):.3g}",
            "0 %" if lost else _share(lock.manipulability),
            _share(float(found.typical[i])) if found.typical[i] else "lost",
            lost or "-",
            style="red" if lost else None,
        )
    return made


def _smallest(found: Insight, lock: Lock) -> float:
    """The smallest singular value of the directions that the whole arm serves; 0 where one of them is lost."""
    return float(lock.singular_values[found.rank - 1]) if 0 < found.rank == lock.rank else 0.0


def _share(share: float) -> str:
    """Per cent; what is more than nothing never reads 0 %."""
    return f"{100 * share:.0f} %" if share >= 0.01 else f"{100 * share:.1g} %"


def _axis(axis: FloatArray) -> str:
    """An axis in words: ``+z``, or its components."""
    for k, name in enumerate("xyz"):
        if abs(abs(axis[k]) - 1.0) < 5e-4:
            return f"{'+' if axis[k] > 0 else '-'}{name}"
    return " ".join(f"{part + 0.0:.2f}" for part in axis.round(3))


def _range(limits: tuple[float, float], unit: str) -> str:
    import math

    from stillreach.show.words import shown, tidy

    if all(math.isinf(limit) for limit in limits):
        return "free"
    factor = math.degrees(1.0) if unit == "rad" else 1000.0
    lower, upper = (tidy(limit * factor) if math.isfinite(limit) else "free" for limit in limits)
    return f"{lower} … {upper} {shown(0.0, unit)[2:]}"
