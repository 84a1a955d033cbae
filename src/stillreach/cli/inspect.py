"""`stillreach inspect`: what an arm is, and what it loses with each joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from stillreach.cli._complete import complete_robot

if TYPE_CHECKING:
    from rich.table import Table

    from stillreach._door import FloatArray
    from stillreach.arm import Arm
    from stillreach.cli._locks import Insight


def inspect(
    robot: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT",
            help="A URDF or MJCF file, - for standard input, or a built-in arm.",
            autocompletion=complete_robot,
        ),
    ],
    tip: Annotated[str | None, typer.Option(help="Link (URDF), body or site (MJCF) that carries the tool.")] = None,
    base: Annotated[str | None, typer.Option(help="Link or body that the chain starts from.")] = None,
    fixed: Annotated[
        list[str] | None,
        typer.Option(metavar="JOINT=VALUE", help="Hold a joint of the chain there; it is then no joint of the arm."),
    ] = None,
    q: Annotated[
        str | None,
        typer.Option(
            "--q",
            metavar="VALUES",
            help="Where to look: values or joint=value pairs separated by commas, in rad and m or with a unit "
            "(-90deg, 50mm); zero; or middle (of the limits), the default.",
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> None:
    """Show an arm and what it loses with each joint.

    Prints joints, axes, limits and reach; and at a configuration the singular values of the Jacobian, and what is left
    of them when one joint is locked.
    """
    from stillreach.cli._joints import assignments, configuration
    from stillreach.cli._locks import insight
    from stillreach.cli._robots import load_arm
    from stillreach.cli._terminal import print_json

    arm = load_arm(robot, tip=tip, base=base, fixed=assignments("--fixed", fixed or []))
    at, source = configuration(arm, q)
    found = insight(arm, at)
    if as_json:
        print_json(_facts(robot, arm, found))
    else:
        _print(arm, source, found)


def _facts(robot: str, arm: Arm, found: Insight) -> dict[str, Any]:
    """What --json prints; docs/command-line.md explains the keys."""
    axes = _axes(arm)
    return {
        "robot": robot,
        "name": arm.name,
        "reach": arm.reach,
        "joints": [
            {
                "name": joint.name,
                "kind": joint.kind,
                "unit": _unit(arm, i),
                "axis_at_zero": axes[i],
                "position_limits": joint.position_limits,
                "velocity_limit": joint.velocity_limit,
                "acceleration_limit": joint.acceleration_limit,
                "typical_manipulability_left": found.typical[i],
            }
            for i, joint in enumerate(arm.joints)
        ],
        "at": {
            "q": found.q,
            "pose": arm.forward(found.q),
            "singular_values": found.singular_values,
            "rank": found.rank,
            "locked": [
                {
                    "joint": lock.joint,
                    "singular_values": lock.singular_values,
                    "rank": lock.rank,
                    "manipulability_left": lock.manipulability,
                    "lost_directions": lock.lost,
                }
                for lock in found.locks
            ],
        },
    }


def _print(arm: Arm, source: str, found: Insight) -> None:
    from stillreach.cli._terminal import console, print_table
    from stillreach.show.words import shown_length

    out = console()
    slides = int(arm.kinds.sum())
    kinds = " + ".join(f"{k} {kind}" for k, kind in ((arm.n - slides, "revolute"), (slides, "prismatic")) if k)
    out.print(f"{arm.name}: {kinds} joint{'s' if arm.n > 1 else ''}, reach at most {shown_length(arm.reach)}\n")
    print_table(_joint_table(arm))
    place = ", ".join(shown_length(x) for x in arm.forward(found.q)[:3, 3])
    out.print(f"\n{source[0].upper()}{source[1:]}: the tool is at ({place}).")
    values = " ".join(f"{value:.3g}" for value in found.singular_values[: found.rank])
    out.print(f"Singular values of the Jacobian [m, rad]: {values}{' 0' * (6 - found.rank)}")
    if found.rank < 6:
        why = "it has too few joints for more" if found.rank == arm.n else "--q looks elsewhere"
        out.print(f"The tool can move in {found.rank} of 6 directions here; {why}.")
    out.print("\nIf one joint is locked there:\n", style="bold")
    print_table(_lock_table(arm, found))
    out.print("\nleft: manipulability without the joint, in per cent of the whole arm's")
    out.print("typical: the same, as the median over the arm's range")
    if any(len(lock.lost) for lock in found.locks):
        out.print("lost: tool motion [m/s, rad/s] that no joint makes any more")


def _joint_table(arm: Arm) -> Table:
    from stillreach.cli._terminal import table
    from stillreach.show.words import shown

    made = table("joint", "kind", "axis at zero", "range", "rate limit", right=(4,), wrap=(0,))
    for joint, axis, unit in zip(arm.joints, _axes(arm), (_unit(arm, i) for i in range(arm.n)), strict=True):
        rate = "none" if joint.velocity_limit == float("inf") else shown(joint.velocity_limit, unit, rate=True)
        made.add_row(str(joint.name), joint.kind, _axis(axis), _range(joint.position_limits, unit), rate)
    return made


def _lock_table(arm: Arm, found: Insight) -> Table:
    from stillreach.cli._locks import direction
    from stillreach.cli._terminal import table
    from stillreach.show.words import shown

    made = table("joint", "locked at", "smallest σ", "left", "typical", "lost", right=(1, 2, 3, 4), wrap=(0, 5))
    for i, lock in enumerate(found.locks):
        lost = "; ".join(direction(twist) for twist in lock.lost)
        smallest = lock.singular_values[found.rank - 1] if lock.rank >= found.rank else 0.0
        made.add_row(
            lock.joint,
            shown(found.q[i], _unit(arm, i)),
            f"{smallest:.3g}",
            f"{100 * lock.manipulability:.0f} %",
            f"{100 * found.typical[i]:.0f} %",
            lost or "-",
            style="red" if lost else None,
        )
    return made


def _axes(arm: Arm) -> FloatArray:
    """(n, 3) axes in the base frame with all joints at 0."""
    import numpy as np

    J = arm.jacobian(np.zeros(arm.n))
    return np.where(arm.kinds == 1, J[:3], J[3:]).T


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


def _unit(arm: Arm, i: int) -> str:
    return "m" if arm.kinds[i] else "rad"
