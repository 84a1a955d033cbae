"""From the values of a scenario file to a Scenario, and every mistake on the way."""

from __future__ import annotations

from dataclasses import replace
from math import ceil
from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.arm import Arm
from stillreach.arm.outside import outside
from stillreach.errors import InputError, ScenarioFileError
from stillreach.faults import Derated, Fault, FaultKind, Locked, Runaway
from stillreach.simulation.course import Course
from stillreach.simulation.motion import TICK_TOLERANCE, ConstantTwist
from stillreach.simulation.plausible import ADVICE, goals_beyond_reach
from stillreach.simulation.scenario import Scenario
from stillreach.simulation.scenario_file.document import Document
from stillreach.simulation.scenario_file.mistakes import form_of
from stillreach.simulation.scenario_file.motions import motions_of
from stillreach.simulation.scenario_file.reading import Reading
from stillreach.simulation.scenario_file.robots import arm_of
from stillreach.simulation.scenario_file.settings import (
    check_joint_weights,
    check_price,
    law_of,
    limits_of,
    null_motion_of,
    task_of,
)

PERIOD = 0.01
"""[s] where a file does not say it, as for Scenario."""
PLAIN = ("name", "description", "period", "duration", "integrator", "loop", "clock", "track_gain", "transition_rate")
"""Keys that go into the Scenario as they are."""


def scenario_of(document: Document) -> Scenario:
    """The scenario that a file describes.

    Raises:
        ScenarioFileError: with everything that is wrong in it.
    """
    reading = Reading(document, *form_of(document))
    settings: dict[str, Any] = {"motion": motions_of(reading), "law": law_of(reading), "task": task_of(reading)}
    settings |= {key: reading.value(key) for key in PLAIN if reading.has(key)}
    check_price(reading, settings["law"], settings["task"])
    arm = arm_of(reading)
    _check_loop(reading)
    _check_times(reading, settings["motion"])
    if arm is not None:
        settings |= _of_joints(reading, arm)
    if arm is not None and not reading.mistakes:
        try:
            scenario = Scenario(arm=arm, allow_outside=True, **settings)
        except InputError as error:
            reading.refused((), error)
        else:
            if reading.value("allow_outside"):
                return scenario
            for mistake in goals_beyond_reach(scenario):
                reading.refused((), mistake)
            if not reading.mistakes:
                return replace(scenario, allow_outside=False)
    mistakes = sorted(reading.mistakes, key=lambda mistake: (mistake.line or 0, mistake.place))
    raise ScenarioFileError(document.name, mistakes)


def _of_joints(reading: Reading, arm: Arm) -> dict[str, Any]:
    """What can be checked only with the arm at hand."""
    factors = reading.units.joints(arm.kinds)
    settings: dict[str, Any] = {
        "start": reading.joint_values(("start",), arm, factors, np.zeros(arm.n)),
        "faults": _faults(reading, arm),
        "null_motion": null_motion_of(reading, arm),
        **limits_of(reading, arm),
    }
    if settings["start"] is not None and not reading.value("allow_outside") and reading.good("position_limits"):
        _check_start(reading, arm, settings["start"], settings.get("position_limits", arm.position_limits))
    check_joint_weights(reading, arm)
    if reading.has("return_rate"):
        settings["return_rate"] = reading.value("return_rate") * reading.units.largest_rate(arm.kinds)
    if reading.has("track_limits"):
        linear, angular = reading.value("track_limits")
        settings["track_limits"] = (linear * reading.units.length, angular * reading.units.angle)
    return settings


def _check_start(reading: Reading, arm: Arm, start: FloatArray, limits: FloatArray) -> None:
    """A start outside the position limits is likely in other units than the file's."""
    by_name = isinstance(reading.value("start"), dict)
    for i, got, expected in outside(arm, start, limits):
        reading.wrong(("start", arm.joint_names[i] if by_name else i), got, f"{expected}; {ADVICE}")


def _faults(reading: Reading, arm: Arm) -> list[Fault]:
    found = []
    for place in range(reading.count("faults")):
        joint = reading.joint(("faults", place, "joint"), arm)
        table = reading.value("faults", place)
        if joint is None or table is None:
            continue
        factor = float(reading.units.joints(arm.kinds)[arm.joint_index(joint)])
        try:
            found.append(Fault(joint, at=table.get("at", 0.0), kind=_kind(table, factor), until=table.get("until")))
        except InputError as error:
            reading.refused(("faults", place), error)
    return found


def _kind(table: dict[str, Any], factor: float) -> FaultKind:
    match table["kind"]:
        case "derated":
            return Derated(table["fraction"])
        case "runaway":
            return Runaway(table["rate"] * factor)
        case _:
            return Locked()


def _check_loop(reading: Reading) -> None:
    """Settings of a feedback that there is not, and steps that do not go with the clock."""
    if reading.value("clock") == "arm" and reading.value("integrator") == "rk4":
        reading.wrong(("integrator",), "'rk4'", '"euler" with clock = "arm"')
    if reading.good("loop") and reading.value("loop") != "closed":
        for key in ("track_gain", "track_limits"):
            if reading.has(key):
                reading.wrong((key,), "a setting of the feedback in an open loop", 'loop = "closed" with it')


def _check_times(reading: Reading, motion: list[ConstantTwist | Course] | None) -> None:
    """Durations, the period and the times of faults against each other."""
    total, endless = _length(reading, motion)
    duration = reading.value("duration")
    if not reading.given("duration"):
        if endless:
            reading.wrong(("duration",), "nothing", "this key: the motion has no end of its own")
        elif reading.value("clock") == "arm":
            expected = 'this key: with clock = "arm" the motion takes as long as the arm needs'
            reading.wrong(("duration",), "nothing", expected)
    if duration is not None and total is not None and duration < total * (1.0 - TICK_TOLERANCE):
        reading.wrong(("duration",), f"{duration:g} s", f"at least the {total:g} s of the motion")
    end = (total if duration is None else duration) if reading.good("duration") else None
    period = reading.value("period") if reading.given("period") else PERIOD
    if end is not None and period is not None and period > end:
        reading.wrong(("period",), f"{period:g} s", f"at most the whole duration, {end:g} s")
    for place in range(reading.count("faults")):
        _check_fault(reading, place, end, period)


def _check_fault(reading: Reading, place: int, end: float | None, period: float | None) -> None:
    """A fault begins before the end, and lasts for at least one tick."""
    at, until = reading.value("faults", place, "at"), reading.value("faults", place, "until")
    if at is not None and end is not None and at >= end:
        reading.wrong(("faults", place, "at"), f"{at:g} s", f"an onset before the end at {end:g} s")
    if until is None or not reading.good("faults", place, "at"):
        return
    at = at or 0.0
    if until <= at:
        reading.wrong(("faults", place, "until"), f"{until:g} s", f"a time after the onset at {at:g} s")
    elif period is not None and ceil(until / period - TICK_TOLERANCE) <= ceil(at / period - TICK_TOLERANCE):
        expected = f"an end after the first tick from {at:g} s on; ticks are {period:g} s apart"
        reading.wrong(("faults", place, "until"), f"{until:g} s", expected)


def _length(reading: Reading, motion: list[ConstantTwist | Course] | None) -> tuple[float | None, bool]:
    """How long the motion takes [s], None where that cannot be told, and whether its last part has no end."""
    total: float | None = 0.0 if reading.count("motion") else None
    endless = False
    for place in range(reading.count("motion")):
        last = place == reading.count("motion") - 1
        length: float | None = reading.value("motion", place, "duration") if motion is None else motion[place].duration
        open_end = reading.value("motion", place, "kind") == "twist" and not reading.given("motion", place, "duration")
        if open_end and not last:
            reading.wrong(("motion", place, "duration"), "nothing", "a duration: only the last motion may have none")
        endless = open_end and last
        total = None if total is None or length is None else total + length
    return total, endless
