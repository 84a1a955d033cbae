"""What `stillreach inspect` prints for a person."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from stillreach._door import FloatArray
    from stillreach.arm import Arm
    from stillreach.arm.losses import Losses


def print_inspection(source: str, found: Losses) -> None:
    """Joints, what the arm can do at a configuration, what it loses with each joint, and a verdict."""
    from stillreach._words import shown_length
    from stillreach.arm.describe import headline
    from stillreach.arm.losses import HEAD
    from stillreach.cli._terminal import console, print_table, table

    out, arm = console(), found.arm
    out.print(f"{headline(arm)}\n")
    print_table(_joint_table(arm))
    place = ", ".join(shown_length(x) for x in arm.forward(found.q)[:3, 3])
    out.print(f"\n{source[0].upper()}{source[1:]}: the tool is at ({place}).")
    for line in _mobility(found):
        out.print(line)
    out.print("\nIf one joint is locked there:\n", style="bold")
    made = table(*HEAD, right=(1, 2, 3, 4), wrap=(0, 5))
    for row, loss in zip(found.table(), found.by_joint.values(), strict=True):
        lost = row[-1].replace(" - ", " -").replace(" + ", " +")  # a line does not end with a sign
        made.add_row(*row[:-1], lost, style="red" if len(loss.lost) else None)
    print_table(made)
    for line in ("", *found.legend(), "", found.verdict):
        out.print(line)


def _mobility(found: Losses) -> list[str]:
    """What the tool can do with all joints, in lines."""
    from stillreach._labels import TWIST

    rows, along = found.rows, ", tool axes" if found.frame == "tool" else ""
    lines = []
    if len(rows) < 6 or along:
        lines.append(f"The task is {', '.join(TWIST.names[row] for row in rows)}{along}.")
    kept = list(found.singular_values[: found.rank])
    values = " ".join([*(f"{value:.3g}" for value in kept), *["0"] * (len(rows) - len(kept))])
    lines.append(f"Singular values of the Jacobian [m, rad]: {values}")
    if found.rank < len(rows):
        why = "it has too few joints for more" if found.rank == found.arm.n else "--q looks elsewhere"
        lines.append(f"The tool can move in {found.rank} of {len(rows)} directions here; {why}.")
    return lines


def _joint_table(arm: Arm) -> Table:
    from stillreach._words import shown
    from stillreach.arm.describe import axes_at_zero
    from stillreach.cli._terminal import table

    made = table("joint", "kind", "axis at zero", "range", "rate limit", right=(4,), wrap=(0,))
    for joint, axis, unit in zip(arm.joints, axes_at_zero(arm), arm.joint_units, strict=True):
        rate = "none" if joint.velocity_limit == float("inf") else shown(joint.velocity_limit, unit, rate=True)
        made.add_row(str(joint.name), joint.kind, _axis(axis), _range(joint.position_limits, unit), rate)
    return made


def _axis(axis: FloatArray) -> str:
    """An axis in words: ``+z``, or its components."""
    for k, name in enumerate("xyz"):
        if abs(abs(axis[k]) - 1.0) < 5e-4:
            return f"{'+' if axis[k] > 0 else '-'}{name}"
    return " ".join(f"{part + 0.0:.2f}" for part in axis.round(3))


def _range(limits: tuple[float, float], unit: str) -> str:
    import math

    from stillreach._words import shown, tidy

    if all(math.isinf(limit) for limit in limits):
        return "free"
    factor = math.degrees(1.0) if unit == "rad" else 1000.0
    lower, upper = (tidy(limit * factor) if math.isfinite(limit) else "free" for limit in limits)
    return f"{lower} … {upper} {shown(0.0, unit)[2:]}"
