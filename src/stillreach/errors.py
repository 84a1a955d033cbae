"""Every error that stillreach raises: one base class, and errors that carry their data.

The data of an error are its ``args``, so that it survives pickling (worker processes raise errors, too).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stillreach._messages import hint, listing

STATED = ("missing key", "unknown key", "no such file")
"""What came where this is no value but a statement."""


class StillreachError(Exception):
    """Base of all errors of this package: ``except stillreach.StillreachError`` catches each of them."""


class InputError(StillreachError, ValueError):
    """An argument is invalid.

    Args:
        argument: name of the argument, as the caller wrote it.
        got: what came, in words (value, shape or type).
        expected: what would have been right, with the valid choices where they can be listed.
    """

    def __init__(self, argument: str, got: str, expected: str) -> None:
        super().__init__(argument, got, expected)
        self.argument = argument
        self.got = got
        self.expected = expected

    def __str__(self) -> str:
        got = self.got if self.got.startswith(STATED) else f"got {self.got}"
        return f"{self.argument}: {got}, expected {self.expected}"


class UnknownJointError(InputError):
    """The arm has no joint of that name or index.

    Args:
        argument: name of the argument, as the caller wrote it.
        got: what came, in words.
        choices: the names of the arm's joints, in order.
    """

    def __init__(self, argument: str, got: str, choices: Sequence[str]) -> None:
        choices = tuple(choices)
        near = hint(got.split("'")[1], choices) if got.count("'") >= 2 else ""
        expected = f"one of {listing(choices)} or an index from 0 to {len(choices) - 1}"
        super().__init__(argument, got, f"{expected} ({near})" if near else expected)
        self.args = (argument, got, choices)
        self.choices = choices


class RobotFileError(InputError):
    """An arm cannot be made from this robot file or from these arguments.

    Args:
        argument: name of the argument, as the caller wrote it: ``"path"``, ``"tip"``, ``"base"`` or ``"fixed"``.
        got: what came, in words.
        expected: what would have been right.
        file: the file, as it was given.
        line: line of the file, from 1 on; None where it is not about one line.
        element: the element, e.g. ``"joint 'elbow'"``; None where it is not about one.
        choices: the valid choices (links, joints, types), where they can be listed.
    """

    def __init__(
        self,
        argument: str,
        got: str,
        expected: str,
        file: str = "",
        line: int | None = None,
        element: str | None = None,
        choices: Sequence[str] = (),
    ) -> None:
        super().__init__(argument, got, expected)
        self.args = (argument, got, expected, file, line, element, tuple(choices))
        self.file = file
        self.line = line
        self.element = element
        self.choices = tuple(choices)

    def __str__(self) -> str:
        line = f"line {self.line}" if self.line else ""
        argument = "" if self.argument == "path" else self.argument
        place = ", ".join(part for part in (self.file, line, self.element, argument) if part)
        return f"{place}: got {self.got}, expected {self.expected}"


@dataclass(frozen=True)
class Mistake:
    """One thing that is wrong in a scenario file.

    Args:
        place: where, e.g. ``"faults[1].joint"``; empty for the file as a whole.
        got: what is there, in words.
        expected: what would have been right.
        hint: ``"did you mean 'j4'?"`` and its like, or nothing.
        line: line of the file, from 1 on; None where it has none.
    """

    place: str
    got: str
    expected: str
    hint: str = ""
    line: int | None = None

    def __str__(self) -> str:
        line = f"line {self.line}" if self.line else ""
        where = ", ".join(part for part in (line, self.place) if part)
        hint = f" ({self.hint})" if self.hint else ""
        got = self.got if self.got.startswith(STATED) else f"got {self.got}"
        expected = f": {self.expected}" if got == "missing key" else f", expected {self.expected}"
        return f"{where}{': ' if where else ''}{got}{expected}{hint}"


class ScenarioFileError(InputError):
    """A scenario file cannot be used; all its mistakes at once.

    Args:
        file: the file, as it was given.
        mistakes: what is wrong, in the order of the lines.
    """

    def __init__(self, file: str, mistakes: Sequence[Mistake]) -> None:
        mistakes = tuple(mistakes)
        super().__init__("path", f"a file with {len(mistakes)} mistakes", "a scenario file")
        self.args = (file, mistakes)
        self.file = file
        self.mistakes = mistakes

    def __str__(self) -> str:
        if len(self.mistakes) == 1:
            return f"{self.file}: {self.mistakes[0]}"
        return "\n  ".join([f"{self.file}: {len(self.mistakes)} mistakes", *map(str, self.mistakes)])


class MissingExtraError(StillreachError, ImportError):
    """An optional part is missing its packages.

    Args:
        extra: name of the extra that brings them.
        purpose: what needs it, e.g. ``"run.save()"``.
    """

    def __init__(self, extra: str, purpose: str) -> None:
        super().__init__(extra, purpose)
        self.extra = extra
        self.purpose = purpose

    def __str__(self) -> str:
        return f"{self.purpose} needs an optional part: pip install 'stillreach[{self.extra}]'"


class PageNotBuiltError(StillreachError, ImportError):
    """The program of the live page is missing: this installation was built without Node.js at hand."""

    def __str__(self) -> str:
        return (
            "the live page needs its program, which this installation was built without: install a wheel that has it, "
            "or run 'make page' in the sources and install them again"
        )


class SimulationInterrupted(StillreachError, KeyboardInterrupt):
    """Ctrl-C ended a simulation; nothing that was computed is lost.

    Args:
        run: the ``Run`` up to the last computed tick; of ``compare`` the ``Comparison`` up to there.
    """

    def __init__(self, run: Any) -> None:
        super().__init__(run)
        self.run = run

    def __str__(self) -> str:
        return "the simulation was interrupted; the ticks computed so far are in .run"
