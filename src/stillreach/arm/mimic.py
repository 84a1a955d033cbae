"""Joints that follow other joints, and joints that are held: where each joint of a file's chain is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from stillreach import _door
from stillreach.arm.robot_file import RobotFile, shown
from stillreach.errors import InputError

LARGEST = 1e6
"""What no placement [m, rad] and no held position exceeds: beyond, nothing is left of the digits."""


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: its position is multiplier times the leader's, plus offset.

    Without a leader it stands at the offset.
    """

    leader: str | None
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Place:
    """Position of a joint: factor times that of the arm's joint ``leader`` (None: it stands still), plus offset."""

    leader: str | None
    factor: float
    offset: float


class Positions:
    """Where the joints of a chain are: free, held by the caller, or led by another joint.

    Args:
        file: for messages.
        moving: the joints between base and tip that can move, in order.
        mimic_of: whom any joint of the file follows; raises where the file is wrong about it.
        fixed: {joint name: position}, as the caller gave it.

    Raises:
        RobotFileError: joints follow each other in a cycle, or ``fixed`` names a joint that is neither between base
            and tip nor followed by one that is, or a position beyond 1e6.
        InputError: ``fixed`` is no mapping to numbers.
    """

    def __init__(
        self, file: RobotFile, moving: Iterable[str], mimic_of: Callable[[str], Mimic | None], fixed: Any
    ) -> None:
        self.file = file
        self.mimic_of = mimic_of
        self.moving = tuple(moving)
        self.choices = tuple(
            dict.fromkeys([*self.moving, *(lead for name in self.moving for lead in self._leaders(name))])
        )
        self.held = self._checked(fixed)

    def of(self, name: str) -> Place:
        """Where a joint is."""
        factor, offset = 1.0, 0.0
        while name not in self.held:
            mimic = self.mimic_of(name)
            if mimic is None:
                if name in self.moving and factor != 0.0:
                    return Place(name, factor, offset)
                return self._still(name, offset)
            factor, offset = factor * mimic.multiplier, factor * mimic.offset + offset
            if mimic.leader is None:
                return self._still(name, offset)
            name = mimic.leader
        return self._still(name, factor * self.held[name] + offset)

    def _still(self, name: str, position: float) -> Place:
        if not abs(position) <= LARGEST:
            expected = f"a joint between -{LARGEST:g} and {LARGEST:g}"
            raise self.file.error(f"the position {position:g}", expected, element=f"joint {shown(name)}")
        return Place(None, 0.0, position)

    def _leaders(self, name: str) -> list[str]:
        """Whom a joint follows, whom that one follows, and so on."""
        found: list[str] = []
        while (mimic := self.mimic_of(name)) is not None and mimic.leader is not None:
            name = mimic.leader
            if name in found:
                got = "joints that follow each other in a cycle"
                raise self.file.error(got, "one that leads", element=f"joint {shown(name)}")
            found.append(name)
        return found

    def _checked(self, fixed: Any) -> dict[str, float]:
        if fixed is None:
            return {}
        if not isinstance(fixed, Mapping):
            raise InputError("fixed", _door.describe(fixed), "{joint name: position [rad] or [m]} or None")
        for name in fixed:
            if name not in self.choices:
                raise self.file.unknown(name, "a joint between base and tip", self.choices, argument="fixed")
        return {name: _door.scalar(f"fixed[{name!r}]", position) for name, position in fixed.items()}
