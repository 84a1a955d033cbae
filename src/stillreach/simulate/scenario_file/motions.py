"""The motion of a scenario file, in metres, radians and seconds."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach.errors import InputError
from stillreach.simulate.course import Course
from stillreach.simulate.motion import Twist
from stillreach.simulate.pose_table import PoseTable
from stillreach.simulate.rotations import exp, from_pitch_yaw_roll, from_quaternions, from_rpy
from stillreach.simulate.scenario_file.packages import file_at
from stillreach.simulate.scenario_file.reading import Reading
from stillreach.simulate.scenario_file.units import Units
from stillreach.simulate.shapes import Circle, Line, Waypoints

SPEED = ("duration", "profile", "ramp", "relative")


def motions_of(reading: Reading) -> list[Twist | Course] | None:
    """The parts of the motion; None where something is wrong with one of them."""
    parts: list[Twist | Course | None] = []
    for place in range(reading.count("motion")):
        table = reading.value("motion", place)
        try:
            parts.append(None if table is None else _part(reading, place, table))
        except InputError as error:
            reading.refused(("motion", place), error)
    return [part for part in parts if part is not None] if reading.has("motion") else None


def _part(reading: Reading, place: int, table: dict[str, Any]) -> Twist | Course | None:
    units = reading.units
    if "ramp" in table and table.get("profile") != "trapezoidal":
        reading.wrong(("motion", place, "ramp"), "a ramp", 'none, or profile = "trapezoidal"')
        return None
    speed = {key: table[key] for key in SPEED if key in table}
    match table["kind"]:
        case "twist":
            return Twist(np.array(table["twist"], dtype=float) * units.twist, table.get("duration"))
        case "wait":
            return Twist(np.zeros(6), table["duration"])
        case "line":
            return _line(table, units, speed)
        case "circle":
            return _circle(table, units, speed)
        case "waypoints":
            return _waypoints(table, units, speed)
        case _:
            path = file_at(table["file"], reading.document.folder)
            settings = {"relative": table.get("relative", False), "length": units.length, "angle": units.angle}
            return PoseTable.from_csv(path, **settings)


def _line(table: dict[str, Any], units: Units, speed: dict[str, Any]) -> Line:
    if "to" not in table and "orientation" not in table:
        raise InputError("to", "neither", "a point to go to, an orientation, or both")
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
    """The rotation matrix of an orientation table; InputError where it has none or several forms."""
    if len(table) != 1:
        forms = "rotation_vector, quaternion, rpy, pitch_yaw_roll"
        raise InputError(name, ", ".join(table) or "an empty table", f"exactly one of {forms}")
    ((form, numbers),) = table.items()
    rows = np.array([numbers], dtype=float)
    if form == "quaternion":
        return from_quaternions(f"{name}.{form}", rows)[0]
    make = {"rotation_vector": exp, "rpy": from_rpy, "pitch_yaw_roll": from_pitch_yaw_roll}[form]
    return make(rows * units.angle)[0]
