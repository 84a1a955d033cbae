"""The report: claims, figures and reading notes as one Markdown page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from stillreach.paper import examples, measure
from stillreach.paper.added import ADDED
from stillreach.paper.claims import Claim, Group, Measured
from stillreach.paper.evidence import Evidence
from stillreach.paper.notes import EQUATIONS, READING
from stillreach.paper.panels import Picture
from stillreach.paper.printed import PRINTED
from stillreach.simulation import Run

TITLE = "# Fault tolerant kinematic control of hyper-redundant manipulators: the paper, reproduced"
SOURCE = (
    "N. S. Bedrossian, *Fault tolerant kinematic control of hyper-redundant manipulators*, 1994. Every value below is "
    "measured on the runs beside this page (`*.nc`); `stillreach paper` makes both."
)
GROUPS = {
    Group.REPRODUCED: "Reproduced: the paper's statements, with the paper's values",
    Group.NOT_REPRODUCED: "Not reproduced, with any lengths and steps that were tried",
    Group.REFUTED: "Refuted",
    Group.OURS: "Ours: not in the paper",
}
STILLREACH = (
    "The column *stillreach* is the default law of this package, `LeastError()`, in closed loop on the "
    "commanded line (`track_gain=2`), with null motion on manipulability, five ticks in each step of the others. "
    "It leaves the plane, in which the three working pitch joints cannot make the motion, and goes all the way. "
    "Its damping factor is in metres and radians, the others' in inches and degrees."
)


def write(evidence: Evidence, claims: Sequence[Claim], path: Path) -> None:
    """Write the report to a file."""
    sections = [
        TITLE,
        SOURCE,
        "## What the paper states, and what is measured",
        *_by_group(claims),
        "## All laws side by side: example 2, joints 2, 4, 7 failed",
        STILLREACH,
        _side_by_side(evidence),
        "## What depends on the step",
        "Past the singularity the pseudoinverse's values are made by the size of the Euler step as much as by the arm.",
        _by_step(evidence),
        "## The paper's figures",
        *map(_shown_picture, PRINTED),
        "## Figures beside them",
        *map(_shown_picture, ADDED),
        "## How the paper was read",
        "\n".join(f"{place}. {note}" for place, note in enumerate(READING, start=1)),
        "## Where its equations are",
        _table(("equation", "what it says", "in stillreach"), EQUATIONS),
    ]
    path.write_text("\n\n".join(sections) + "\n", encoding="utf-8")


def shown(measured: Measured) -> str:
    """A measured value as text; what is a millionth of the largest beside it is 0."""
    values = measured if isinstance(measured, list) else [measured]
    nothing = 1e-6 * max((abs(value) for value in values if value is not None), default=0.0)
    return ", ".join("-" if value is None else _number(0.0 if abs(value) <= nothing else value) for value in values)


def _by_group(claims: Sequence[Claim]) -> Iterable[str]:
    """A heading and a table for each group that has claims."""
    for group, title in GROUPS.items():
        rows = [_claim_row(claim) for claim in claims if claim.group is group]
        if rows:
            yield f"### {title}"
            yield _table(("statement", "paper", "measured", "unit"), rows)


def _claim_row(claim: Claim) -> tuple[str, ...]:
    quoted = claim.paper if claim.group is Group.OURS else f'"{claim.paper}"'
    failed = " **(does not hold)**" if claim.group is Group.OURS and not claim.holds else ""
    return claim.statement + failed, quoted, shown(claim.measured), claim.unit


def _shown_picture(picture: Picture) -> str:
    return f"![{picture.caption}]({picture.file})\n\n*{picture.caption}*"


def _side_by_side(of: Evidence) -> str:
    """What each law makes of example 2 with joints 2, 4, 7 failed."""
    columns = {
        "pseudoinverse, no limit": examples.EXAMPLE_2_PSEUDOINVERSE,
        "closed form, eq. (16)": examples.EXAMPLE_2_CLOSED_FORM,
        "exact, eq. (10)": examples.EXAMPLE_2_EXACT,
        "stillreach": examples.EXAMPLE_2_STILLREACH,
    }
    rows: dict[str, Callable[[Run], float]] = {
        "motion along x [in], commanded -100": lambda run: measure.displacement(run)[0],
        "largest distance from the commanded pose [in]": lambda run: float(np.max(measure.off_target(run)[0])),
        "largest angle from the commanded pose [deg]": lambda run: float(np.max(measure.off_target(run)[1])),
        "largest rate [deg/s]": measure.largest_rate,
        "rate used while damped, median of the largest [deg/s]": measure.rate_used_while_damped,
        "task error summed over time [in, deg]": measure.error_of_the_task,
        "largest damping factor": lambda run: float(np.max(run.damping)),
        "median damping factor while damped": measure.median_damping,
        "largest jump of the damping factor": measure.largest_jump_of_damping,
        "total variation of the rates [deg/s]": measure.variation_of_the_rates,
    }
    body = ((label, *(_number(read(of[name])) for name in columns.values())) for label, read in rows.items())
    return _table(("", *columns), body)


def _by_step(of: Evidence) -> str:
    """The values that depend on the step, for each step."""
    runs = of.by_step[examples.EXAMPLE_2_PSEUDOINVERSE]
    closed_form, exact = of.by_step[examples.EXAMPLE_2_CLOSED_FORM], of.by_step[examples.EXAMPLE_2_EXACT]
    free, failed = of.by_step[examples.EXAMPLE_1_FREE], of.by_step[examples.EXAMPLE_1_FAILED]
    rows = {
        "example 1: distance between the tools, free and failed [in]": [
            measure.apart(free[h], failed[h])[0] for h in runs
        ],
        "example 2, pseudoinverse: 50 deg/s passed at [s]": [
            measure.passes(runs[h], examples.RATE_LIMIT) for h in runs
        ],
        "example 2, pseudoinverse: largest rate [deg/s]": [measure.largest_rate(runs[h]) for h in runs],
        "example 2, pseudoinverse: off the line [in]": [measure.off_the_line(runs[h]) for h in runs],
        "example 2, closed form: motion along x [in]": [measure.displacement(closed_form[h])[0] for h in runs],
        "example 2, exact: motion along x [in]": [measure.displacement(exact[h])[0] for h in runs],
        "example 2: closed-form over exact damping, medians": [
            measure.median_damping(closed_form[h]) / measure.median_damping(exact[h]) for h in runs
        ],
    }
    body = ((label, *map(_number, values)) for label, values in rows.items())
    return _table(("step [s]", *(f"{h:g}" for h in runs)), body)


def _number(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.4g}"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
