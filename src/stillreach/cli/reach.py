"""`stillreach reach`: which poses an arm still reaches after it lost a joint."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stillreach.cli import _options as option
from stillreach.cli._poses import AngleOption, LengthOption, RowsOption, given_poses, ranges, rows_for
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.tolerance import ReachLeft


def reach(
    robot: option.Robot,
    poses: Annotated[
        Path | None,
        typer.Argument(metavar="[POSES]", help="A CSV file of the poses that the arm is for; by default random ones."),
    ] = None,
    tip: option.Tip = None,
    base: option.Base = None,
    fixed: option.Fixed = None,
    q: Annotated[str | None, option.configured("Where each joint is locked")] = None,
    outside: option.Outside = False,
    rows: RowsOption = None,
    frame: option.Frame = "base",
    length: LengthOption = None,
    angle: AngleOption = None,
    samples: Annotated[int | None, typer.Option(min=1, help="Number of random poses; by default 1000.")] = None,
    starts: Annotated[int, typer.Option(min=1, help="The most searches for a pose.")] = 100,
    seed: Annotated[int, typer.Option(min=0, help="Of the random poses and starts.")] = 1994,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE", help="Also write a CSV file: a row a pose, a column a joint."),
    ] = None,
    as_json: option.Json = False,
) -> None:
    """Show which poses an arm still reaches without a joint.

    The poses are those of a file with columns x, y, z and perhaps an attitude (qw, qx, qy, qz, or roll, pitch, yaw, or
    rx, ry, rz), or those of random configurations within the position limits. A pose counts as lost if no search of
    inverse kinematics reaches it.
    """
    from stillreach.arm.losses import best
    from stillreach.cli._joints import assignments, configuration
    from stillreach.cli._robots import load_arm
    from stillreach.cli._task import task_of
    from stillreach.cli._terminal import print_json
    from stillreach.tolerance import reach as reach_left

    if poses is not None and samples is not None:
        raise InputError("--samples", f"{samples} and a file of poses", "one of them")
    given = given_poses(poses, length=length, angle=angle)
    task = task_of(rows_for(rows, given), frame)
    arm = load_arm(robot, tip=tip, base=base, fixed=assignments("--fixed", fixed or []))
    at, source = configuration(arm, q, outside=outside)
    place = best(arm, task) if at is None else at
    places, count = (given.poses if given else None), samples or 1000
    left = reach_left(arm, place, poses=places, task=task, samples=count, starts=starts, seed=seed)
    lines = given.lines if given else None
    if output is not None:
        _write(output, left, lines)
    if as_json:
        print_json(_facts(robot, left, lines))
    else:
        _print(source, left, lines)


def _print(source: str, left: ReachLeft, lines: list[int] | None) -> None:
    from stillreach.cli._terminal import console, print_table, table
    from stillreach.tolerance.reach import HEAD

    out, total, reached = console(), len(left.poses), int(left.before.sum())
    name = left.arm.name
    what = f"{name} reaches {total if lines is None else f'{reached} of {total}'} pose{'s' if total > 1 else ''}."
    out.print(f"{what} With one joint locked {_where(source)}:\n")
    heads = HEAD if lines is None else (*HEAD, "lost, by line")
    made = table(*heads, right=(1, 2), wrap=(0, 3))
    for row in left.table():
        lost = [] if lines is None else [ranges([lines[k] for k in left.lost(row[0])])]
        made.add_row(*row, *lost)
    print_table(made)
    if lines is not None and reached < total:
        out.print(f"\nnot reached by the whole arm: line {ranges([lines[k] for k in (~left.before).nonzero()[0]])}")
    out.print(f"\n{left.verdict}")


def _where(source: str) -> str:
    return f"at its {source}" if source.startswith("best") else source


def _facts(robot: str, left: ReachLeft, lines: list[int] | None) -> dict[str, Any]:
    """The output of --json; docs/command-line.md explains the keys."""
    return {
        "robot": robot,
        "name": left.arm.name,
        "poses": len(left.poses),
        "reached": int(left.before.sum()),
        "joints": [
            {
                "name": name,
                "locked_at": left.q[i],
                "still_reached": result.share,
                **({"lost_lines": [lines[k] for k in left.lost(name)]} if lines else {}),
            }
            for i, (name, result) in enumerate(left.by_joint.items())
        ],
        "verdict": left.verdict,
    }


def _write(path: Path, left: ReachLeft, lines: list[int] | None) -> None:
    """A table of which pose is reached by the whole arm, and without each joint."""
    import csv
    import io

    from stillreach._files import new_file

    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["line" if lines else "pose", "x [m]", "y [m]", "z [m]", "all joints", *left.by_joint])
    numbers = lines or range(1, len(left.poses) + 1)
    for k, number in enumerate(numbers):
        reached = [left.before[k], *(result.reached[k] for result in left.by_joint.values())]
        writer.writerow([number, *map(float, left.poses[k, :3, 3]), *map(int, reached)])
    with new_file(path) as file:
        file.write(text.getvalue().encode())
