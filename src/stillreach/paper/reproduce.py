"""One call that reproduces the paper into a folder."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy.typing as npt

from stillreach.paper import claims, evidence, figures, report
from stillreach.show.style import matplotlib_or_error

if TYPE_CHECKING:
    from rich.console import Console


def reproduce(
    out: str | os.PathLike[str],
    *,
    step: float = 0.05,
    duration: float = 20.0,
    lengths: npt.ArrayLike | None = None,
    console: Console | None = None,
) -> bool:
    """Run both examples of the paper, draw its figures and judge its statements.

    Writes ``figure-01.png`` to ``figure-12.png`` and six more, the runs (``example-….nc``), ``claims.json`` and
    ``report.md``. docs/paper.md says how the statements stand at the default step, duration and lengths; with others
    some can stand otherwise.

    Args:
        out: folder for everything; made if it is not there.
        step: period of the Euler steps [s].
        duration: of each run [s]; the commanded velocity is the paper's.
        lengths: (6,) [m] segments of the arm; None takes the inferred ones.
        console: where the table is printed; None is the terminal.

    Returns:
        Whether every statement stands as docs/paper.md says: reproduced, not reproduced, refuted, or ours.

    Raises:
        InputError: if step, duration or lengths is invalid.
        MissingExtraError: if matplotlib or the netCDF packages are not installed.
    """
    from rich.console import Console

    console = console or Console()
    folder = Path(out)
    matplotlib_or_error("stillreach paper")
    with console.status("simulating") as status:
        evidence.make(
            folder,
            step=step,
            duration=duration,
            lengths=lengths,
            on_run=lambda name: status.update(f"simulating {name}"),
        )
        saved = evidence.load(folder, step=step)
        status.update("judging the claims")
        judged = claims.judged(saved)
        text = json.dumps(claims.as_json(judged), indent=2, ensure_ascii=False, allow_nan=False)
        (folder / "claims.json").write_text(text + "\n", encoding="utf-8")
        status.update("drawing the figures")
        figures.write(saved, folder)
        report.write(saved, judged, folder / "report.md")
    _print(console, judged, folder)
    return all(claim.as_documented for claim in judged)


def _print(console: Console, judged: list[claims.Claim], folder: Path) -> None:
    from rich.table import Table

    table = Table(title="What the paper states, and what is measured", title_justify="left")
    for head in ("statement", "paper", "measured"):
        table.add_column(head)
    counts = []
    for group in claims.Group:
        members = [claim for claim in judged if claim.group is group]
        counts.append(f"{len(members)} {group}")
        if members:
            table.add_section()
            table.add_row(f"[bold]{group}[/]")
        for claim in members:
            mark = "" if claim.as_documented else "[bold red]✗[/] "
            unit = "" if claim.unit == "1" else f" {claim.unit}"
            table.add_row(mark + claim.statement, claim.paper, f"{report.shown(claim.measured)}{unit}")
    console.print(table)
    others = sum(not claim.as_documented for claim in judged)
    console.print(
        f"Statements: {', '.join(counts)}"
        + (f"; {others} stand otherwise than docs/paper.md says (✗)" if others else "")
        + f". Figures, runs and report: {folder / 'report.md'}",
        soft_wrap=True,
    )
