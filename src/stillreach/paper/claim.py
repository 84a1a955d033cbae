"""A judged statement, and the list that the statements of ``stillreach.paper.claims`` register in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from stillreach.paper.evidence import Evidence

Measured = float | None | list[float | None]
Verdict = tuple[float | list[float], bool]
Judge = Callable[[Evidence], Verdict]

DIGITS = 5
"""Significant digits of measured values in the table and the file."""


class Group(StrEnum):
    """How a statement stands."""

    REPRODUCED = "reproduced"
    NOT_REPRODUCED = "not reproduced"
    REFUTED = "refuted"
    OURS = "ours"


@dataclass(frozen=True)
class Claim:
    """A judged statement.

    Attributes:
        id: short name, stable.
        group: how it stands.
        statement: what is claimed.
        paper: the paper's words; "-" for ours.
        measured: number or numbers; None where a value does not exist.
        unit: of what was measured.
        holds: whether the measured values bear the statement out.
        as_documented: whether docs/paper.md lists it in this group, at the default step, duration and lengths.
    """

    id: str
    group: Group
    statement: str
    paper: str
    measured: Measured
    unit: str
    holds: bool
    as_documented: bool


@dataclass(frozen=True)
class _Statement:
    """What is claimed, how docs/paper.md says that it stands, and its judge."""

    id: str
    documented: Group
    statement: str
    paper: str
    unit: str
    judge: Judge

    def judged(self, evidence: Evidence) -> Claim:
        measured, holds = self.judge(evidence)
        group = self.documented
        if group is not Group.OURS and holds != (group is Group.REPRODUCED):
            group = Group.REPRODUCED if holds else Group.NOT_REPRODUCED
        documented = group is self.documented and (holds or group is not Group.OURS)
        return Claim(self.id, group, self.statement, self.paper, _rounded(measured), self.unit, bool(holds), documented)


_STATEMENTS: list[_Statement] = []


def judged(evidence: Evidence) -> list[Claim]:
    """All claims, by group, in the paper's order."""
    claims = [statement.judged(evidence) for statement in _STATEMENTS]
    return [claim for group in Group for claim in claims if claim.group is group]


def as_json(claims: list[Claim]) -> list[dict[str, Any]]:
    """The claims as the list that ``claims.json`` holds."""
    return [asdict(claim) for claim in claims]


def claim(
    id: str,  # noqa: A002
    group: Group,
    statement: str,
    unit: str,
    *,
    paper: str = "-",
) -> Callable[[Judge], Judge]:
    """Registers the function below it as the judge of a statement."""

    def register(judge: Judge) -> Judge:
        _STATEMENTS.append(_Statement(id, group, statement, paper, unit, judge))
        return judge

    return register


def _rounded(measured: float | list[float]) -> Measured:
    """To DIGITS; a value that does not exist, such as the time of an event that never happens, becomes None."""
    if isinstance(measured, list):
        return [_rounded_number(value) for value in measured]
    return _rounded_number(measured)


def _rounded_number(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None
