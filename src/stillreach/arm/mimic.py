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
        self.moving = dict.fromkeys(moving)
        self.choices = self._with_leaders()
        self.held = self._checked(fixed)
        self.places: dict[str, Place] = {}

    def of(self, name: str) -> Place:
        """Where a joint is."""
        way: list[tuple[str, Mimic]] = []
        while (place := self._known(name)) is None:
            mimic = self.mimic_of(name)
            if mimic is None or mimic.leader is None:
                offset = 0.0 if mimic is None else mimic.offset
                leads = mimic is None and name in self.moving
                place = self._place(name, name if leads else None, 1.0, offset)
                break
            way.append((name, mimic))
            name = mimic.leader
        for follower, mimic in reversed(way):
            factor, offset = mimic.multiplier * place.factor, mimic.multiplier * place.offset + mimic.offset
            place = self._place(follower, place.leader, factor, offset)
        return place

    def _known(self, name: str) -> Place | None:
        """Where a joint is that is held or was asked for before."""
        if name not in self.places and name in self.held:
            self._place(name, None, 0.0, self.held[name])
        return self.places.get(name)

    def _place(self, name: str, leader: str | None, factor: float, offset: float) -> Place:
        """A place that is kept.

        Raises:
            RobotFileError: it is beyond all measure.
        """
        limits = f"between -{LARGEST:g} and {LARGEST:g}"
        if not abs(offset) <= LARGEST:
            raise self.file.error(f"the position {offset:g}", f"a joint {limits}", element=f"joint {shown(name)}")
        if not abs(factor) <= LARGEST:
            got = f"a joint that makes {factor:g} times the motion of joint {shown(leader)}"
            raise self.file.error(got, f"a factor {limits}", element=f"joint {shown(name)}")
        moves = leader is not None and factor != 0.0
        self.places[name] = Place(leader if moves else None, factor if moves else 0.0, offset)
        return self.places[name]

    def _with_leaders(self) -> tuple[str, ...]:
        """The moving joints, those that they follow, and so on; RobotFileError if they do so in a cycle."""
        found, done = dict.fromkeys(self.moving), set[str]()
        for name in self.moving:
            walk = dict[str, None]()
            while name not in done and name not in walk:
                walk[name] = None
                mimic = self.mimic_of(name)
                if mimic is None or mimic.leader is None:
                    break
                name = mimic.leader
                found[name] = None
            else:
                if name in walk:
                    got = "joints that follow each other in a cycle"
                    raise self.file.error(got, "one that leads", element=f"joint {shown(name)}")
            done.update(walk)
        return tuple(found)

    def _checked(self, fixed: Any) -> dict[str, float]:
        if fixed is None:
            return {}
        if not isinstance(fixed, Mapping):
            raise InputError("fixed", _door.describe(fixed), "{joint name: position [rad] or [m]} or None")
        for name in fixed:
            if name not in self.choices:
                raise self.file.unknown(name, "a joint between base and tip", self.choices, argument="fixed")
        return {name: _door.scalar(f"fixed[{name!r}]", position) for name, position in fixed.items()}
