"""Which arm a command is about: a built-in one by name, or a URDF or MJCF file."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from stillreach.errors import InputError, RobotFileError, did_you_mean

if TYPE_CHECKING:
    from stillreach.arm import Arm

ROOT_ELEMENT = re.compile(rb"<\s*(?:\w+:)?(robot|mujoco)\b")
HEAD_BYTES = 65536
TOOLS = ("tcp", "tool", "gripper", "effector", "eef", "flange", "hand", "palm")
"""What links that carry the tool are called, the surest first."""
COMPARED = 100
"""Ends of a tree that are looked at."""
EXPECTED = "a URDF or MJCF file, or a built-in arm (stillreach arms lists them)"


class BuiltIn(NamedTuple):
    """An arm of ``stillreach.arms`` on the command line."""

    name: str
    text: str
    sized: bool = False
    """Whether a number of joints follows the name."""


BUILT_IN = (
    BuiltIn("nasa_modular", "the modular arm of Bedrossian (1994), R P R P … R, 50 deg/s"),
    BuiltIn("canadarm2", "the arm of the Space Station, 4 deg/s"),
    BuiltIn("planar", "N links of 1 m in a plane, e.g. planar3", sized=True),
    BuiltIn("snake", "N links of 0.1 m that pitch and yaw in turn, e.g. snake30", sized=True),
)


def load_arm(robot: str, *, tip: str | None, base: str | None, fixed: dict[str, float]) -> Arm:
    """The arm that ``stillreach inspect`` was asked for.

    Args:
        robot: name, file, or ``package:NAME/PATH`` for a file that an installed package brings.
        tip: link (URDF), body or site (MJCF) that carries the tool.
        base: link or body the chain starts from.
        fixed: values of joints that are held and no part of the arm [rad, m].

    Raises:
        InputError: there is no such arm or file, or the file is neither.
        RobotFileError: the file cannot be read as an arm.
    """
    from stillreach.arm import Arm

    arm = built_in(robot)
    if arm is not None:
        for option, given in (("--tip", tip), ("--base", base), ("--fixed", fixed)):
            if given:
                raise InputError(option, repr(given), f"a robot file with it: {robot} is a built-in arm, and whole")
        return arm
    path = _file(robot)
    if not path.is_file():
        got = "a folder" if path.is_dir() else "no file"
        raise InputError("ROBOT", f"{robot!r}, which is {got}", EXPECTED + _suggestion(robot))
    read = Arm.from_mjcf if _root_element(path) == b"mujoco" else Arm.from_urdf
    try:
        return read(path, tip=tip, base=base, fixed=fixed)
    except RobotFileError as error:
        if error.argument == "tip" and tip is None:
            near = _likely_tip(error.choices[:COMPARED], lambda end: read(path, tip=end, base=base).n)
            if near:
                error.add_note(f"try --tip {near}")
        raise


def _likely_tip(ends: Sequence[str], joints: Callable[[str], int]) -> str | None:
    """The end of a tree that most likely carries the tool.

    That is one named like a tool, else the one behind most joints; a camera on the torso is neither.
    """
    moving = {}
    for end in ends:
        with suppress(RobotFileError):  # no joint moves
            moving[end] = joints(end)
    for word in TOOLS:
        named = [end for end in moving if word in end.lower() and 2 * moving[end] > max(moving.values())]
        if named:
            return min(named, key=len)
    return max(moving, key=moving.__getitem__, default=None)


def _file(robot: str) -> Path:
    """Where the file is; what reads ``package:`` takes its time to import."""
    if not robot.startswith("package:"):
        return Path(robot)
    from stillreach.simulate.scenario_file.packages import file_at

    return file_at(robot, Path())


def built_in(name: str) -> Arm | None:
    """A built-in arm by name, ``planar3`` and its like included; None where none is called so."""
    from stillreach.arm import catalogue

    for arm in BUILT_IN:
        if not arm.sized and name == arm.name:
            return getattr(catalogue, name)()  # type: ignore[no-any-return]
        size = re.fullmatch(rf"{arm.name}(\d{{1,4}})", name) if arm.sized else None
        if size:
            return getattr(catalogue, arm.name)(int(size[1]))  # type: ignore[no-any-return]
    return None


def _root_element(path: Path) -> bytes | None:
    """What the file is by its first element; None where that is neither."""
    with path.open("rb") as file:
        match = ROOT_ELEMENT.search(file.read(HEAD_BYTES))
    return match[1] if match else None


def _suggestion(robot: str) -> str:
    """Files in the folder and built-in arms with nearly that name."""
    if re.fullmatch(r"planar|snake", robot):
        return f" (did you mean '{robot}7'? A number of joints follows)"
    folder = Path(robot).parent
    found = (path for kind in ("urdf", "xml") for path in sorted(folder.glob(f"*.{kind}")))
    files = [str(path) for path in found if path.is_file()]
    return did_you_mean(robot, [*files, *(arm.name for arm in BUILT_IN)])
