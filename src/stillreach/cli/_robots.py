"""Which arm a command is about: a built-in one by name, or a URDF or MJCF file."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING

from stillreach._formats import FORMATS
from stillreach._messages import did_you_mean
from stillreach._text import UTF_16_MARKS
from stillreach.arms import BUILDERS, by_name, split
from stillreach.errors import InputError, RobotFileError

if TYPE_CHECKING:
    from stillreach.arm import Arm

READERS = {f.root: key for key, f in FORMATS.items()}
ROOT_ELEMENT = re.compile(rf"<\s*(?:\w+:)?({'|'.join(READERS)})\b")
HEAD_BYTES = 65536
TOOLS = ("tcp", "tool", "gripper", "effector", "eef", "flange", "hand", "palm")
"""What links that carry the tool are called, the surest first."""
COMPARED = 100
"""Ends of a tree that are looked at."""
STANDARD_INPUT = "-"
OPEN_DESCRIPTOR = re.compile(r"/dev/stdin|/(?:dev|proc/self)/fd/\d+")
"""Paths of what is open already, e.g. the pipe of ``<(xacro robot.urdf.xacro)``; opening any other pipe could wait."""
OPTIONS = {"n": "ROBOT", "tip": "--tip"}
"""What the settings of built-in arms are called on the command line."""
FILES = " or ".join(f.word for f in FORMATS.values())
EXPECTED = f"a {FILES} file, - for standard input, or a built-in arm (stillreach arms lists them)"


def load_arm(robot: str, *, tip: str | None, base: str | None, fixed: dict[str, float]) -> Arm:
    """The arm that ``stillreach inspect`` was asked for.

    Args:
        robot: name, file, ``-`` for standard input, or ``package:NAME/PATH`` for a file that an installed package
            brings.
        tip: link (built-in, URDF), body or site (MJCF) that carries the tool.
        base: link or body the chain starts from.
        fixed: values of joints that are held and no part of the arm [rad, m].

    Raises:
        InputError: there is no such arm or file, or the file is neither.
        RobotFileError: the file cannot be read as an arm.
    """
    from stillreach.arm import Arm

    if split(robot)[0]:
        for option, given in (("--base", base), ("--fixed", fixed)):
            if given:
                raise InputError(option, repr(given), f"a robot file with it: {robot} is a built-in arm, and whole")
        try:
            return by_name(robot, tip=tip)
        except InputError as error:
            raise InputError(OPTIONS[error.argument], error.got, error.expected) from None
    source, head = _source(robot)
    root = ROOT_ELEMENT.search(head)
    read: Callable[..., Arm] = getattr(Arm, f"from_{READERS[root[1]] if root else 'urdf'}")
    try:
        return read(source, tip=tip, base=base, fixed=fixed)
    except RobotFileError as error:
        if error.argument == "tip" and tip is None and isinstance(source, Path):
            near = _likely_tip(error.choices[:COMPARED], lambda end: read(source, tip=end, base=base).n)
            if near:
                error.add_note(f"try --tip {near}")
        elif error.argument in ("tip", "base") and {"tip": tip, "base": base}[error.argument] is None and error.choices:
            error.add_note(f"try --{error.argument} {error.choices[0]}")
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


def _source(robot: str) -> tuple[Path | IO[bytes], str]:
    """What to read the robot from, and the text that it begins with."""
    from stillreach.arm.robot_file import MAX_BYTES

    if robot == STANDARD_INPUT or OPEN_DESCRIPTOR.fullmatch(robot):  # can be read once only
        data = _read_once(robot, MAX_BYTES + 1)
        return _Named(data, "<stdin>" if robot == STANDARD_INPUT else robot), _beginning(data)
    path = _file(robot)
    if not path.is_file():
        got = "a folder" if path.is_dir() else "no file"
        raise InputError("ROBOT", f"{robot!r}, which is {got}", EXPECTED + _suggestion(robot))
    with path.open("rb") as file:
        return path, _beginning(file.read(HEAD_BYTES))


class _Named(BytesIO):
    """A file in memory with a name for messages."""

    def __init__(self, data: bytes, name: str) -> None:
        super().__init__(data)
        self.name = name


def _read_once(robot: str, size: int) -> bytes:
    """What standard input or another open descriptor still holds, up to a size."""
    try:
        if robot != STANDARD_INPUT:
            with Path(robot).open("rb") as file:
                return file.read(size)
        if sys.stdin is None:
            raise OSError(0, "it is closed")
        return sys.stdin.buffer.read(size)
    except OSError as error:
        raise InputError("ROBOT", f"{robot!r}, which cannot be read ({error.strerror})", EXPECTED) from None


def _beginning(data: bytes) -> str:
    """The text that a file begins with."""
    encoding = "utf-16" if data.startswith(UTF_16_MARKS) else "latin-1"  # tags are ASCII
    return data[:HEAD_BYTES].decode(encoding, "replace")


def _file(robot: str) -> Path:
    """Where the file is; what reads ``package:`` takes its time to import."""
    if not robot.startswith("package:"):
        return Path(robot)
    from stillreach._packages import file_at

    return file_at(robot, Path())


def _suggestion(robot: str) -> str:
    """Files in the folder and built-in arms with nearly that name."""
    folder = Path(robot).parent
    found = (path for f in FORMATS.values() for path in sorted(folder.glob(f"*.{f.suffix}")))
    files = [str(path) for path in found if path.is_file()]
    return did_you_mean(robot, [*files, *BUILDERS])
