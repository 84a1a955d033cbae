"""`stillreach paper`: reproduces the paper's examples, figures and claims."""

from pathlib import Path
from typing import Annotated

import typer


def paper(
    out: Annotated[Path, typer.Option(help="Folder for figures, runs, claims and report.")] = Path("out/paper"),
    step: Annotated[float, typer.Option(help="Time step, in seconds.")] = 0.05,
    duration: Annotated[
        float, typer.Option(help="Duration of each run, in seconds; the commanded velocity stays the paper's.")
    ] = 20.0,
    lengths: Annotated[
        str | None,
        typer.Option(
            help="Six segment lengths in metres, separated by commas; by default those explained in the report."
        ),
    ] = None,
) -> None:
    """Reproduce the paper: examples, figures and claims.

    Runs both examples of the paper, draws its figures 1 to 12 and prints its statements beside measured values.
    Exits with 1 if the result of a statement differs from docs/paper.md.
    """
    segment_lengths = None if lengths is None else _parse_lengths(lengths)

    from stillreach.cli._terminal import console, note
    from stillreach.paper import reproduce

    try:
        expected = reproduce(out, step=step, duration=duration, lengths=segment_lengths, console=console(markup=True))
    except KeyboardInterrupt:
        note(f"interrupted; finished files stay in {out}")
        raise
    if not expected:
        raise typer.Exit(1)


def _parse_lengths(text: str) -> list[float]:
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise typer.BadParameter(
            f"{text!r} is not a list of numbers separated by commas, like 0.762,0.762", param_hint="'--lengths'"
        ) from None
