"""What every reader of recordings returns, and how the columns of a file are matched with an arm's joints."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stillreach._door import FloatArray
from stillreach._messages import did_you_mean, listed, short
from stillreach._units import ANGLES, LENGTHS
from stillreach.errors import InputError

SI = "SI"
"""The unit of a column in radians or metres, as its joint has it."""
UNIT = re.compile(r"\s*[\[(]\s*([^\])]*?)\s*[\])]\s*$")
"""``[deg]`` or ``(rad)`` at the end of a column's name."""
AFFIX = r"(?:q|pos|position|positions|joint_position|joint_positions|joint_state|state|actual|measured)"
SPELLINGS = {"degree": "deg", "degrees": "deg", "°": "deg", "radian": "rad", "radians": "rad"}


@dataclass(frozen=True)
class Samples:
    """Joint positions over time as a file holds them.

    Args:
        time: (T,) [s].
        columns: (T, n) in the arm's order, in the units of the file.
        units: of each column, ``"deg"``, ``"mm"`` …; empty where the file does not say it.
        row: what one sample is called in messages.
        first: number of the first sample.
        cut: whether the file ended before its end.
    """

    time: FloatArray
    columns: FloatArray
    units: tuple[str, ...]
    row: str = "row"
    first: int = 1
    cut: bool = False


def unit_of(column: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit: ``j4 [deg]`` gives ``j4`` and ``deg``."""
    found = UNIT.search(column)
    if found is None:
        return column.strip(), ""
    word = found[1].strip()
    return column[: found.start()].strip(), SPELLINGS.get(word.lower(), word)


def places(source: str, joints: Sequence[str], columns: Sequence[str], named: Mapping[str, str]) -> list[int]:
    """Where the joints are among the columns.

    A column is a joint's if it has its name, alone or with a word such as ``position`` before or behind it.

    Args:
        source: the file, for messages.
        joints: the arm's joints.
        columns: names in the file.
        named: the column of a joint that is called otherwise.

    Raises:
        InputError: if a joint has no column, or several.
    """
    bare = [unit_of(column)[0] for column in columns]
    found, missing = [], []
    for joint in joints:
        if joint in named:
            wanted = unit_of(named[joint])[0]
            here = [k for k, name in enumerate(bare) if name == wanted]
        else:
            pattern = re.compile(
                rf"(?:{AFFIX}[._/ ])?{re.escape(joint)}(?:[._/ ]{AFFIX})?(?:_(?:rad|deg))?", re.IGNORECASE
            )
            here = [k for k, name in enumerate(bare) if name == joint] or [
                k for k, name in enumerate(bare) if pattern.fullmatch(name)
            ]
        if len(here) > 1:
            several = " and ".join(repr(columns[k]) for k in here[:3])
            raise InputError(
                "joints", f"{several} for {joint}", f"one of them: joints={{{joint!r}: {columns[here[0]]!r}}}"
            )
        missing += [] if here else [named.get(joint, joint)]
        found += here
    if missing:
        near = did_you_mean(missing[0], bare)
        raise InputError(
            "joints",
            f"no {listed(missing)} in {short(source)}, which has {listed(bare)}{near}",
            "a column for each joint of the arm; joints={'arm joint': 'column'} says what another name means",
        )
    return found


def column_unit(name: str) -> str:
    """The unit that a column's name says, or nothing: ``j4 [deg]``, ``j4_deg``."""
    bare, unit = unit_of(name)
    ending = re.search(r"_(rad|deg)$", bare, re.IGNORECASE)
    return unit or (ending[1].lower() if ending else "")


def in_si(
    samples: Samples, joints: Sequence[str], revolute: Sequence[bool], angle: str | None, length: str
) -> FloatArray:
    """The positions [rad] or [m].

    Raises:
        InputError: if a unit is unknown, or the file and the caller do not say it.
    """
    scales = np.ones(len(joints))
    for k, (joint, turns) in enumerate(zip(joints, revolute, strict=True)):
        unit = samples.units[k] or (angle if turns else length)
        if unit == SI:
            continue
        if unit is None:
            raise InputError(
                "angle", f"none, and the file does not say the unit of {joint}", 'angle="rad" or angle="deg"'
            )
        known = ANGLES if turns else LENGTHS
        if unit not in known:
            raise InputError("joints", f"the unit {short(unit)!r} of {joint}", f"one of {', '.join(known)}")
        scales[k] = known[unit]
    return samples.columns * scales
