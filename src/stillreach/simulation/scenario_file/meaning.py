"""Checks of a scenario file's values against each other."""

from __future__ import annotations

from math import ceil, fsum
from typing import Any

from stillreach._reading import Reading
from stillreach.arm.outside import outside
from stillreach.errors import InputError
from stillreach.faults import Fault
from stillreach.simulation.motion import TICK_TOLERANCE, ConstantTwist
from stillreach.simulation.plausible import ADVICE
from stillreach.simulation.scenario_file.tables import SCENARIO
from stillreach.task import Task


def check(settings: dict[str, Any], reading: Reading) -> None:
    """Records the contradictions between the arguments of a Scenario."""
    values = {name: own.default for name, own in SCENARIO.keys.items()} | settings
    _check_start(values, reading)
    _check_price(values, reading)
    _check_loop(values, set(settings), reading)
    _check_times(values, "duration" in settings, reading)


def _check_start(values: dict[str, Any], reading: Reading) -> None:
    """A start outside the position limits probably has the wrong units."""
    arm, limits = values["arm"], values["position_limits"]
    if not values["allow_outside"]:
        for joint, got, expected in outside(arm, values["start"], arm.position_limits if limits is None else limits):
            by_name = isinstance(reading.content["start"], dict)
            reading.wrong(("start", arm.joint_names[joint] if by_name else joint), got, f"{expected}; {ADVICE}")


def _check_price(values: dict[str, Any], reading: Reading) -> None:
    """Checks prices by rows against rows and weights of the task."""
    law, task = values["law"], values["task"] or Task()
    if law is not None:
        try:
            law.core(task.row_names, reach=1.0, weights=task.weights)
        except InputError as error:
            reading.refused(("law",) if error.argument == "price" else ("task",), error)


def _check_loop(values: dict[str, Any], given: set[str], reading: Reading) -> None:
    """Checks feedback settings without feedback, and the integrator for the clock."""
    if values["clock"] == "arm" and values["integrator"] == "rk4":
        reading.wrong(("integrator",), "'rk4'", '"euler" with clock = "arm"')
    if values["loop"] != "closed":
        for name in sorted(given & {"track_gain", "track_limits"}):
            reading.wrong((name,), "a feedback setting in an open loop", 'loop = "closed" with it')


def _check_times(values: dict[str, Any], limited: bool, reading: Reading) -> None:
    """Checks durations, period and times of faults."""
    for place, part in enumerate(values["motion"][:-1]):
        if part.duration is None:
            expected = "a duration: only the last motion may have none"
            reading.wrong(("motion", place, "duration"), "missing key", expected)
    endless = isinstance(values["motion"][-1], ConstantTwist) and values["motion"][-1].duration is None
    total = fsum(part.duration or 0.0 for part in values["motion"])
    period, duration = values["period"], values["duration"] if limited else total
    if limited and duration < total * (1.0 - TICK_TOLERANCE):
        reading.wrong(("duration",), f"{duration:g} s", f"at least the {total:g} s of the motion")
    if not limited and endless:
        reading.wrong(("duration",), "missing key", "a total duration: the motion has no end")
    elif not limited and values["clock"] == "arm":
        expected = 'a total duration: with clock = "arm" the arm determines how long the motion takes'
        reading.wrong(("duration",), "missing key", expected)
    elif period > duration:
        reading.wrong(("period",), f"{period:g} s", f"at most the whole duration, {duration:g} s")
    for place, fault in enumerate(values["faults"]):
        _check_fault(place, fault, None if endless and not limited else duration, period, reading)


def _check_fault(place: int, fault: Fault, end: float | None, period: float, reading: Reading) -> None:
    """Checks that a fault begins before the end and lasts for at least one tick."""
    if end is not None and fault.at >= end:
        reading.wrong(("faults", place, "at"), f"{fault.at:g} s", f"an onset before the end at {end:g} s")
    elif fault.until is not None:
        first, last = (ceil(time / period - TICK_TOLERANCE) for time in (fault.at, fault.until))
        if last <= first:
            expected = f"an end after the first tick from {fault.at:g} s on; ticks are {period:g} s apart"
            reading.wrong(("faults", place, "until"), f"{fault.until:g} s", expected)
