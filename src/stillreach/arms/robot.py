"""Arms whose numbers are in ``robots.toml``: what makes an ``Arm`` of a table. Imports NumPy when it makes one."""

from __future__ import annotations

import math
import tomllib
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from stillreach._messages import did_you_mean
from stillreach.errors import InputError

if TYPE_CHECKING:
    from stillreach.arm import Arm

COLUMNS = 12
"""Of a row, with its acceleration limit."""
SLIDE = "slide "
AXES = {
    "x": (1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-y": (0.0, -1.0, 0.0),
}


class Robot:
    """A robot by its maker's numbers; calling it makes the arm.

    Attributes:
        text: what it is.
        source: where its numbers are published.
        tips: the links that can carry the tool; the first one does unless another is named.
    """

    def __init__(self, name: str) -> None:
        table = tables()[name]
        self.__name__ = name
        self.text: str = table["text"]
        self.source: str = table["source"]
        self.tips = tuple(table["tips"])
        self.__doc__ = f"{self.text}.\n\nTips: {', '.join(self.tips)}. Source: {self.source}."

    def __repr__(self) -> str:
        return f"<stillreach.arms.{self.__name__}: {self.text}>"

    def __call__(self, *, tip: str | None = None) -> Arm:
        """The arm, with the joint names, limits and base of its maker.

        Args:
            tip: link whose frame is the tool; None: the first of ``tips``.

        Raises:
            InputError: if the tip is not one of ``tips``.
        """
        import numpy as np

        from stillreach.arm import Arm, Joint
        from stillreach.arm.placements import placed

        table = tables()[self.__name__]
        tip = self.tips[0] if tip is None else tip
        if tip not in self.tips:
            raise InputError("tip", repr(tip), f"one of {', '.join(self.tips)}{did_you_mean(tip, self.tips)}")
        unit = math.radians(1.0) if table.get("limits") == "deg" else 1.0
        joints, before = [], placed(*table.get("base", (0.0,) * 6))
        for name, *place, axis, lower, upper, velocity, acceleration in (_whole(row) for row in table["joints"]):
            kind, factor = ("prismatic", 1.0) if axis.startswith(SLIDE) else ("revolute", unit)
            joints.append(
                Joint(
                    name=name,
                    kind=kind,
                    placement=before @ placed(*place),
                    axis=AXES[axis.removeprefix(SLIDE)],
                    position_limits=(lower * factor, upper * factor),
                    velocity_limit=velocity * factor,
                    acceleration_limit=acceleration * factor,
                )
            )
            before = np.eye(4)
        return Arm(joints, tool=placed(*table["tips"][tip]), name=self.__name__)


def _whole(row: list[Any]) -> list[Any]:
    """A row with an acceleration limit, infinite where none is published."""
    return row if len(row) == COLUMNS else [*row, math.inf]


@cache
def tables() -> dict[str, dict[str, Any]]:
    """The tables by name."""
    return tomllib.loads((resources.files("stillreach.arms") / "robots.toml").read_text(encoding="utf-8"))
