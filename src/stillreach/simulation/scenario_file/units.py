"""The units that a scenario file declares, as factors to metres and radians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from stillreach._door import FloatArray
from stillreach._units import ANGLES, LENGTHS


@dataclass(frozen=True)
class Units:
    """What a number in the file stands for.

    Args:
        length: [m] the unit of lengths.
        angle: [rad] the unit of angles.
    """

    length: float = 1.0
    angle: float = 1.0

    @classmethod
    def of(cls, table: Mapping[str, Any]) -> Units:
        """The units of a file; SI for those that it does not declare."""
        return cls(LENGTHS[table.get("length", "m")], ANGLES[table.get("angle", "rad")])

    @property
    def twist(self) -> FloatArray:
        """(6,) factors of [v; w]."""
        return np.array([self.length] * 3 + [self.angle] * 3)

    def joints(self, kinds: npt.ArrayLike) -> FloatArray:
        """(n,) factors of joint values, from the kinds of the joints (1: prismatic)."""
        return np.where(np.asarray(kinds) == 1, self.length, self.angle)

    def largest_rate(self, kinds: npt.ArrayLike) -> float:
        """Factor of a rate that is one number for joints of both kinds: lengths only where all joints are slides."""
        return self.length if np.all(np.asarray(kinds) == 1) else self.angle
