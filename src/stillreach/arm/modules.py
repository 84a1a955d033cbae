"""Arms of roll and pitch modules (Bedrossian, 1994): one letter for each joint, one length for each segment."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from stillreach import _door
from stillreach._door import FloatArray
from stillreach.arm.joint import Joint
from stillreach.arm.placements import translation
from stillreach.errors import InputError

ROLL_AXIS = (0.0, 0.0, 1.0)
PITCH_AXIS = (0.0, -1.0, 0.0)


def module_chain(sequence: str, lengths: npt.ArrayLike) -> tuple[list[Joint], FloatArray]:
    """Joints and tool of a modular arm that stands straight up along +z when all its joints are at 0.

    Pitch joints (P, about -y: positive leans towards -x) divide the arm into segments; a roll joint (R, about
    z) sits in the middle of its segment.

    Args:
        sequence: letters R and P from base to tool, e.g. ``"RPRPRPRPRPR"``.
        lengths: (number of P + 1,) [m] base to first pitch, pitch to pitch, last pitch to tool; or one for
            all.

    Returns:
        The joints, and the tool (4, 4) seen from the last one.

    Raises:
        InputError: if a letter or length is invalid, or a segment has two rolls.
    """
    rolls = _rolls_per_segment(sequence)
    segments = _door.vector("lengths", lengths, len(rolls), minimum=0.0)
    joints = []
    for length, has_roll in zip(segments.tolist(), rolls, strict=True):
        step = translation(0.0, 0.0, length / 2 if has_roll else length)
        if has_roll:
            joints.append(Joint(placement=step, axis=ROLL_AXIS))
        joints.append(Joint(placement=step, axis=PITCH_AXIS))
    end = joints.pop()  # the last segment ends at the tool, not at a pitch joint
    return joints, end.placement


def _rolls_per_segment(sequence: Any) -> list[bool]:
    """Whether each segment has a roll joint."""
    expected = "letters R (roll about the link) and P (pitch across it), e.g. 'RPRPR'"
    if not isinstance(sequence, str) or not sequence:
        raise InputError("sequence", _door.describe(sequence), expected)
    for place, letter in enumerate(sequence):
        if letter not in "RP":
            raise InputError("sequence", f"{letter!r} at place {place} of {sequence!r}", expected)
    if "RR" in sequence:
        place = sequence.index("RR")
        raise InputError(
            "sequence",
            f"two rolls in one segment (places {place} and {place + 1} of {sequence!r})",
            "at most one R between two P: rolls of one segment have the same axis, so they act as one joint",
        )
    return ["R" in segment for segment in sequence.split("P")]
