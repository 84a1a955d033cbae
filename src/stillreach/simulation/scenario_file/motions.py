"""The motion of a scenario file, in metres, radians and seconds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach._rotations import exp, from_pitch_yaw_roll, from_quaternions, from_rpy
from stillreach.errors import InputError
from stillreach.simulation.course import Course
from stillreach.simulation.motion import ConstantTwist
from stillreach.simulation.pose_table import PoseTable
from stillreach.simulation.scenario_file.packages import file_at
from stillreach.simulation.scenario_file.reading import Reading
from stillreach.simulation.scenario_file.units import Units
from stillreach.simulation.scenario_file.words import short, shown
from stillreach.simulation.shapes import Circle, Line, Waypoints

SPEED = ("duration", "profile", "ramp", "relative")


def motions_of(reading: Reading) -> list[ConstantTwist | Course] | None:
    """The parts of the motion; None where something is wrong with one of them."""
    parts: list[ConstantTwist | Course | None] = []
    for place in range(reading.count("motion")):
        kind = reading.value("motion", place, "kind")
        _check_ramp(reading, place)
        if kind == "line":
            _check_line(reading, place)
        elif kind == "waypoints":
            _check_waypoints(reading, place)
        table = _table(reading, place) if kind == "pose-table" else None
        try:
            parts.append(table or _part(reading, place))
        except InputError as error:
            reading.refused(("motion", place), error)
    return [part for part in parts if part is not None] if reading.has("motion") else None


def _check_ramp(reading: Reading, place: int) -> None:
    profile, ramp = ("motion", place, "profile"), ("motion", place, "ramp")
    if reading.has(*ramp) and reading.good(*profile) and reading.value(*profile) != "trapezoidal":
        reading.wrong(ramp, shown(reading.value(*ramp)), 'none, or profile = "trapezoidal"')


def _check_line(reading: Reading, place: int) -> None:
    if not (reading.given("motion", place, "to") or reading.given("motion", place, "orientation")):
        reading.wrong(("motion", place, "to"), "nothing", "a point to go to, an orientation, or both")


def _check_waypoints(reading: Reading, place: int) -> None:
    """Times or a duration, and as many of everything as there are points."""
    times, duration = (reading.given("motion", place, key) for key in ("times", "duration"))
    if times == duration:
        got = "both times and a duration" if times else "neither times nor a duration"
        reading.wrong(("motion", place, "times"), got, "one of them")
    points = reading.value("motion", place, "points")
    for key in ("times", "orientations"):
        entries = reading.value("motion", place, key)
        if points is not None and entries is not None and len(entries) != len(points):
            reading.wrong(("motion", place, key), f"{len(entries)} {key}", f"{len(points)}, one for each point")


def _table(reading: Reading, place: int) -> PoseTable | None:
    """A table of poses, read from its file."""
    reference = reading.value("motion", place, "file")
    if reference is None:
        return None
    relative = reading.value("motion", place, "relative") or False
    units = reading.units
    try:
        path = file_at(reference, reading.document.folder)
        return PoseTable.from_csv(path, relative=relative, length=units.length, angle=units.angle)
    except InputError as error:
        name = Path(error.argument).name
        got = f"{short(name)}: {error.got}" if error.argument != "package" else error.got
        reading.wrong(("motion", place, "file"), got, error.expected)
        return None


def _part(reading: Reading, place: int) -> ConstantTwist | Course | None:
    """A part of the motion that needs no other file; None where something is wrong with it."""
    table, units = reading.value("motion", place), reading.units
    if table is None:
        return None
    speed = {key: table[key] for key in SPEED if key in table}
    match table["kind"]:
        case "twist":
            return ConstantTwist(np.array(table["twist"], dtype=float) * units.twist, table.get("duration"))
        case "wait":
            return ConstantTwist(np.zeros(6), table["duration"])
        case "line":
            return _line(table, units, speed)
        case "circle":
            return _circle(table, units, speed)
        case _:
            return _waypoints(table, units, speed)


def _line(table: dict[str, Any], units: Units, speed: dict[str, Any]) -> Line:
    to = np.array(table["to"], dtype=float) * units.length if "to" in table else None
    turn = rotation("orientation", table["orientation"], units) if "orientation" in table else None
    return Line(to, orientation=turn, **speed)


def _circle(table: dict[str, Any], units: Units, speed: dict[str, Any]) -> Circle:
    settings = {"angle": table["angle"] * units.angle} if "angle" in table else {}
    centre = np.array(table["centre"], dtype=float) * units.length
    axis = np.array(table["axis"], dtype=float)
    return Circle(centre=centre, axis=axis, attitude=table.get("attitude", "keep"), **settings, **speed)


def _waypoints(table: dict[str, Any], units: Units, speed: dict[str, Any]) -> Waypoints:
    turns = table.get("orientations")
    if turns is not None:
        turns = [
            None if turn == "keep" else rotation(f"orientations[{k}]", turn, units) for k, turn in enumerate(turns)
        ]
    points = np.array(table["points"], dtype=float) * units.length
    return Waypoints(points=points, orientations=turns, times=table.get("times"), **speed)


def rotation(name: str, table: dict[str, Any], units: Units) -> FloatArray:
    """The rotation matrix of an orientation table."""
    ((form, numbers),) = table.items()
    rows = np.array([numbers], dtype=float)
    if form == "quaternion":
        matrices = from_quaternions(f"{name}.{form}", rows)
    else:
        make = {"rotation_vector": exp, "rpy": from_rpy, "pitch_yaw_roll": from_pitch_yaw_roll}[form]
        matrices = make(rows * units.angle)
    matrix: FloatArray = matrices[0]
    return matrix
