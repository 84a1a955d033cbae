"""The arm of a scenario file."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach.arm import Arm, DHRow
from stillreach.arms import by_name
from stillreach.errors import InputError, MissingExtraError, RobotFileError
from stillreach.simulation.scenario_file.packages import file_at
from stillreach.simulation.scenario_file.reading import Reading


def arm_of(reading: Reading) -> Arm | None:
    """The arm; None, and the mistakes, where there is none to be had."""
    table = reading.value("robot")
    if table is None:
        return None
    try:
        if "arm" in table:
            return _built_in(reading, table)
        if "modules" in table:
            lengths = np.array(table["lengths"]) * reading.units.length
            return Arm.from_modules(table["modules"], lengths)
        if "dh" in table:
            return Arm.from_dh([_row(reading, row) for row in table["dh"]], table.get("convention", "standard"))
        return _from_file(reading, table)
    except RobotFileError as error:
        reading.refused(("robot",), _in_words(error, table))
    except InputError as error:
        reading.refused(("robot",), error)
    except MissingExtraError as error:
        reading.wrong(("robot",), f"a robot file that {error.extra} reads, which is not installed", str(error))
    return None


def _built_in(reading: Reading, table: dict[str, Any]) -> Arm:
    settings = {key: value for key, value in table.items() if key != "arm"}
    if "lengths" in settings:
        settings["lengths"] = np.array(settings["lengths"]) * reading.units.length
    return by_name(table["arm"], **settings)


def _row(reading: Reading, row: dict[str, Any]) -> DHRow:
    """A row in metres and radians."""
    factors = {"a": reading.units.length, "d": reading.units.length}
    factors |= {"alpha": reading.units.angle, "theta": reading.units.angle}
    return DHRow(**{key: value * factors[key] if key in factors else value for key, value in row.items()})


def _from_file(reading: Reading, table: dict[str, Any]) -> Arm:
    kind = "urdf" if "urdf" in table else "mjcf"
    try:
        path = file_at(table[kind], reading.document.folder)
    except InputError as error:
        raise InputError(kind, error.got, error.expected) from None
    read = Arm.from_urdf if kind == "urdf" else Arm.from_mjcf
    settings = {key: table[key] for key in ("tip", "base") if key in table}
    fixed = table.get("fixed", {})
    if fixed and not reading.units.length == reading.units.angle == 1.0:  # slides and hinges have different units
        whole = read(path, **settings)
        factors = dict(zip(whole.joint_names, reading.units.joints(whole.kinds), strict=True))
        fixed = {name: value * factors.get(name, 1.0) for name, value in fixed.items()}
    return read(path, fixed=fixed or None, **settings)


def _in_words(error: RobotFileError, table: dict[str, Any]) -> InputError:
    """The error with its place in the robot file as a part of what came."""
    kind = "urdf" if "urdf" in table else "mjcf"
    argument = error.argument if error.argument in ("tip", "base", "fixed") else kind
    line = f"line {error.line}" if error.line else ""
    place = ", ".join(part for part in (line, error.element) if part)
    return InputError(argument, f"{place}: {error.got}" if place else error.got, error.expected)
