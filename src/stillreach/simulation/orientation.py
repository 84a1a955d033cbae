"""Orientations in files."""

from __future__ import annotations

from typing import Any

import numpy as np

from stillreach._door import FloatArray
from stillreach._forms import Number, Schema
from stillreach._kinds import Key
from stillreach._lists import NOT_ALL_ZERO, List
from stillreach._messages import shown
from stillreach._reading import Place, Reading
from stillreach._rotations import exp, from_pitch_yaw_roll, from_quaternions, from_rpy
from stillreach._tables import Table

ANGLES = List(*[Number("angle")] * 3)
WAYS = {
    "rotation_vector": Key(ANGLES, "Axis times angle", None),
    "quaternion": Key(List(*[Number()] * 4, check=NOT_ALL_ZERO), "w, x, y, z; any length but 0", None),
    "rpy": Key(ANGLES, "Roll, pitch, yaw as in URDF: R = Rz(yaw) Ry(pitch) Rx(roll)", None),
    "pitch_yaw_roll": Key(ANGLES, "Pitch, yaw, roll: R = Ry(pitch) Rz(yaw) Rx(roll)", None),
}


class Orientation(Table):
    """An attitude, in exactly one of several ways; read as a matrix (3, 3)."""

    def __init__(self) -> None:
        super().__init__("Orientation", "An attitude, in exactly one of these ways.", WAYS, _matrix)

    def taken(self, value: Any, place: Place, reading: Reading) -> Any:
        """As a rotation matrix."""
        known = [name for name in value if name in WAYS]
        if len(known) != 1 and len(known) == len(value):
            return reading.wrong(place, shown(value), f"exactly one of {', '.join(WAYS)}")
        return super().taken(value, place, reading)

    def definition(self, tables: Schema) -> Schema:
        """With the number of keys."""
        return {**super().definition(tables), "minProperties": 1, "maxProperties": 1}


def _matrix(values: dict[str, Any], reading: Reading) -> FloatArray:
    ((way, numbers),) = values.items()
    rows = np.array([numbers])
    if way == "quaternion":
        matrices = from_quaternions(way, rows)
    else:
        matrices = {"rotation_vector": exp, "rpy": from_rpy, "pitch_yaw_roll": from_pitch_yaw_roll}[way](rows)
    matrix: FloatArray = matrices[0]
    return matrix


ORIENTATION = Orientation()
