"""What the paper states, each as a small function of the saved runs: measured, and whether it holds.

``paper`` holds what its text says. Where it starts with "inferred" the text gives no number: the value is one of
those that the inferred parts (lengths, start of example 2, commands; see ``notes``) were settled by.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from stillreach.paper import examples, measure
from stillreach.paper.evidence import Evidence
from stillreach.paper.examples import RATE_LIMIT

Measured = float | None | list[float | None]
Verdict = tuple[float | list[float], bool]
Judgement = Callable[[Evidence], Verdict]

FASTER = 20.0
"""The commands of example 1 are asked for so many times as fast where limits shall bite."""

DIGITS = 5
"""Significant digits of measured values in the table and the file."""


@dataclass(frozen=True)
class Claim:
    """A judged statement.

    Attributes:
        id: short name, stable.
        statement: what is claimed.
        paper: what the paper says, or which inferred value it is compared to.
        measured: number or numbers; None where there is none.
        unit: of what was measured.
        holds: whether the measured values bear the statement out.
    """

    id: str
    statement: str
    paper: str
    measured: Measured
    unit: str
    holds: bool


_JUDGEMENTS: list[tuple[dict[str, str], Judgement]] = []


def judged(evidence: Evidence) -> list[Claim]:
    """All claims, in the paper's order."""
    claims = []
    for texts, judge in _JUDGEMENTS:
        measured, holds = judge(evidence)
        claims.append(Claim(**texts, measured=_rounded(measured), holds=bool(holds)))
    return claims


def as_json(claims: list[Claim]) -> list[dict[str, Any]]:
    """The claims as the list that ``claims.json`` holds."""
    return [asdict(claim) for claim in claims]


def _claim(id: str, statement: str, paper: str, unit: str) -> Callable[[Judgement], Judgement]:  # noqa: A002
    """Registers the function below it as the judge of a statement."""

    def register(judge: Judgement) -> Judgement:
        _JUDGEMENTS.append(({"id": id, "statement": statement, "paper": paper, "unit": unit}, judge))
        return judge

    return register


def _rounded(measured: float | list[float]) -> Measured:
    """To DIGITS; a number that there is none of, like the time of what never happens, becomes None."""
    if isinstance(measured, list):
        return [_rounded_number(value) for value in measured]
    return _rounded_number(measured)


def _rounded_number(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None


@_claim(
    "example-1-start",
    "Example 1 starts with the tool at (113.2, 53.2, 73.4) in",
    "inferred: (113.2, 53.2, 73.4)",
    "in",
)
def _example_1_start(of: Evidence) -> Verdict:
    start = measure.tool_start(of[examples.EXAMPLE_1_FREE])
    return start.tolist(), bool(np.all(np.abs(start - (113.2, 53.2, 73.4)) <= 0.05))


@_claim("example-1-end", "Example 1 ends with the tool at (3.4, 2.8, 103) in", "inferred: (3.4, 2.8, 103)", "in")
def _example_1_end(of: Evidence) -> Verdict:
    end = measure.tool_end(of[examples.EXAMPLE_1_FREE])
    return end.tolist(), bool(np.all(np.abs(end - (3.4, 2.8, 103.0)) <= (0.05, 0.05, 0.5)))


@_claim("example-1-free-rate", "Largest rate of example 1 with all joints free", "inferred: 10.2", "deg/s")
def _example_1_free_rate(of: Evidence) -> Verdict:
    rate = measure.largest_rate(of[examples.EXAMPLE_1_FREE])
    return rate, abs(rate - 10.2) <= 0.05


@_claim("example-1-failed-rate", "Largest rate of example 1 with joints 1, 6, 7 failed", "inferred: 18.1", "deg/s")
def _example_1_failed_rate(of: Evidence) -> Verdict:
    rate = measure.largest_rate(of[examples.EXAMPLE_1_FAILED])
    return rate, abs(rate - 18.1) <= 0.05


@_claim(
    "example-1-same-path",
    "Example 1: with joints 1, 6, 7 failed the tool takes the same path; the difference halves with the Euler step",
    "the same motion; inferred: 0.59 apart at 0.05 s",
    "in",
)
def _example_1_same_path(of: Evidence) -> Verdict:
    free, failed = of.by_step[examples.EXAMPLE_1_FREE], of.by_step[examples.EXAMPLE_1_FAILED]
    distances = [measure.apart(free[step], failed[step]) for step in free]
    ratios = np.array(distances[:-1]) / distances[1:]
    return distances, bool(np.all(np.abs(ratios - 2.0) < 0.1))


@_claim("example-1-no-damping", "Example 1: eq. (9) asks for no damping", "κ = 0", "1")
def _example_1_no_damping(of: Evidence) -> Verdict:
    largest = max(float(np.max(of[name].damping)) for name in (examples.EXAMPLE_1_FREE, examples.EXAMPLE_1_FAILED))
    return largest, largest == 0.0


@_claim("example-2-free-rate", "Example 2, all joints free: the largest rate stays below 6 deg/s", "below 6", "deg/s")
def _example_2_free_rate(of: Evidence) -> Verdict:
    rate = measure.largest_rate(of[examples.EXAMPLE_2_FREE])
    return rate, rate < 6.0


@_claim(
    "example-2-free-singular-value",
    "Example 2, all joints free: the arm stays away from singularities",
    "inferred: smallest singular value 0.41 (metres, radians)",
    "1",
)
def _example_2_free_singular_value(of: Evidence) -> Verdict:
    value = measure.smallest_singular_value(of.arm, of[examples.EXAMPLE_2_FREE])
    return value, abs(value - 0.41) <= 0.005


@_claim(
    "example-2-pseudoinverse-passes-limit",
    "Example 2, joints 2, 4, 7 failed, pseudoinverse: the rates pass 50 deg/s at about 2 s",
    "about 2",
    "s",
)
def _example_2_passes_limit(of: Evidence) -> Verdict:
    when = measure.passes(of[examples.EXAMPLE_2_PSEUDOINVERSE], RATE_LIMIT)
    return when, 1.5 <= when <= 2.5


@_claim(
    "example-2-pseudoinverse-peak",
    "Failed, pseudoinverse: past the singularity rates exceed 400 deg/s (how far depends on the step)",
    "up to 400",
    "deg/s",
)
def _example_2_peak(of: Evidence) -> Verdict:
    peak = measure.largest_rate(of[examples.EXAMPLE_2_PSEUDOINVERSE])
    return peak, peak > 400.0


@_claim(
    "example-2-pseudoinverse-leaves-line",
    "Failed, pseudoinverse: the tool leaves the commanded line (how far depends on the step)",
    "somewhat",
    "in",
)
def _example_2_leaves_line(of: Evidence) -> Verdict:
    distance = measure.off_the_line(of[examples.EXAMPLE_2_PSEUDOINVERSE])
    return distance, distance > 1.0


@_claim(
    "example-2-closed-form-rate",
    "Failed, singularity-robust law: all rates stay below 50 deg/s",
    "below 50",
    "deg/s",
)
def _example_2_closed_form_rate(of: Evidence) -> Verdict:
    rate = measure.largest_rate(of[examples.EXAMPLE_2_CLOSED_FORM])
    return rate, rate <= RATE_LIMIT


@_claim(
    "example-2-closed-form-halfway",
    "Failed, singularity-robust law: the tool goes about half of the commanded -100 in",
    "about halfway",
    "in",
)
def _example_2_halfway(of: Evidence) -> Verdict:
    along = float(measure.displacement(of[examples.EXAMPLE_2_CLOSED_FORM])[0])
    return along, -60.0 <= along <= -40.0


@_claim(
    "example-2-closed-form-deviation",
    "Failed, singularity-robust law: the tool deviates in x, z and pitch only (x, y, z, pitch, yaw, roll)",
    "x, z and pitch only; inferred: z -37 in, pitch -13 deg",
    "in, deg",
)
def _example_2_deviation(of: Evidence) -> Verdict:
    x, y, z, pitch, yaw, roll = measure.deviation(of[examples.EXAMPLE_2_CLOSED_FORM])
    planar = max(abs(y), abs(yaw), abs(roll)) < 1e-3
    return [x, y, z, pitch, yaw, roll], planar and x > 40.0 and abs(z + 37.0) <= 0.5 and abs(pitch + 13.0) <= 0.5


@_claim(
    "example-2-closed-form-damping",
    "Failed: the closed-form damping factor stays below 0.006 (inches, degrees)",
    "inferred: below 0.006",
    "1",
)
def _example_2_closed_form_damping(of: Evidence) -> Verdict:
    largest = float(np.max(of[examples.EXAMPLE_2_CLOSED_FORM].damping))
    return largest, 0.0 < largest < 0.006


@_claim(
    "example-2-closed-form-conservative",
    "Failed: the exact damping factor is several times smaller than the closed-form one (medians)",
    "an upper bound; inferred: 5 to 25 times in the plane",
    "1",
)
def _example_2_conservative(of: Evidence) -> Verdict:
    closed_form = measure.median_damping(of[examples.EXAMPLE_2_CLOSED_FORM])
    ratio = closed_form / measure.median_damping(of[examples.EXAMPLE_2_EXACT])
    return ratio, ratio > 4.0


@_claim(
    "deviation-not-minimal",
    f"Eq. (9), (10), ∞-norm: least squares inside the limits has less error (example 1, {FASTER:g} x as fast, median)",
    "they minimise the deviation: not so",
    "% less",
)
def _deviation_not_minimal(of: Evidence) -> Verdict:
    saved = measure.error_above_the_optimum(of.arm, of[examples.EXAMPLE_1_FAILED], FASTER)
    median = float(np.median(saved)) if len(saved) else 0.0
    return 100.0 * median, median > 0.05 and bool(np.min(saved) > -1e-9)


@_claim(
    "stillreach-finishes",
    "Failed, stillreach: the whole -100 in, at most 0.3 in and 0.1 deg off the commanded pose",
    "not in the paper: its law stops halfway",
    "in, in, deg",
)
def _stillreach_finishes(of: Evidence) -> Verdict:
    run = of[examples.EXAMPLE_2_STILLREACH]
    distance, angle = (float(np.max(values)) for values in measure.off_target(run))
    along = float(measure.displacement(run)[0])
    return [along, distance, angle], abs(along + 100.0) < 0.3 and distance < 0.3 and angle < 0.1


@_claim(
    "rate-limit",
    "Every run but the pseudoinverse's without limit: all rates are inside their bounds at every tick",
    "the law's purpose",
    "deg/s",
)
def _rate_limit(of: Evidence) -> Verdict:
    bounded = [run for name, run in of.runs.items() if name not in examples.UNLIMITED]
    inside = all(bool(np.all((run.rates >= run.lower) & (run.rates <= run.upper))) for run in bounded)
    largest = max(measure.largest_rate(run) for run in bounded)
    return largest, inside and largest <= RATE_LIMIT * (1 + 1e-15)


@_claim("failed-joints-at-rest", "Every run: failed joints have a rate of exactly 0 and do not move", "eq. (2)", "rad")
def _failed_joints_at_rest(of: Evidence) -> Verdict:
    moved = 0.0
    for name, run in of.runs.items():
        failed = [run.joint_names.index(joint) for joint in _failed(name)]
        if failed:
            moved = max(
                moved, float(np.max(np.abs(run.rates[:, failed]))), float(np.max(np.ptp(run.q[:, failed], axis=0)))
            )
    return moved, moved == 0.0


def _failed(name: str) -> tuple[str, ...]:
    if name == examples.EXAMPLE_1_FAILED:
        return examples.FAILED_1
    return examples.FAILED_2 if name.startswith("example-2-failed") else ()
