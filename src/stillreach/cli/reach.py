"""`stillreach reach`: which poses an arm still reaches after it lost a joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from stillreach.cli._complete import complete_robot

if TYPE_CHECKING:
    from stillreach.tolerance import ReachLeft


def reach(
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
        typer.Option(metavar="JOINT=VALUE", help="Hold a joint of the chain, and leave it out of the arm."),
    ] = None,
    q: Annotated[
        str | None,
        typer.Option(
            "--q",
            metavar="VALUES",
            help="Where each joint is locked: values or joint=value pairs separated by commas, in rad and m or with a "
            "unit (-90deg, 50mm); zero; middle (of the limits); or best (default), where the tool moves best.",
        ),
    ] = None,
    outside: Annotated[bool, typer.Option("--outside", help="Accept --q outside the position limits.")] = False,
    rows: Annotated[
        str, typer.Option(help="The task: pose, position, orientation, or components like vx,vy,wz.")
    ] = "pose",
    frame: Annotated[str, typer.Option(help="Axes of these rows: base or tool.")] = "base",
    samples: Annotated[int, typer.Option(min=1, help="Number of poses.")] = 1000,
    starts: Annotated[int, typer.Option(min=1, help="The most searches for a pose.")] = 100,
    seed: Annotated[int, typer.Option(min=0, help="Of the random poses and starts.")] = 1994,
    as_json: Annotated[bool, typer.Option("--json", help="Print only JSON.")] = False,
) -> None:
    """Show which poses an arm still reaches without a joint.

    The poses are those of random configurations within the position limits. A pose counts as lost if no search of
    inverse kinematics reaches it.
    """
    from stillreach.arm.losses import best
    from stillreach.cli._joints import assignments, configuration
    from stillreach.cli._robots import load_arm
    from stillreach.cli._task import task_of
    from stillreach.cli._terminal import print_json
    from stillreach.tolerance import reach as reach_left

    task = task_of(rows, frame)
    arm = load_arm(robot, tip=tip, base=base, fixed=assignments("--fixed", fixed or []))
    at, source = configuration(arm, q, outside=outside)
    place = best(arm, task) if at is None else at
    left = reach_left(arm, place, task=task, samples=samples, starts=starts, seed=seed)
    if as_json:
        print_json(_facts(robot, left))
    else:
        _print(source, left)


def _print(source: str, left: ReachLeft) -> None:
    from stillreach.cli._terminal import console, print_table, table
    from stillreach.tolerance.reach import HEAD

    out = console()
    out.print(f"{len(left.poses)} poses that {left.arm.name} reaches, and one joint locked {_where(source)}:\n")
    made = table(*HEAD, right=(1, 2), wrap=(0,))
    for row in left.table():
        made.add_row(*row)
    print_table(made)
    out.print(f"\n{left.verdict}")


def _where(source: str) -> str:
    return f"at its {source}" if source.startswith("best") else source


def _facts(robot: str, left: ReachLeft) -> dict[str, Any]:
    """The output of --json; docs/command-line.md explains the keys."""
    return {
        "robot": robot,
        "name": left.arm.name,
        "poses": len(left.poses),
        "joints": [
            {"name": name, "locked_at": left.q[i], "still_reached": result.share}
            for i, (name, result) in enumerate(left.by_joint.items())
        ],
        "verdict": left.verdict,
    }
