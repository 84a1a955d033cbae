"""`stillreach inspect`: an arm and the loss of each joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from stillreach.cli import _options as option

if TYPE_CHECKING:
    from stillreach.arm.losses import Losses


def inspect(
    robot: option.Robot,
    tip: option.Tip = None,
    base: option.Base = None,
    fixed: option.Fixed = None,
    q: Annotated[str | None, option.configured("Configuration")] = None,
    outside: option.Outside = False,
    rows: Annotated[
        str, typer.Option(help="The task: pose, position, orientation, or components like vx,vy,wz.")
    ] = "pose",
    frame: option.Frame = "base",
    lost_below: Annotated[
        str | None,
        typer.Option(
            metavar="LENGTH[,ANGLE]",
            help="Tool speeds, per second, below which a direction counts as lost; by default 1mm,0.1deg.",
        ),
    ] = None,
    together: Annotated[
        int | None,
        typer.Option("--together", "-k", min=1, help="Also the worst sets of up to so many joints, and speeds."),
    ] = None,
    as_json: option.Json = False,
) -> None:
    """Show an arm and the loss of each joint.

    Prints joints, axes, limits and reach. At a configuration, prints the singular values of the Jacobian, those
    without each joint, and the most critical joint.
    """
    from stillreach.cli._inspection import print_inspection
    from stillreach.cli._joints import assignments, configuration
    from stillreach.cli._robots import load_arm
    from stillreach.cli._task import lost_below as speeds
    from stillreach.cli._task import task_of
    from stillreach.cli._terminal import console, print_json
    from stillreach.tolerance import report

    task, least = task_of(rows, frame), speeds(lost_below)
    arm = load_arm(robot, tip=tip, base=base, fixed=assignments("--fixed", fixed or []))
    at, source = configuration(arm, q, outside=outside)
    found = arm.losses(at, task, lost_below=least)
    several = None if together is None else report(arm, found.q, k=together, task=task)
    if as_json:
        print_json({**_facts(robot, found), **({} if several is None else {"together": several.facts()})})
    else:
        print_inspection(source, found)
        if several is not None:
            console().print(f"\nIf up to {together} joints are locked there:\n", style="bold")
            console().print(str(several), soft_wrap=True)


def _facts(robot: str, found: Losses) -> dict[str, Any]:
    """The output of --json; docs/command-line.md explains the keys."""
    from stillreach._labels import TWIST
    from stillreach.arm.describe import axes_at_zero

    arm, axes = found.arm, axes_at_zero(found.arm)
    return {
        "robot": robot,
        "name": arm.name,
        "reach": arm.reach,
        "joints": [
            {
                "name": joint.name,
                "kind": joint.kind,
                "unit": arm.joint_units[i],
                "axis_at_zero": axes[i],
                "position_limits": joint.position_limits,
                "velocity_limit": joint.velocity_limit,
                "acceleration_limit": joint.acceleration_limit,
                "typical_manipulability_left": found.typical[i],
            }
            for i, joint in enumerate(arm.joints)
        ],
        "task": {"rows": [TWIST.names[row] for row in found.rows], "frame": found.frame},
        "lost_below": found.lost_below,
        "least_spared": found.least_spared,
        "verdict": found.verdict,
        "at": {
            "q": found.q,
            "pose": arm.forward(found.q),
            "singular_values": found.singular_values,
            "rank": found.rank,
            "locked": [
                {
                    "joint": loss.joint,
                    "singular_values": loss.singular_values,
                    "rank": loss.rank,
                    "manipulability_left": loss.remaining,
                    "lost_directions": loss.lost,
                }
                for loss in found.by_joint.values()
            ],
        },
    }
