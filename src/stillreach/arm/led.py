"""Joints that follow other joints, and joints that are held: the position of each joint of a file's chain."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from stillreach import _door
from stillreach.arm.robot_file import RobotFile, shown
from stillreach.errors import InputError

LARGEST = 1e6
"""The largest placement [m, rad] and held position: beyond, too few digits are left."""


class Led(NamedTuple):
    """Position of a joint: factor times that of the joint ``leader``, plus offset; without one it stands still."""

    leader: str | None
    factor: float
    offset: float


MimicOf = Callable[[str], Led | None]
"""Whom a joint of the file follows, None: nobody; raises where the file is wrong about it."""


def positions(file: RobotFile, moving: Iterable[str], mimic_of: MimicOf, fixed: Any) -> dict[str, Led]:
    """The position of each joint: free (led by itself), led by a free joint of the chain, or standing still.

    Args:
        file: for messages.
        moving: the joints between base and tip that can move, in order.
        mimic_of: for any joint of the file.
        fixed: {joint name: position}, as the caller gave it.

    Raises:
        RobotFileError: if joints follow each other in a cycle, ``fixed`` names a joint that is neither between base and
            tip nor followed by one that is, or a position is beyond 1e6.
        InputError: if ``fixed`` is not a mapping to numbers.
    """
    own = dict.fromkeys(moving)
    mimics: dict[str, Led | None] = {}
    leaders_first: list[str] = []
    for name in own:
        walk = dict[str, None]()
        while name not in mimics:
            walk[name] = None
            mimic = mimics[name] = mimic_of(name)
            if mimic is None or mimic.leader is None:
                break
            name = mimic.leader
        else:
            if name in walk:
                got = "joints that follow each other in a cycle"
                raise file.error(got, "one that leads", element=f"joint {shown(name)}")
        leaders_first += reversed(walk)
    held = _held(file, fixed, [*own, *(name for name in mimics if name not in own)])
    found: dict[str, Led] = {}
    for name in leaders_first:
        mimic = mimics[name]
        if name in held:
            found[name] = _checked(file, name, Led(None, 0.0, held[name]))
        elif mimic is None:
            found[name] = Led(name, 1.0, 0.0) if name in own else Led(None, 0.0, 0.0)
        elif mimic.leader is None:
            found[name] = mimic
        else:
            leader = found[mimic.leader]
            found[name] = Led(leader.leader, mimic.factor * leader.factor, mimic.factor * leader.offset + mimic.offset)
    return {name: _checked(file, name, found[name]) for name in own}


def _checked(file: RobotFile, name: str, led: Led) -> Led:
    limits, element = f"between -{LARGEST:g} and {LARGEST:g}", f"joint {shown(name)}"
    if not abs(led.offset) <= LARGEST:
        raise file.error(f"the position {led.offset:g}", f"a joint {limits}", element=element)
    if not abs(led.factor) <= LARGEST:
        got = f"a joint that makes {led.factor:g} times the motion of joint {shown(led.leader)}"
        raise file.error(got, f"a factor {limits}", element=element)
    return led if led.factor else Led(None, 0.0, led.offset)


def _held(file: RobotFile, fixed: Any, choices: list[str]) -> dict[str, float]:
    if fixed is None:
        return {}
    if not isinstance(fixed, Mapping):
        raise InputError("fixed", _door.describe(fixed), "{joint name: position [rad] or [m]} or None")
    for name in fixed:
        if name not in choices:
            raise file.unknown(name, "a joint between base and tip", choices, argument="fixed")
    return {name: _door.scalar(f"fixed[{name!r}]", position) for name, position in fixed.items()}
